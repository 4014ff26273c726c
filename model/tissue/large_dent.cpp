// SPDX-License-Identifier: MIT

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <ranges>

#include "model/tissue/contact_size.hpp"

namespace palpate {

namespace {

using Eigen::VectorXd;

/// Entries of F that a deformation without rotation about the axis has: rr, rz, zr, zz and that
/// around the axis.
using Gradient = Eigen::Matrix<double, 5, 1>;

/// Point of quadrature in a ring of four nodes.
struct RingPoint {
  Eigen::Matrix<double, 5, 8> slope;  ///< of F over the displacements (r, z of each node) [1/m]
  double weight = 0.0;                ///< volume [m^3]
};

struct Ring {
  std::array<int, 4> node{};
  std::array<RingPoint, 4> points{};
  double volume = 0.0;
  double mu = 0.0;      ///< [Pa]
  double lambda = 0.0;  ///< [Pa]
};

/// Appends places up to `end`, at distances that begin near `step` and grow by `growth`. Returns
/// the last distance.
double add_places(std::vector<double>& places, double end, double step, double growth) {
  const double begin = places.back();
  const double length = end - begin;
  const double count =
      std::max(1.0, std::round(std::log1p((growth - 1.0) * length / step) / std::log(growth)));
  const double first = length * (growth - 1.0) / (std::pow(growth, count) - 1.0);
  double at = begin;
  double size = first;
  for (double n = 1.0; n < count; n += 1.0) {
    places.push_back(at += size);
    size *= growth;
  }
  places.push_back(end);
  return size;
}

/// Axisymmetric block of neo-Hookean layers under a disc with the pressure of a rigid flat punch
/// on top of one of them (model/EQUATIONS.md, "Large dent of a skin"). Each ring has one mean
/// change of volume. Those about an inner membrane, which bends over many times its thickness, have
/// the shear of their centre: with that of each point they would be too stiff.
class PressedLayers {
 public:
  PressedLayers(const std::vector<ColumnLayer>& layers, std::size_t pressed, double radius,
                double tolerance)
      : tolerance_(tolerance), inner_(pressed > 0) {
    // Rings that do not lock may be coarser: with 1.1 the dura's dent is 0.4 % larger, in twice the
    // time.
    const double growth = inner_ ? 1.2 : 1.1;
    const double thickness = layers[pressed].thickness;
    std::vector<double> r{0.0, 0.5 * radius, radius};
    double depth = 0.0;
    for (const ColumnLayer& layer : layers) { depth += layer.thickness; }
    add_places(r, 2.5 * depth + 20.0 * thickness, 0.5 * radius, growth);
    std::vector<double> above{0.0};  // places above the tip, upwards
    double step = 0.25 * thickness;
    for (std::size_t n = pressed; n-- > 0;) {
      step = add_places(above, above.back() + layers[n].thickness, step, growth);
    }
    std::vector<double> z;
    for (const double height : above | std::views::reverse) { z.push_back(-height); }
    step = 0.25 * thickness;
    for (std::size_t n = pressed; n < layers.size(); ++n) {
      const double end = (n == pressed ? 0.0 : z.back()) + layers[n].thickness;
      step = add_places(z, end, step, n == pressed ? 1.0 + 1e-9 : growth);
    }
    columns_ = static_cast<int>(r.size());
    coordinate_.assign(2 * r.size() * z.size(), -1);
    for (std::size_t n = 0; n + 1 < z.size(); ++n) {
      for (std::size_t k = 0; k + 1 < r.size(); ++k) {
        if (k > 0) { coordinate_[2 * (n * r.size() + k)] = count_++; }
        coordinate_[2 * (n * r.size() + k) + 1] = count_++;
      }
    }
    std::size_t of = 0;
    double below = z.front() + layers.front().thickness;
    for (std::size_t n = 0; n + 1 < z.size(); ++n) {
      while (0.5 * (z[n] + z[n + 1]) > below) { below += layers[++of].thickness; }
      for (std::size_t k = 0; k + 1 < r.size(); ++k) { add_ring(layers[of], r, z, n, k); }
    }
    spread_pressure(radius, r, above.size() - 1);
    displacement_.setZero(count_);
    assemble(displacement_);
    factors_.analyzePattern(stiffness_);
  }

  /// Returns the mean dent, with the weight of the pressure, under a force that exceeds that of the
  /// call before; empty without equilibrium [m].
  std::optional<double> press(double force, int halvings = 3) {
    std::optional<double> dent = settle(force);
    if (!dent && halvings > 0 && press(0.5 * (pressed_ + force), halvings - 1)) {
      dent = press(force, halvings - 1);
    }
    return dent;
  }

 private:
  /// Solves for equilibrium from that of the call before; returns the dent [m].
  std::optional<double> settle(double force) {
    VectorXd at = displacement_;
    for (int n = 0; n < 40; ++n) {
      if (!assemble(at)) { return std::nullopt; }
      const VectorXd residual = force * weight_ - force_;
      if (residual.lpNorm<Eigen::Infinity>() < tolerance_) {
        displacement_ = at;
        pressed_ = force;
        return weight_.dot(at);
      }
      factors_.factorize(stiffness_);
      if (factors_.info() != Eigen::Success) { return std::nullopt; }
      const VectorXd change = factors_.solve(residual);
      double part = 1.0;
      while (!is_upright(at + part * change)) {
        part *= 0.5;
        if (part < 1e-3) { return std::nullopt; }
      }
      at += part * change;
    }
    return std::nullopt;
  }

  void add_ring(const ColumnLayer& layer, const std::vector<double>& r,
                const std::vector<double>& z, std::size_t n, std::size_t k) {
    const int first = static_cast<int>(n) * columns_ + static_cast<int>(k);
    Ring ring{.node = {first, first + 1, first + columns_ + 1, first + columns_}};
    ring.mu = 0.5 * layer.youngs_modulus / (1.0 + layer.poissons_ratio);
    ring.lambda = 2.0 * ring.mu * layer.poissons_ratio / (1.0 - 2.0 * layer.poissons_ratio);
    const double width = r[k + 1] - r[k];
    const double height = z[n + 1] - z[n];
    const double place = 0.5 / std::numbers::sqrt3;
    std::size_t point = 0;
    for (const double q : {0.5 - place, 0.5 + place}) {
      for (const double p : {0.5 - place, 0.5 + place}) {
        const std::array<double, 4> shape{(1 - p) * (1 - q), p * (1 - q), p * q, (1 - p) * q};
        const std::array<double, 4> over_r{-(1 - q), 1 - q, q, -q};
        const std::array<double, 4> over_z{-(1 - p), -p, p, 1 - p};
        const double radius = r[k] + p * width;
        RingPoint& here = ring.points[point++];
        here.slope.setZero();
        for (int a = 0; a < 4; ++a) {
          const auto i = static_cast<std::size_t>(a);
          here.slope(0, 2 * a) = over_r[i] / width;
          here.slope(3, 2 * a + 1) = over_z[i] / height;
          here.slope(2, 2 * a + 1) = (inner_ ? std::copysign(0.5, over_r[i]) : over_r[i]) / width;
          here.slope(1, 2 * a) = (inner_ ? std::copysign(0.5, over_z[i]) : over_z[i]) / height;
          here.slope(4, 2 * a) = shape[i] / radius;
        }
        here.weight = 0.5 * std::numbers::pi * radius * width * height;
        ring.volume += here.weight;
      }
    }
    rings_.push_back(ring);
  }
  /// Distributes a unit force over the nodes of a row.
  void spread_pressure(double radius, const std::vector<double>& r, std::size_t row) {
    weight_.setZero(count_);
    constexpr int circles = 400;  // of equal force
    for (int n = 0; n < circles; ++n) {
      const double share = (n + 0.5) / circles;
      const double at = radius * std::sqrt(share * (2.0 - share));
      const std::size_t k = at < r[1] ? 0 : 1;
      const double part = (at - r[k]) / (r[k + 1] - r[k]);
      const std::size_t node = row * r.size() + k;
      weight_(coordinate_[2 * node + 1]) += (1.0 - part) / circles;
      weight_(coordinate_[2 * node + 3]) += part / circles;
    }
  }
  [[nodiscard]] Eigen::Matrix<double, 8, 1> of_ring(const Ring& ring, const VectorXd& u) const {
    Eigen::Matrix<double, 8, 1> own;
    for (int a = 0; a < 8; ++a) {
      const int at = coordinate_of(ring, a);
      own(a) = at < 0 ? 0.0 : u(at);
    }
    return own;
  }
  [[nodiscard]] int coordinate_of(const Ring& ring, int a) const {
    return coordinate_[static_cast<std::size_t>(2 * ring.node[static_cast<std::size_t>(a / 2)] +
                                                a % 2)];
  }
  [[nodiscard]] static Gradient deformation(const RingPoint& point,
                                            const Eigen::Matrix<double, 8, 1>& own) {
    return Gradient{1.0, 0.0, 0.0, 1.0, 1.0} + point.slope * own;
  }
  [[nodiscard]] static double volume_ratio(const Gradient& f) {
    return (f(0) * f(3) - f(1) * f(2)) * f(4);
  }
  /// Returns true if no ring is inside out.
  [[nodiscard]] bool is_upright(const VectorXd& u) const {
    return std::ranges::all_of(rings_, [&](const Ring& ring) {
      const auto own = of_ring(ring, u);
      return std::ranges::all_of(ring.points, [&](const RingPoint& point) {
        const Gradient f = deformation(point, own);
        return volume_ratio(f) > 0.0 && f(4) > 0.0;
      });
    });
  }
  /// Computes the forces of the layers and their stiffness. Returns false if they are not finite.
  bool assemble(const VectorXd& u) {
    entries_.clear();
    force_.setZero(count_);
    for (const Ring& ring : rings_) {
      const auto own = of_ring(ring, u);
      Eigen::Matrix<double, 8, 1> force = Eigen::Matrix<double, 8, 1>::Zero();
      Eigen::Matrix<double, 8, 8> stiffness = Eigen::Matrix<double, 8, 8>::Zero();
      double mean = 0.0;  // of the change of volume
      Eigen::Matrix<double, 8, 1> mean_slope = force;
      Eigen::Matrix<double, 8, 8> mean_curve = stiffness;
      for (const RingPoint& point : ring.points) {
        const Gradient f = deformation(point, own);
        const double j = volume_ratio(f);
        const double plane = f(0) * f(3) - f(1) * f(2);
        const Gradient over_f{f(3) * f(4), -f(2) * f(4), -f(1) * f(4), f(0) * f(4), plane};
        Eigen::Matrix<double, 5, 5> curve = Eigen::Matrix<double, 5, 5>::Zero();
        curve(0, 3) = curve(3, 0) = f(4);
        curve(1, 2) = curve(2, 1) = -f(4);
        curve(0, 4) = curve(4, 0) = f(3);
        curve(1, 4) = curve(4, 1) = -f(2);
        curve(2, 4) = curve(4, 2) = -f(1);
        curve(3, 4) = curve(4, 3) = f(0);
        force += point.weight * ring.mu * (point.slope.transpose() * (f - over_f / j));
        const Eigen::Matrix<double, 5, 5> tangent = Eigen::Matrix<double, 5, 5>::Identity() +
                                                    over_f * over_f.transpose() / (j * j) -
                                                    curve / j;
        stiffness += point.weight * ring.mu * (point.slope.transpose() * tangent * point.slope);
        mean += point.weight / ring.volume * j;
        mean_slope += point.weight / ring.volume * (point.slope.transpose() * over_f);
        mean_curve += point.weight / ring.volume * (point.slope.transpose() * curve * point.slope);
      }
      const double pressure = ring.volume * ring.lambda * (mean - 1.0);
      force += pressure * mean_slope;
      stiffness +=
          pressure * mean_curve + ring.volume * ring.lambda * mean_slope * mean_slope.transpose();
      add(ring, force, stiffness);
    }
    stiffness_.resize(count_, count_);
    stiffness_.setFromTriplets(entries_.begin(), entries_.end());
    return force_.allFinite();
  }
  void add(const Ring& ring, const Eigen::Matrix<double, 8, 1>& force,
           const Eigen::Matrix<double, 8, 8>& stiffness) {
    for (int a = 0; a < 8; ++a) {
      const int row = coordinate_of(ring, a);
      if (row < 0) { continue; }
      force_(row) += force(a);
      for (int b = 0; b < 8; ++b) {
        const int column = coordinate_of(ring, b);
        if (column >= 0 && column <= row) { entries_.emplace_back(row, column, stiffness(a, b)); }
      }
    }
  }

  double tolerance_;  ///< of the residual [N]
  bool inner_;        ///< tissue lies above the pressed layer
  int columns_ = 0;
  int count_ = 0;                ///< of free coordinates
  std::vector<int> coordinate_;  ///< of r and z of each node; -1: held
  std::vector<Ring> rings_;
  VectorXd weight_;  ///< share of each coordinate in the force on the disc
  VectorXd displacement_;
  double pressed_ = 0.0;  ///< force in equilibrium with it [N]
  VectorXd force_;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::SparseMatrix<double> stiffness_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;
};

}  // namespace

std::vector<double> large_dents(const std::vector<ColumnLayer>& layers, std::size_t pressed,
                                double radius, const std::vector<double>& forces) {
  PressedLayers block(layers, pressed, radius, 1e-9 * forces.back());
  std::vector<double> dents;
  for (const double force : forces) {
    const std::optional<double> dent = block.press(force);
    if (!dent) { return {}; }
    dents.push_back(*dent);
  }
  return dents;
}

}  // namespace palpate
