// SPDX-License-Identifier: MIT

#include "model/tissue/contact_size.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <span>

#include "model/problem/needle_path.hpp"
#include "model/tissue/lattice.hpp"
#include "model/tissue/tissue_grid.hpp"

namespace palpate {

namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using std::numbers::pi;

// Layers bonded to each other and to a rigid base. A layer has the stiffness of its upper face,
// then of its lower face, each with `size` coordinates.

template <int size> using FaceMatrix = Eigen::Matrix<double, size, size>;
template <int size> using LayerMatrix = Eigen::Matrix<double, 2 * size, 2 * size>;

/// Computes the stiffness of all that lies below each upper face.
template <int size>
void stack_up(const std::vector<LayerMatrix<size>>& layers, std::vector<FaceMatrix<size>>& below) {
  below.back() = layers.back().template topLeftCorner<size, size>();
  for (std::size_t n = layers.size() - 1; n-- > 0;) {
    const LayerMatrix<size>& s = layers[n];
    below[n] = s.template topLeftCorner<size, size>() -
               s.template topRightCorner<size, size>() *
                   (s.template bottomRightCorner<size, size>() + below[n + 1]).inverse() *
                   s.template bottomLeftCorner<size, size>();
  }
}

/// Returns the stiffness above the lower face of a layer from that above its upper face.
template <int size>
FaceMatrix<size> pass_down(const LayerMatrix<size>& s, const FaceMatrix<size>& above) {
  return s.template bottomRightCorner<size, size>() -
         s.template bottomLeftCorner<size, size>() *
             (s.template topLeftCorner<size, size>() + above).inverse() *
             s.template topRightCorner<size, size>();
}

// Continuum. A layer carries U(z) J1(k r) along r and W(z) J0(k r) along z.

/// Wavenumber times thickness below which a layer is computed with quadratic shape functions; the
/// exact matrix loses its digits there.
constexpr double thin = 0.05;

/// Returns the forces on the two faces of a thin layer with Lame's constants, as layer_stiffness().
/// The shape functions are linear from face to face and a parabola between them, without which the
/// layer could not bend like a plate: its thickness would not change.
Matrix4d thin_layer_stiffness(double lambda, double mu, double h, double k) {
  // Integrals over s = z / h of products of 1 - s, s and 4 s (1 - s), of their slopes, and of a
  // function (row) with a slope (column).
  const Matrix3d mass{{1.0 / 3.0, 1.0 / 6.0, 1.0 / 3.0},
                      {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0},
                      {1.0 / 3.0, 1.0 / 3.0, 8.0 / 15.0}};
  const Matrix3d slope{{1.0, -1.0, 0.0}, {-1.0, 1.0, 0.0}, {0.0, 0.0, 16.0 / 3.0}};
  const Matrix3d mixed{
      {-0.5, 0.5, 2.0 / 3.0}, {-0.5, 0.5, -2.0 / 3.0}, {-2.0 / 3.0, 2.0 / 3.0, 0.0}};
  // Energy of lambda (k U + W')^2 + 2 mu ((k U)^2 + W'^2) + mu (U' - k W)^2, divided by two.
  const double m = lambda + 2.0 * mu;
  Eigen::Matrix<double, 6, 6> all;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      all(2 * r, 2 * c) = m * k * k * h * mass(r, c) + mu / h * slope(r, c);
      all(2 * r + 1, 2 * c + 1) = mu * k * k * h * mass(r, c) + m / h * slope(r, c);
      all(2 * r, 2 * c + 1) = k * (lambda * mixed(r, c) - mu * mixed(c, r));
      all(2 * c + 1, 2 * r) = all(2 * r, 2 * c + 1);
    }
  }
  return all.topLeftCorner<4, 4>() - all.topRightCorner<4, 2>() *
                                         all.bottomRightCorner<2, 2>().inverse() *
                                         all.bottomLeftCorner<2, 4>();
}

/// Returns the forces on the two faces of a layer per unit of their displacements, for one
/// wavenumber; rows and columns: U and W of the upper face, then of the lower face.
Matrix4d layer_stiffness(const ColumnLayer& layer, double k) {
  const double mu = 0.5 * layer.youngs_modulus / (1.0 + layer.poissons_ratio);
  const double lambda = 2.0 * mu * layer.poissons_ratio / (1.0 - 2.0 * layer.poissons_ratio);
  const double h = layer.thickness;
  if (k * h < thin) { return thin_layer_stiffness(lambda, mu, h, k); }
  // Four solutions: (A + B Z) e^Z with Z = k (z - h), and (A + B Z) e^-Z with Z = k z, for A and B.
  const double kappa = (lambda + 3.0 * mu) / (lambda + mu);
  Matrix4d displacement;
  Matrix4d traction;
  for (int face = 0; face < 2; ++face) {
    const double outward = face == 0 ? -1.0 : 1.0;
    const int row = 2 * face;
    for (int solution = 0; solution < 4; ++solution) {
      const bool grows = solution < 2;
      const double a = solution % 2 == 0 ? 1.0 : 0.0;
      const double b = 1.0 - a;
      const double z = grows ? k * h * (face - 1) : k * h * face;
      const double decay = std::exp(grows ? z : -z);
      const double sign = grows ? 1.0 : -1.0;
      const double u = a + b * z;
      const double w = -sign * a + b * kappa - sign * b * z;
      const double u_slope = k * (sign * u + b);
      const double w_slope = k * (sign * w - sign * b);
      displacement(row, solution) = decay * u;
      displacement(row + 1, solution) = decay * w;
      traction(row, solution) = outward * decay * mu * (u_slope - k * w);
      traction(row + 1, solution) =
          outward * decay * (lambda * (k * u + w_slope) + 2.0 * mu * w_slope);
    }
  }
  return traction * displacement.inverse();
}

/// Returns W per unit of axial force at each interface above the base, for one wavenumber.
void respond(const std::vector<ColumnLayer>& layers, double k, std::vector<double>& response) {
  const std::size_t count = layers.size();
  std::vector<Matrix4d> stiffness(count);
  for (std::size_t n = 0; n < count; ++n) {
    const bool again = n > 0 && layers[n].thickness == layers[n - 1].thickness &&
                       layers[n].youngs_modulus == layers[n - 1].youngs_modulus &&
                       layers[n].poissons_ratio == layers[n - 1].poissons_ratio;
    stiffness[n] = again ? stiffness[n - 1] : layer_stiffness(layers[n], k);
  }
  std::vector<Matrix2d> below(count);
  stack_up<2>(stiffness, below);
  Matrix2d above = Matrix2d::Zero();
  for (std::size_t n = 0; n < count; ++n) {
    response[n] = (above + below[n]).inverse()(1, 1);
    above = pass_down<2>(stiffness[n], above);
  }
}

/// Nodes and weights of Gauss's rule with eight points on (-1, 1).
constexpr std::array<double, 4> gauss_node{0.1834346424956498, 0.5255324099163290,
                                           0.7966664774136267, 0.9602898564975363};
constexpr std::array<double, 4> gauss_weight{0.3626837833783620, 0.3137066458778873,
                                             0.2223810344533745, 0.1012285362903763};

constexpr int lobes = 24;

/// Calls add(k, weight) for the nodes of a quadrature over wavenumbers from 0 to `count` lobes of
/// the transform of a pressure of this radius, on layers of this depth.
template <class Add> void for_each_wave(double bottom, double radius, int count, Add add) {
  const auto add_panel = [&](double from, double to) {
    const double half = 0.5 * (to - from);
    for (std::size_t n = 0; n < gauss_node.size(); ++n) {
      for (const double side : {-1.0, 1.0}) {
        add(from + half * (1.0 + side * gauss_node[n]), half * gauss_weight[n]);
      }
    }
  };
  const double lobe = pi / radius;
  double from = 0.0;
  for (double to = std::min(0.5 / bottom, lobe); from < lobe; to = std::min(2.0 * to, lobe)) {
    add_panel(from, to);
    from = to;
  }
  for (int n = 1; n < count; ++n) { add_panel(n * lobe, (n + 1) * lobe); }
}

}  // namespace

std::vector<double> continuum_compliance(const std::vector<ColumnLayer>& layers, double radius,
                                         const std::vector<double>& depths) {
  std::vector<double> cuts{0.0};
  double bottom = 0.0;
  for (const ColumnLayer& layer : layers) { cuts.push_back(bottom += layer.thickness); }
  const double same = 1e-9 * bottom;
  for (const double depth : depths) {
    if (depth > 0.0 && depth < bottom) { cuts.push_back(depth); }
  }
  std::ranges::sort(cuts);
  std::vector<double> faces;  // upper faces of the sublayers, then the base
  for (const double cut : cuts) {
    if (faces.empty() || cut > faces.back() + same) { faces.push_back(cut); }
  }
  std::vector<ColumnLayer> sublayers;
  std::size_t of = 0;
  double end = layers.front().thickness;
  for (std::size_t n = 0; n + 1 < faces.size(); ++n) {
    const double middle = 0.5 * (faces[n] + faces[n + 1]);
    while (middle > end && of + 1 < layers.size()) { end += layers[++of].thickness; }
    sublayers.push_back(
        {faces[n + 1] - faces[n], layers[of].youngs_modulus, layers[of].poissons_ratio});
  }
  std::vector<double> response(sublayers.size());
  std::vector<double> sum(sublayers.size(), 0.0);
  const auto add = [&](double k, double weight) {
    respond(sublayers, k, response);
    const double disc = std::sin(k * radius) / (k * radius);
    for (std::size_t n = 0; n < sum.size(); ++n) {
      sum[n] += weight * k * disc * disc * response[n] / (2.0 * pi);
    }
  };
  for_each_wave(bottom, radius, lobes, add);
  // Beyond the last lobe k times the response is constant and sin^2 has the mean 1/2.
  const double last = lobes * pi / radius;
  respond(sublayers, last, response);
  std::vector<double> compliance;
  for (const double depth : depths) {
    const auto found = std::ranges::lower_bound(faces, depth - same);
    const auto n = static_cast<std::size_t>(found - faces.begin());
    compliance.push_back(n < sum.size() ? sum[n] + response[n] / (4.0 * pi * radius * radius)
                                        : 0.0);
  }
  return compliance;
}

std::vector<std::array<int, 2>> face_terms(const Probe& probe) {
  if (probe.face == Probe::FaceKind::uniform) { return {{0, 0}}; }
  constexpr int orders = 5;
  const bool round = probe.shape == Probe::Shape::fingertip;
  std::vector<std::array<int, 2>> terms;
  for (int m = 0; m < orders; ++m) {
    for (int n = 0; n < (round ? 1 : orders - m); ++n) { terms.push_back({m, n}); }
  }
  return terms;
}

FacePressure FaceCompliance::best_pressure() const {
  const Eigen::Index others = terms.cols() - 1;
  FacePressure pressure = FacePressure::Ones(others + 1);
  if (others == 0) { return pressure; }
  pressure.tail(others) =
      terms.bottomRightCorner(others, others).ldlt().solve(-terms.col(0).tail(others));
  return pressure;
}

double FaceCompliance::at(const FacePressure& pressure) const {
  return pressure.dot(terms * pressure);
}

namespace {

/// Fourier transforms of the terms of a face's pressure.
Eigen::VectorXd face_transforms(const Probe& probe, const std::vector<std::array<int, 2>>& orders,
                                double k, double angle) {
  const bool round = probe.shape == Probe::Shape::fingertip;
  const double x = 0.5 * k * probe.size.x() * (round ? 1.0 : std::cos(angle));
  const double y = 0.5 * k * probe.size.y() * std::sin(angle);
  if (probe.face == Probe::FaceKind::uniform) {
    return Eigen::VectorXd::Constant(
        1, round ? 2.0 * ::j1(x) / x : std::sph_bessel(0, x) * std::sph_bessel(0, y));
  }
  std::array<double, 8> along_x{};  // of each order; as many as face_terms() has, or more
  std::array<double, 8> along_y{};
  for (int n = 0; n <= orders.back()[0]; ++n) {
    const auto at = static_cast<std::size_t>(n);
    const double sign = n % 2 == 0 ? 1.0 : -1.0;
    const auto order = static_cast<unsigned>(2 * n);
    along_x[at] = round ? std::abs(std::legendre(order, 0.0)) * std::sph_bessel(order, x)
                        : sign * ::jn(2 * n, x);
    along_y[at] = round ? 1.0 : sign * ::jn(2 * n, y);
  }
  Eigen::VectorXd transform(std::ssize(orders));
  for (Eigen::Index n = 0; n < transform.size(); ++n) {
    const auto& order = orders[static_cast<std::size_t>(n)];
    transform(n) =
        along_x[static_cast<std::size_t>(order[0])] * along_y[static_cast<std::size_t>(order[1])];
  }
  return transform;
}

}  // namespace

FaceCompliance face_compliance(const std::vector<ColumnLayer>& layers, const Probe& probe) {
  const bool round = probe.shape == Probe::Shape::fingertip;
  const int directions = round ? 1 : 48;  // of a quarter turn, denser near the axes
  const double radius = round ? probe.radius() : 0.5 * probe.size.maxCoeff();
  const int count =
      round ? lobes : static_cast<int>(std::ceil(2.0 * lobes * radius / probe.size.minCoeff()));
  double bottom = 0.0;
  for (const ColumnLayer& layer : layers) { bottom += layer.thickness; }
  std::vector<double> response(layers.size());
  const auto orders = face_terms(probe);
  FaceCompliance face{Eigen::MatrixXd::Zero(std::ssize(orders), std::ssize(orders))};
  Eigen::MatrixXd square = face.terms;  // integral of k^2 times the transforms over the last lobe
  for_each_wave(bottom, radius, count, [&](double k, double weight) {
    respond(layers, k, response);
    Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(square.rows(), square.cols());
    for (int n = 0; n < directions; ++n) {
      const double s = (n + 0.5) / directions;
      const double part = round ? 1.0 : 6.0 * s * (1.0 - s) / directions;
      const Eigen::VectorXd transform =
          face_transforms(probe, orders, k, 0.5 * pi * s * s * (3.0 - 2.0 * s));
      mean += part * transform * transform.transpose();
    }
    face.terms += weight * k * response[0] / (2.0 * pi) * mean;
    if (k > (count - 1) * pi / radius) { square += weight * k * k * mean; }
  });
  // Beyond the last lobe k times the response and the means of those squares are constant.
  respond(layers, count * pi / radius, response);
  face.terms += response[0] * radius / (2.0 * pi * pi) * square;
  return face;
}

DentTable sphere_dents(const std::vector<ColumnLayer>& layers, const Probe& probe) {
  constexpr int radii = 48;
  constexpr double least = 0.03;  // of the radius of the face: a sharper sphere is too soft
  DentTable table{.multiple = {0.0}, .dent = {0.0}};
  Probe disc{.size = probe.size};
  double compliance = 0.0;
  for (int n = 0; n <= radii; ++n) {
    disc.size = std::pow(least, 1.0 - static_cast<double>(n) / radii) * probe.size;
    const Eigen::MatrixXd terms = face_compliance(layers, disc).terms;
    // The sphere's displacement per unit of D, and the rest per unit of a^2 / R.
    Eigen::MatrixXd shape = Eigen::MatrixXd::Zero(terms.rows(), 2);
    shape(0, 0) = 1.0;
    shape.col(1).head<2>() << -1.0 / 3.0, 1.0 / 15.0;
    const Eigen::MatrixXd pressure = terms.ldlt().solve(shape);
    Eigen::VectorXd edge(terms.rows());
    for (Eigen::Index i = 0; i < edge.size(); ++i) {
      edge(i) = std::legendre(static_cast<unsigned>(2 * i), 0.0);
    }
    const double curvature = disc.radius() * disc.radius() / *probe.tip_radius;
    const double dent = -curvature * edge.dot(pressure.col(1)) / edge.dot(pressure.col(0));
    const double force = dent * pressure(0, 0) + curvature * pressure(0, 1);
    compliance = 1.0 / pressure(0, 0);
    if (!(force > table.multiple.back()) || !(dent > table.dent.back())) { continue; }
    table.multiple.push_back(force);
    table.dent.push_back(dent);
  }
  table.step = table.multiple.back();
  for (double& force : table.multiple) { force /= table.step; }
  table.multiple.push_back(2.0);
  table.dent.push_back(table.dent.back() + compliance * table.step);
  return table;
}

std::vector<ProbeFace::Point> face_points(const Probe& probe, const FacePressure& pressure,
                                          const Eigen::Vector2d& spacing) {
  const Eigen::Vector2d half = 0.5 * probe.size;
  const double cells = (half.cwiseQuotient(spacing)).maxCoeff();
  constexpr double most = 64.0;  // points along one direction; enough for 5 cells in a radius
  const auto orders = face_terms(probe);
  const bool is_uniform = probe.face == Probe::FaceKind::uniform;
  std::vector<ProbeFace::Point> points;
  double total = 0.0;
  // `uniform` is the uniform pressure over the flat punch's, term(orders) that of a term.
  const auto add = [&](double x, double y, double part, double uniform, auto term) {
    double share = is_uniform ? uniform : 0.0;
    for (std::size_t n = 0; n < orders.size() && !is_uniform; ++n) {
      share += pressure(static_cast<Eigen::Index>(n)) * term(orders[n]);
    }
    points.push_back({half.cwiseProduct(Eigen::Vector2d(x, y)), part * share});
    total += points.back().share;
  };
  if (probe.shape == Probe::Shape::fingertip) {
    // Gauss's rule in sqrt(1 - r^2), with which a flat punch's force is uniform.
    const int panels =
        static_cast<int>(std::clamp(std::ceil(0.25 * cells * cells), 1.0, most / 8.0));
    const int spokes = 4 * static_cast<int>(std::clamp(std::ceil(pi * cells), 4.0, most / 4.0));
    for (int n = 0; n < 8 * panels * spokes; ++n) {
      const auto node = static_cast<std::size_t>(n / spokes % 4);
      const double side = n / spokes % 8 < 4 ? -1.0 : 1.0;
      const double u = (n / spokes / 8 + 0.5 + 0.5 * side * gauss_node[node]) / panels;
      const double r = std::sqrt(1.0 - u * u);
      const double angle = 2.0 * pi * (n % spokes + 0.5) / spokes;
      add(r * std::cos(angle), r * std::sin(angle), gauss_weight[node], u,
          [&](const std::array<int, 2>& order) {
            return std::legendre(static_cast<unsigned>(2 * order[0]), u);
          });
    }
  } else {
    const auto along = [&](int axis) {
      return static_cast<int>(
          std::clamp(2.0 * std::ceil(pi * half(axis) / spacing(axis)), 12.0, most));
    };
    const int nx = along(0);
    const int ny = along(1);
    for (int n = 0; n < nx * ny; ++n) {
      const double s = pi * (n % nx + 0.5) / nx;
      const double t = pi * (n / nx + 0.5) / ny;
      add(std::cos(s), std::cos(t), 1.0, std::sin(s) * std::sin(t),
          [&](const std::array<int, 2>& order) {
            return std::cos(2 * order[0] * s) * std::cos(2 * order[1] * t);
          });
    }
  }
  for (ProbeFace::Point& point : points) { point.share /= total; }
  return points;
}

namespace {

// Grid. A wave e^{i q . x} of displacements (i u_x, i u_y, u_z) has real stiffness, because the
// grid is symmetric about planes through its nodes.

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Stiffness of one layer of cells per unit of modulus for one wave; upper plane, then lower plane.
struct CellLayerStiffness {
  Matrix6d springs = Matrix6d::Zero();
  Matrix6d volume = Matrix6d::Zero();
};

CellLayerStiffness cell_layer(const Vector3d& spacing, int connectivity, const BoxBonds& bonds,
                              const Eigen::Vector2d& q) {
  CellLayerStiffness layer;
  const auto directions = bond_directions(connectivity);
  using Complex = std::complex<double>;
  const std::array<Complex, 3> unit{Complex(0.0, 1.0), Complex(0.0, 1.0), Complex(1.0, 0.0)};
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const Vector3d step(directions[d][0], directions[d][1], directions[d][2]);
    const Vector3d n = spacing.cwiseProduct(step).normalized();
    const bool flat = directions[d][2] == 0;
    // A bond within a plane belongs to the cells above and below it.
    const double k = flat ? 0.5 * bonds.stiffness[d] : bonds.stiffness[d];
    const Complex phase =
        std::polar(1.0, q.x() * spacing.x() * step.x() + q.y() * spacing.y() * step.y());
    Eigen::Matrix<Complex, 6, 1> grows;
    const auto add = [&] { layer.springs += (k * grows.conjugate() * grows.transpose()).real(); };
    for (int plane = 0; plane < (flat ? 2 : 1); ++plane) {
      grows.setZero();
      for (int axis = 0; axis < 3; ++axis) {
        const Complex along = n(axis) * unit[static_cast<std::size_t>(axis)];
        if (flat) {
          grows(3 * plane + axis) = along * (phase - 1.0);
        } else {
          grows(axis) = -along;
          grows(3 + axis) = along * phase;
        }
      }
      add();
    }
  }
  // Gradient of the mean volume of a cell: a corner's share is 1 / (4 h) along each axis.
  Eigen::Matrix<Complex, 6, 1> grows = Eigen::Matrix<Complex, 6, 1>::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d at(corner & 1, corner >> 1 & 1, corner >> 2);
    const Complex phase =
        std::polar(1.0, q.x() * spacing.x() * at.x() + q.y() * spacing.y() * at.y());
    for (int axis = 0; axis < 3; ++axis) {
      grows(3 * (corner >> 2) + axis) +=
          (at(axis) - 0.5) / (2.0 * spacing(axis)) * phase * unit[static_cast<std::size_t>(axis)];
    }
  }
  layer.volume = (spacing.prod() * grows.conjugate() * grows.transpose()).real();
  return layer;
}

/// Returns the squared magnitude of the Fourier transform of a plane's weights, and its product
/// with the next plane's, summed over the four signs of the wave vector.
PlaneCompliance spectrum(std::span<const PlaneSupport> own, std::span<const PlaneSupport> next,
                         const Eigen::Vector2d& q) {
  PlaneCompliance sum;
  const auto transform = [](std::span<const PlaneSupport> supports, const Eigen::Vector2d& at) {
    std::complex<double> total = 0.0;
    for (const PlaneSupport& s : supports) { total += std::polar(s.weight, at.dot(s.place)); }
    return total;
  };
  for (const double sign : {1.0, -1.0}) {  // the other two are complex conjugates
    const Eigen::Vector2d at(q.x(), sign * q.y());
    const auto here = transform(own, at);
    sum.own += 2.0 * std::norm(here);
    sum.next += 2.0 * (std::conj(here) * transform(next, at)).real();
  }
  return sum;
}

/// Returns the number of cells after which the grid repeats: four times its depth or the width of
/// the supports, within limits of work.
int period_of(const GridColumn& grid, const std::vector<PlaneSupport>& supports) {
  const auto planes = static_cast<double>(grid.spring_modulus.size());
  double width = 0.0;
  for (const PlaneSupport& s : supports) {
    width = std::max(width, 2.0 * s.place.cwiseAbs().maxCoeff());
  }
  const double reach = std::max(planes * grid.spacing.z(), width);
  const double wanted = 4.0 * reach / grid.spacing.head<2>().minCoeff();
  const double most = 2.0 * std::sqrt(4e5 / planes);
  return 2 * static_cast<int>(std::ceil(0.5 * std::clamp(std::min(wanted, most), 24.0, 256.0)));
}

}  // namespace

std::vector<PlaneCompliance> grid_compliance(
    const GridColumn& grid, const std::vector<std::vector<PlaneSupport>>& supports) {
  const std::size_t planes = grid.spring_modulus.size();
  const int period = period_of(grid, supports[0]);
  const BoxBonds bonds = box_bonds(grid.spacing, grid.connectivity);
  std::vector<PlaneCompliance> compliance(planes);
  std::vector<Matrix6d> layers(planes);
  std::vector<Matrix3d> below(planes);
  for (int j = 0; j < period / 2; ++j) {
    for (int i = 0; i < period / 2; ++i) {
      const Eigen::Vector2d q =
          2.0 * pi / period *
          Eigen::Vector2d(i + 0.5, j + 0.5).cwiseQuotient(grid.spacing.head<2>());
      const CellLayerStiffness unit = cell_layer(grid.spacing, grid.connectivity, bonds, q);
      for (std::size_t n = 0; n < planes; ++n) {
        layers[n] = grid.spring_modulus[n] * unit.springs + grid.volume_modulus[n] * unit.volume;
      }
      stack_up<3>(layers, below);
      Matrix3d above = Matrix3d::Zero();
      for (std::size_t n = 0; n < planes; ++n) {
        const Matrix3d response = (above + below[n]).inverse();
        const Matrix6d& s = layers[n];
        const bool has_next = n + 1 < planes;
        const PlaneCompliance weight =
            spectrum(supports[n], has_next ? supports[n + 1] : supports[n], q);
        compliance[n].own += weight.own * response(2, 2);
        if (has_next) {
          const Matrix3d carried = -(s.bottomRightCorner<3, 3>() + below[n + 1]).inverse() *
                                   s.bottomLeftCorner<3, 3>() * response;
          compliance[n].next += weight.next * carried(2, 2);
        }
        above = pass_down<3>(s, above);
      }
    }
  }
  const double waves = static_cast<double>(period) * period;
  for (PlaneCompliance& plane : compliance) {
    plane.own /= waves;
    plane.next /= waves;
  }
  return compliance;
}

namespace {

/// Part of the path of a tool between its first contact point, or the first one behind a gap, and
/// the rigid base or the next gap.
struct Column {
  std::vector<ColumnLayer> layers{};
  GridColumn grid{};
  std::vector<std::vector<PlaneSupport>> supports{};
  std::vector<double> planes{};  ///< depths of the planes along the path, the base included [m]
};

/// Returns the mean material of the path between two depths [m]; no parts without soft tissue.
MaterialMean mean_between(const NeedlePath& path, double begin, double end) {
  MaterialMean mean;
  for (const PathInterval& interval : path.tissue()) {
    const double part = std::min(end, interval.end) - std::max(begin, interval.begin);
    const bool soft = interval.youngs_modulus > 0.0 && interval.role != TissueRole::bone;
    if (!(part > 0.0) || !soft) { continue; }
    mean.add(part, {.youngs_modulus = interval.youngs_modulus,
                    .poissons_ratio = interval.poissons_ratio});
  }
  return mean;
}

std::vector<PlaneSupport> supports_about_axis(const NeedlePath& path, const NeedlePath::Knot& knot,
                                              const SpringNetwork& network) {
  std::vector<PlaneSupport> supports;
  const Eigen::Vector2d axis = (path.origin() + knot.depth * path.direction()).head<2>();
  for (const NeedlePath::Support& s : path.supports(knot)) {
    supports.push_back({network.rest_position.col(s.node).head<2>() - axis, s.weight});
  }
  return supports;
}

bool is_fixed(const NeedlePath& path, const NeedlePath::Knot& knot, const SpringNetwork& network) {
  return std::ranges::all_of(
      path.supports(knot), [&](const NeedlePath::Support& s) { return network.is_fixed(s.node); });
}

/// Returns the depths of the planes of nodes below a tool's first contact point [m]. A probe has no
/// contact point but the first.
std::vector<double> planes_below(const NeedlePath& path, const NodeGrid& grid) {
  std::vector<double> planes;
  if (path.knots().size() > 1) {
    for (const NeedlePath::Knot& knot : path.knots()) { planes.push_back(knot.depth); }
    return planes;
  }
  const double first = path.knots().front().depth;
  const double bottom = grid.first.z() + grid.spacing.z() * (grid.count[2] - 1);
  for (double z = first; z < bottom + 0.5 * grid.spacing.z(); z += grid.spacing.z()) {
    planes.push_back(z);
  }
  return planes;
}

/// Returns the number of neighbours of a node inside a grid.
int connectivity_of(const SpringList& springs) {
  std::uint32_t most = 0;
  for (const SpringList::Run& run : springs.runs()) { most = std::max(most, run.bonds); }
  return most > 9 ? 26 : most > 3 ? 18 : 6;
}

/// Returns the columns of tissue under a tool; none if its material is unknown. What lies behind
/// the last plane before a gap counts as rigid.
std::vector<Column> columns_of(const NeedlePath& path, const SpringNetwork& network,
                               const NodeGrid& grid) {
  const bool needle = path.knots().size() > 1;
  const double bone = bone_depth(path.tissue());
  const std::vector<double> planes = planes_below(path, grid);
  std::vector<Column> columns;
  bool base = false;
  for (std::size_t n = 0; n + 1 < planes.size() && !base; ++n) {
    Column column{
        .grid = {.spacing = grid.spacing, .connectivity = connectivity_of(network.springs)}};
    for (;; ++n) {
      base = n + 1 == planes.size() || planes[n] >= bone ||
             (needle && is_fixed(path, path.knots()[n], network));
      column.planes.push_back(planes[n]);
      if (base) { break; }
      const MaterialMean mean = mean_between(path, planes[n], planes[n + 1]);
      if (!(mean.parts() > 0.0)) { break; }
      const CellMaterial material = mean.mean();
      column.grid.spring_modulus.push_back(material.spring_modulus());
      column.grid.volume_modulus.push_back(material.volume_modulus());
      column.supports.push_back(needle || n == 0
                                    ? supports_about_axis(path, path.knots()[n], network)
                                    : std::vector<PlaneSupport>());
    }
    column.layers = layers_between(path.tissue(), column.planes.front(),
                                   std::min(bone, column.planes.back()), path.direction().z());
    if (!column.layers.empty() && !column.supports.empty()) {
      columns.push_back(std::move(column));
    }
    if (!needle) { break; }  // a probe stays in front of every gap
  }
  return columns;
}

}  // namespace

std::vector<ColumnLayer> layers_between(const std::vector<PathInterval>& tissue, double begin,
                                        double end, double slope) {
  std::vector<ColumnLayer> layers;
  for (const PathInterval& interval : tissue) {
    const double length = std::min(interval.end, end) - std::max(interval.begin, begin);
    if (!(length > 0.0)) { continue; }
    if (!(interval.youngs_modulus > 0.0)) { break; }
    layers.push_back({length * slope, interval.youngs_modulus, interval.poissons_ratio});
  }
  return layers;
}

double bone_depth(const std::vector<PathInterval>& tissue) {
  const auto bone = std::ranges::find(tissue, TissueRole::bone, &PathInterval::role);
  return bone == tissue.end() ? std::numeric_limits<double>::infinity() : bone->begin;
}

double DentLaw::dent(double gap) const noexcept {
  const double grid = 1.0 - compliance / continuum;
  const double a = grid * (1.0 - slope_at_rest) / (2.0 * toe);
  const double b = 1.0 - grid * slope_at_rest;
  const double end = toe * (b - a * toe);
  if (gap >= end) { return toe + (gap - end) / (1.0 - grid); }
  return 2.0 * gap / (b + std::sqrt(b * b - 4.0 * a * gap));
}

double DentLaw::at_dent(double dent) const noexcept {
  if (dent >= toe) { return (dent - 0.5 * (1.0 - slope_at_rest) * toe) / continuum; }
  return dent * (slope_at_rest + 0.5 * (1.0 - slope_at_rest) * dent / toe) / continuum;
}

namespace {

/// Returns the value of a table at a place: linear between depths, constant beyond.
double between(const std::vector<double>& depth, const std::vector<double>& value, double place) {
  if (value.empty()) { return 0.0; }
  const auto high =
      static_cast<std::size_t>(std::ranges::upper_bound(depth, place) - depth.begin());
  if (high == 0) { return value.front(); }
  if (high == value.size()) { return value.back(); }
  const double share = (place - depth[high - 1]) / (depth[high] - depth[high - 1]);
  return value[high - 1] + share * (value[high] - value[high - 1]);
}

/// Returns the index of the part of a table in which a value lies. The first and the last part are
/// unbounded.
std::size_t part_of(const std::vector<double>& ascending, double value) {
  const auto above = std::ranges::upper_bound(ascending, value) - ascending.begin();
  return static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(above - 1, 0, std::ssize(ascending) - 2));
}

/// Returns the value at a force of values at multiples of a step, linear between them and beyond.
double at_force(const DentTable& table, const std::vector<double>& value, double force) {
  const std::vector<double>& at = table.multiple;
  const double multiple = force / table.step;
  const std::size_t n = part_of(at, multiple);
  return value[n] + (multiple - at[n]) / (at[n + 1] - at[n]) * (value[n + 1] - value[n]);
}

}  // namespace

double DentTable::phi(double force) const noexcept { return at_force(*this, linear_force, force); }

std::array<double, 2> DentTable::force_of(double phi) const noexcept {
  const std::size_t n = part_of(linear_force, phi);
  const double slope =
      step * (multiple[n + 1] - multiple[n]) / (linear_force[n + 1] - linear_force[n]);
  return {multiple[n] * step + slope * (phi - linear_force[n]), slope};
}

double DentTable::work(double force) const noexcept {
  double work = 0.0;
  double before = 0.0;
  for (std::size_t n = 1; n < linear_force.size() && before < force; ++n) {
    const bool last = n + 1 == linear_force.size();
    const double to = last ? force : std::min(force, multiple[n] * step);
    work += 0.5 * (linear_force[n] - linear_force[n - 1]) /
            (step * (multiple[n] - multiple[n - 1])) * (to * to - before * before);
    before = to;
  }
  return work;
}

double DentTable::least_compliance() const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t n = 1; n < linear_force.size(); ++n) {
    least = std::min(
        least, (linear_force[n] - linear_force[n - 1]) / (step * (multiple[n] - multiple[n - 1])));
  }
  return least * std::ranges::min(compliance);
}

void DentTable::set_gaps(double unit, const std::vector<double>& own, double least) {
  linear_force = {0.0};
  for (std::size_t n = 1; n < dent.size(); ++n) {
    const double more = least * step * (multiple[n] - multiple[n - 1]);
    linear_force.push_back(std::max(linear_force.back() + more, (dent[n] - own[n]) / unit));
  }
}

void DentTable::complete(const PathInterval& layer, const std::vector<double>& depth,
                         const std::vector<double>& lacking, const std::vector<double>& own,
                         double own_end) {
  const double begin = layer.begin;
  const double end = layer.end;
  const double unit = between(depth, lacking, begin);
  set_gaps(unit, own, least_slope);
  // Through the layer the dents change as in small deformation, but to the end's.
  const double force = phi(layer.cutting_force);
  if (!(force > 0.0)) {  // a tip that cuts without force dents nothing
    compliance = lacking;
    return;
  }
  const double beyond = unit * (layer.cutting_force - force);
  const double at_end = between(depth, lacking, end) * layer.cutting_force - beyond;
  const double ramp = (end_dent - own_end - at_end) / (end - begin);
  compliance.clear();
  for (std::size_t n = 0; n < depth.size(); ++n) {
    const double gap = lacking[n] * layer.cutting_force - beyond +
                       ramp * (std::clamp(depth[n], begin, end) - begin);
    compliance.push_back(std::max(gap / force, least_slope * unit));
  }
}

double DentLaw::force(double gap) const noexcept {
  if (table != nullptr) { return table->force_of(gap / compliance)[0]; }
  if (toe == 0.0) { return gap / compliance; }
  return gap > 0.0 ? at_dent(dent(gap)) : gap * slope(0.0);
}

double DentLaw::slope(double gap) const noexcept {
  if (table != nullptr) { return table->force_of(gap / compliance)[1] / compliance; }
  if (toe == 0.0) { return 1.0 / compliance; }
  const double share = std::min(dent(std::max(gap, 0.0)) / toe, 1.0);
  const double of_dent = (slope_at_rest + (1.0 - slope_at_rest) * share) / continuum;
  return of_dent / (1.0 - of_dent * (continuum - compliance));
}

double DentLaw::gap(double force) const noexcept {
  if (table != nullptr) { return compliance * table->phi(force); }
  if (toe == 0.0) { return compliance * force; }
  const double flat = continuum * force;  // dent of a flat punch
  const double straight = flat - 0.5 * (1.0 + slope_at_rest) * toe;
  const double dent =
      straight > 0.0 ? toe + straight
                     : 2.0 * flat /
                           (slope_at_rest + std::sqrt(slope_at_rest * slope_at_rest +
                                                      2.0 * (1.0 - slope_at_rest) * flat / toe));
  return dent - (continuum - compliance) * force;
}

double DentLaw::energy(double gap) const noexcept {
  const double tip = force(gap);
  if (table != nullptr) { return compliance * table->work(tip); }
  if (toe == 0.0) { return 0.5 * compliance * tip * tip; }
  const double all = dent(std::max(gap, 0.0));
  const double bent = std::min(all, toe);
  const double straight = all - bent;
  const double work =
      bent * bent * (0.5 * slope_at_rest + (1.0 - slope_at_rest) * bent / (6.0 * toe)) / continuum +
      straight * (at_dent(toe) + 0.5 * straight / continuum);
  return work - 0.5 * (continuum - compliance) * tip * tip;
}

double TipCompliance::at(double place) const noexcept { return between(depth, value, place); }

bool TipCompliance::is_linear() const noexcept {
  return of_continuum.empty() && std::ranges::none_of(tables, &DentTable::is_complete);
}

DentLaw TipCompliance::law(double place, double toe, std::size_t interval) const noexcept {
  if (value.empty()) { return {}; }
  const auto table = std::ranges::find(tables, interval, &DentTable::interval);
  if (table != tables.end() && table->is_complete()) {
    return {.compliance = between(depth, table->compliance, place), .table = &*table};
  }
  return {at(place), toe > 0.0 ? between(depth, of_continuum, place) : 0.0, toe};
}

double TipCompliance::next(double place) const noexcept {
  const auto high = std::ranges::upper_bound(depth, place);
  return high == depth.end() ? std::numeric_limits<double>::infinity() : *high;
}

namespace {

/// Returns the depths at which the compliance is computed, from the first plane to the base [m]:
/// eight per radius or cell, the planes of nodes and the borders of layers, where it bends.
std::vector<double> depths_of(const NeedlePath& path, const std::vector<double>& planes,
                              double step) {
  const double first = planes.front();
  if (path.knots().size() == 1) { return {first}; }
  constexpr double most_values = 800.0;
  const double length = planes.back() - first;
  const double count = std::ceil(std::min(length / step, most_values));
  std::vector<double> all = planes;
  for (double n = 1.0; n < count; n += 1.0) { all.push_back(first + n * length / count); }
  for (const PathInterval& interval : path.intervals()) {
    if (interval.begin > first && interval.begin < planes.back()) { all.push_back(interval.begin); }
  }
  std::ranges::sort(all);
  std::vector<double> depths;
  const double same = 1e-9 * length;
  for (const double depth : all) {
    if (depths.empty() || depth > depths.back() + same) { depths.push_back(depth); }
  }
  return depths;
}

/// Returns the dents of an interval of the path that is dented deeper than it is thick before it is
/// cut, and is stiff enough to resist by its tension: a first layer, or a thin one between softer
/// ones. `layer` is its place in the column. Without dents, but with a step, the contact cannot
/// follow such a dent: the layer is too soft, or its force is out of reach of the layers' law.
DentTable large_dent(const std::vector<PathInterval>& intervals, std::size_t interval, double slope,
                     const std::vector<ColumnLayer>& layers, std::size_t layer, double radius,
                     const std::vector<double>& continuum, const TipCompliance& tip) {
  constexpr int steps = 8;
  constexpr double least_contrast = 3.0;  // with the layers beside it
  const bool inner = layer > 0;
  const bool after_gap = interval > 0 && !inner;
  if (after_gap || interval + 1 >= intervals.size() || layer + 1 >= layers.size()) { return {}; }
  const PathInterval& skin = intervals[interval];
  const double force = std::max(skin.puncture_force, skin.cutting_force);
  const double thickness = (skin.end - skin.begin) * slope;
  const double soft = between(tip.depth, continuum, skin.begin);
  if (skin.indentation_toe > 0.0 || !std::isfinite(force) || !(force * soft > thickness)) {
    return {};
  }
  DentTable large{.interval = interval, .step = force / steps, .small_dent = force * soft};
  const auto outweighs = [&](const ColumnLayer& other) {
    return skin.youngs_modulus >= least_contrast * other.youngs_modulus;
  };
  if (inner && (thickness > tip.spacing || skin.law.stiffens() || !outweighs(layers[layer - 1]) ||
                !outweighs(layers[layer + 1]))) {
    return {};
  }
  if (!outweighs(layers[layer + 1])) { return large; }
  std::vector<double> forces{1e-3 * large.step};  // small deformation first
  for (int n = 1; n <= steps; ++n) { forces.push_back(n * large.step); }
  const std::vector<double> dents = large_dents(layers, layer, radius, forces);
  if (dents.empty()) { return large; }
  // Rings of finite size lack compliance close to the tip.
  const double missing = soft - dents[0] / forces[0];
  large.multiple = large.dent = {0.0};
  for (std::size_t n = 1; n < dents.size(); ++n) {
    large.multiple.push_back(static_cast<double>(n));
    large.dent.push_back(dents[n] + missing * forces[n]);
  }
  large.end_dent = at_force(large, large.dent, skin.cutting_force) +
                   (between(tip.depth, continuum, skin.end) - soft) * skin.cutting_force;
  return large;
}

}  // namespace

TipCompliance NeedlePath::tip_compliance(const Scene& scene, const SpringNetwork& network) const {
  const std::optional<NodeGrid> grid = tissue_grid(scene);
  if (!grid) { return {}; }
  const std::vector<Column> columns = columns_of(*this, network, *grid);
  if (columns.empty()) { return {}; }
  const double radius = scene.needle ? 0.5 * scene.needle->diameter : scene.probe->radius();
  TipCompliance tip{.spacing = grid->spacing.z()};
  std::vector<double> continuum;
  constexpr double least_share = 0.01;  // of c_continuum at the skin
  double negligible = 0.0;
  for (const Column& column : columns) {
    const std::vector<double> depths =
        depths_of(*this, column.planes, std::min(radius, grid->spacing.z()) / 8.0);
    std::vector<double> below;  // the first plane, along the tool
    for (const double depth : depths) { below.push_back((depth - depths[0]) * direction_.z()); }
    const std::vector<double> there =
        scene.needle ? continuum_compliance(column.layers, radius, below)
                     : std::vector{face_compliance(column.layers, *scene.probe).at(pressure_)};
    const std::vector<PlaneCompliance> planes = grid_compliance(column.grid, column.supports);
    if (continuum.empty()) {
      tip.continuum = there[0];
      tip.grid = planes[0].own;
      negligible = least_share * tip.continuum;
    }
    std::size_t plane = 0;
    for (std::size_t n = 0; n < depths.size(); ++n) {
      while (plane + 1 < planes.size() && column.planes[plane + 1] <= depths[n]) { ++plane; }
      const double thickness = column.planes[plane + 1] - column.planes[plane];
      const double share = std::clamp((depths[n] - column.planes[plane]) / thickness, 0.0, 1.0);
      const double next = plane + 1 < planes.size() ? planes[plane + 1].own : 0.0;
      const double of_grid = (1.0 - share) * (1.0 - share) * planes[plane].own +
                             2.0 * share * (1.0 - share) * planes[plane].next +
                             share * share * next;
      tip.value.push_back(std::max(there[n] - of_grid, 0.0));
      if (there[n] > negligible) { tip.excess = std::max(tip.excess, of_grid / there[n] - 1.0); }
    }
    tip.depth.insert(tip.depth.end(), depths.begin(), depths.end());
    continuum.insert(continuum.end(), there.begin(), there.end());
  }
  // The contact of a sliding face is never rigid, because the tissue at its edge enters at once,
  // nor is one with a toe or of a sphere.
  const bool toe = std::ranges::any_of(
      intervals_, [](const PathInterval& part) { return part.indentation_toe > 0.0; });
  const bool sphere = scene.probe && scene.probe->tip_radius;
  const bool soft = sliding_face_ || toe || sphere;
  if (!(std::ranges::max(tip.value) > negligible) && !soft) {
    tip.depth.clear();
    tip.value.clear();
    return tip;
  }
  double least = soft ? negligible : std::numeric_limits<double>::infinity();
  for (const double value : tip.value) {
    if (value > 0.0) { least = std::min(least, value); }
  }
  least = std::max(least, negligible);
  for (double& value : tip.value) { value = std::max(value, least); }
  for (std::size_t n = 0; toe && n < continuum.size(); ++n) {
    tip.of_continuum.push_back(std::max(continuum[n], tip.value[n]));
  }
  if (sphere) {
    DentTable table = sphere_dents(columns[0].layers, *scene.probe);
    std::vector<double> own;
    for (const double multiple : table.multiple) {
      own.push_back(tip.grid * multiple * table.step);
    }
    table.set_gaps(tip.continuum, own, least_share);
    table.compliance = {tip.continuum};
    tip.tables.push_back(std::move(table));
  }
  for (const Column& column : columns) {
    if (!scene.needle) { break; }
    std::size_t layer = 0;
    for (std::size_t n = 0; n < intervals_.size() && layer < column.layers.size(); ++n) {
      if (!(intervals_[n].end > column.planes.front())) { continue; }
      DentTable table =
          large_dent(intervals_, n, direction_.z(), column.layers, layer++, radius, continuum, tip);
      if (table.step > 0.0) { tip.tables.push_back(std::move(table)); }
    }
  }
  return tip;
}

}  // namespace palpate
