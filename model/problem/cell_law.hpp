// SPDX-License-Identifier: MIT
#pragma once
/// Energy of a cell that resists changes of its volume (model/EQUATIONS.md, "Cell volume"). Every
/// kernel instantiates its templates, for scalars or SIMD vectors; the other functions are called
/// outside kernels only.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

namespace palpate {

/// Vector with coordinates of type Number, which may be a SIMD vector.
template <class Number> struct Vector3Of {
  Number x, y, z;
  Vector3Of operator+(const Vector3Of& o) const { return {x + o.x, y + o.y, z + o.z}; }
  Vector3Of operator-(const Vector3Of& o) const { return {x - o.x, y - o.y, z - o.z}; }
  [[nodiscard]] Number dot(const Vector3Of& o) const { return x * o.x + y * o.y + z * o.z; }
  [[nodiscard]] Vector3Of cross(const Vector3Of& o) const {
    return {y * o.z - z * o.y, z * o.x - x * o.z, x * o.y - y * o.x};
  }
  [[nodiscard]] Vector3Of scaled(const Number& by) const { return {x * by, y * by, z * by}; }
};
/// Vectors at the corners of a cell; corner n is at (n & 1, n >> 1 & 1, n >> 2).
template <class Number> using Corners = std::array<Vector3Of<Number>, 8>;

/// Relative volume of a corner below which the cell resists collapse.
inline constexpr double collapse_begin = 0.3;
/// Below this fraction of collapse_begin the resistance grows linearly, so that it stays finite in
/// a cell that is flat or inside out.
inline constexpr double collapse_linear = 0.1;

/// First and second derivative by J of the collapse energy b(J) = -J_b (1 - s)^2 ln s, s = J / J_b,
/// per unit of modulus. Zero for J >= J_b = collapse_begin.
struct CollapseSlopes {
  double first = 0.0;
  double second = 0.0;
  double energy = 0.0;
  static CollapseSlopes at(double j) noexcept {
    if (!(j < collapse_begin)) { return {}; }
    const double s = std::fmax(j / collapse_begin, collapse_linear);
    const double rest = 1.0 - s;
    const double log = std::log(s);
    CollapseSlopes slopes{
        .first = 2.0 * rest * log - rest * rest / s,
        .second = (-2.0 * log + 4.0 * rest / s + rest * rest / (s * s)) / collapse_begin,
        .energy = -collapse_begin * rest * rest * log};
    const double below = std::fmin(j - collapse_linear * collapse_begin, 0.0);
    slopes.energy += below * (slopes.first + 0.5 * below * slopes.second);
    slopes.first += below * slopes.second;
    return slopes;
  }
};

/// The three edges at a corner, oriented so that a . (b x c) > 0 at rest, and their cross products:
/// the derivatives of that volume by the far ends of the edges.
template <class Number> struct CornerEdges {
  Vector3Of<Number> a, b, c;
  Vector3Of<Number> by_a, by_b, by_c;
  Number volume;  ///< a . (b x c), the cell's volume at rest [m^3]
};
/// Ends of the edges a, b, c of each corner. An odd corner lists two of them in reverse order,
/// which keeps the volume positive.
inline constexpr std::size_t corner_ends[8][3] = {{1, 2, 4}, {3, 0, 5}, {0, 3, 6}, {2, 1, 7},
                                                  {6, 5, 0}, {4, 7, 1}, {7, 4, 2}, {5, 6, 3}};
template <class Number>
CornerEdges<Number> edges_at(const Corners<Number>& x, std::size_t corner) noexcept {
  const auto& ends = corner_ends[corner];
  CornerEdges<Number> edges{
      x[ends[0]] - x[corner], x[ends[1]] - x[corner], x[ends[2]] - x[corner], {}, {}, {}, {}};
  edges.by_a = edges.b.cross(edges.c);
  edges.by_b = edges.c.cross(edges.a);
  edges.by_c = edges.a.cross(edges.b);
  edges.volume = edges.a.dot(edges.by_a);
  return edges;
}

/// Adds the derivative of a corner's volume by the eight corners, times `by`.
template <class Number>
void add_gradient(const CornerEdges<Number>& edges, std::size_t corner, const Number& by,
                  Corners<Number>& sum) noexcept {
  const auto& ends = corner_ends[corner];
  const Vector3Of<Number> a = edges.by_a.scaled(by);
  const Vector3Of<Number> b = edges.by_b.scaled(by);
  const Vector3Of<Number> c = edges.by_c.scaled(by);
  sum[ends[0]] = sum[ends[0]] + a;
  sum[ends[1]] = sum[ends[1]] + b;
  sum[ends[2]] = sum[ends[2]] + c;
  sum[corner] = sum[corner] - (a + b + c);
}

/// Constants of a cell, or of several in one vector.
template <class Number> struct CellNumbers {
  Number stiffness;  ///< kappa [Pa]
  Number viscosity;  ///< kappa tau [Pa s]
  Number collapse;   ///< beta, modulus of the resistance to collapse [Pa]
  Number volume;     ///< V0 [m^3]

  template <class To> [[nodiscard]] CellNumbers<To> as() const {
    return {static_cast<To>(stiffness), static_cast<To>(viscosity), static_cast<To>(collapse),
            static_cast<To>(volume)};
  }
};

/// First derivative of b by J; SIMD vectors specialise it.
template <class Number> struct CollapseSlope {
  static Number of(const Number& j) noexcept {
    return static_cast<Number>(CollapseSlopes::at(static_cast<double>(j)).first);
  }
};

/// Volumes of the corners of a deformed cell, and their mean in units of V0.
template <class Number> struct CellVolumes {
  std::array<CornerEdges<Number>, 8> corner;
  Number mean;  ///< J
};
template <class Number>
CellVolumes<Number> volumes_of(const Corners<Number>& x, const Number& rest_volume) noexcept {
  CellVolumes<Number> all;
  Number sum(0);
  for (std::size_t n = 0; n < 8; ++n) {
    all.corner[n] = edges_at(x, n);
    sum = sum + all.corner[n].volume;
  }
  all.mean = sum / (Number(8) * rest_volume);
  return all;
}

/// Returns the rate of J for velocities v of the corners [1/s].
template <class Number>
Number mean_rate(const CellVolumes<Number>& volumes, const Corners<Number>& v,
                 const Number& rest_volume) noexcept {
  Number sum(0);
  for (std::size_t n = 0; n < 8; ++n) {
    const auto& ends = corner_ends[n];
    const CornerEdges<Number>& edges = volumes.corner[n];
    sum = sum + edges.by_a.dot(v[ends[0]] - v[n]) + edges.by_b.dot(v[ends[1]] - v[n]) +
          edges.by_c.dot(v[ends[2]] - v[n]);
  }
  return sum / (Number(8) * rest_volume);
}

/// Pressure of a relaxing cell: share * kappa (J - 1) - held.
template <class Number> struct RelaxedCell {
  Number share;
  Number held;  ///< [Pa]
};

/// Adds the forces of a cell on its corners [N]; x [m], v [m/s]. v is unused unless `damped`,
/// `relaxed` is null unless the cell relaxes.
template <bool damped, class Number>
void add_cell_forces(const CellNumbers<Number>& cell, const Corners<Number>& x,
                     const Corners<Number>& v, Corners<Number>& f,
                     const RelaxedCell<Number>* relaxed = nullptr) noexcept {
  const CellVolumes<Number> volumes = volumes_of(x, cell.volume);
  Number pull = cell.stiffness * (volumes.mean - Number(1));
  if (relaxed != nullptr) { pull = relaxed->share * pull - relaxed->held; }
  if constexpr (damped) { pull = pull + cell.viscosity * mean_rate(volumes, v, cell.volume); }
  const Number eighth(0.125);
  for (std::size_t n = 0; n < 8; ++n) {
    const Number slope = CollapseSlope<Number>::of(volumes.corner[n].volume / cell.volume);
    add_gradient(volumes.corner[n], n, Number(eighth * (Number(0) - pull - cell.collapse * slope)),
                 f);
  }
}

/// Adds -C(x) w of a cell to the forces of its corners.
template <class Number>
void add_cell_damping(const CellNumbers<Number>& cell, const Corners<Number>& x,
                      const Corners<Number>& w, Corners<Number>& f) noexcept {
  const CellVolumes<Number> volumes = volumes_of(x, cell.volume);
  const Number pull = cell.viscosity * mean_rate(volumes, w, cell.volume) * Number(-0.125);
  for (std::size_t n = 0; n < 8; ++n) { add_gradient(volumes.corner[n], n, pull, f); }
}

/// Derivatives of the force of a cell by the positions and velocities of its corners, with the
/// opposite sign; rows and columns 3 n to 3 n + 2 belong to corner n.
template <class Real> struct CellGradient {
  using Matrix = Eigen::Matrix<Real, 24, 24>;
  Matrix position = Matrix::Zero();  ///< [N/m]
  Matrix velocity = Matrix::Zero();  ///< [N s/m]
};

template <class Real>
CellGradient<Real> cell_gradient(const CellNumbers<Real>& cell, const Corners<Real>& x,
                                 const Corners<Real>& v,
                                 const RelaxedCell<Real>& relaxed = {Real(1), Real(0)}) noexcept {
  using Numbers = Eigen::Matrix<Real, 24, 1>;
  using AllCorners = Eigen::Map<const Numbers>;
  static_assert(sizeof(Corners<Real>) == 24 * sizeof(Real));
  const CellVolumes<Real> volumes = volumes_of(x, cell.volume);
  const Real pull = relaxed.share * (cell.stiffness * (volumes.mean - Real(1))) - relaxed.held +
                    cell.viscosity * mean_rate(volumes, v, cell.volume);
  const Real share = Real(0.125) / cell.volume;
  CellGradient<Real> gradient;
  Numbers mean = Numbers::Zero();        // gradient of J
  Numbers mean_moved = Numbers::Zero();  // its rate for the velocities v
  for (std::size_t n = 0; n < 8; ++n) {
    const CornerEdges<Real>& edges = volumes.corner[n];
    const CollapseSlopes slopes =
        CollapseSlopes::at(static_cast<double>(edges.volume / cell.volume));
    Corners<Real> sum{};
    add_gradient(edges, n, Real(1), sum);
    const AllCorners own(&sum[0].x);
    mean += share * own;
    if (slopes.second != 0.0) {
      gradient.position +=
          (share * cell.collapse * static_cast<Real>(slopes.second)) * own * own.transpose();
    }
    // Derivative of a x b by its factors, for the three pairs of edges in turn.
    const auto& ends = corner_ends[n];
    const std::array<Vector3Of<Real>, 3> third{edges.c, edges.a, edges.b};
    const Real pressure = Real(0.125) * (pull + cell.collapse * static_cast<Real>(slopes.first));
    // Adds the matrix of w x, times `sign` and the pressure, and its effect on the rate of J.
    const auto put = [&](std::size_t row, std::size_t column, const Vector3Of<Real>& w, Real sign) {
      const auto r = static_cast<Eigen::Index>(3 * row);
      const auto c = static_cast<Eigen::Index>(3 * column);
      const Vector3Of<Real> by_pressure = w.scaled(sign * pressure);
      gradient.position(r, c + 1) -= by_pressure.z;
      gradient.position(r, c + 2) += by_pressure.y;
      gradient.position(r + 1, c) += by_pressure.z;
      gradient.position(r + 1, c + 2) -= by_pressure.x;
      gradient.position(r + 2, c) -= by_pressure.y;
      gradient.position(r + 2, c + 1) += by_pressure.x;
      const Vector3Of<Real> moved = w.scaled(sign * share).cross(v[column]);
      mean_moved[r] += moved.x;
      mean_moved[r + 1] += moved.y;
      mean_moved[r + 2] += moved.z;
    };
    for (std::size_t pair = 0; pair < 3; ++pair) {
      const std::size_t one = ends[pair];
      const std::size_t other = ends[(pair + 1) % 3];
      const auto add = [&](std::size_t row, std::size_t column, Real sign) {
        put(row, column, third[pair], sign);
        put(n, column, third[pair], -sign);
        put(row, n, third[pair], -sign);
        put(n, n, third[pair], sign);
      };
      add(one, other, Real(-1));
      add(other, one, Real(1));
    }
  }
  gradient.velocity = (cell.viscosity * cell.volume) * mean * mean.transpose();
  gradient.position += (relaxed.share * cell.stiffness * cell.volume) * mean * mean.transpose() +
                       (cell.viscosity * cell.volume) * mean * mean_moved.transpose();
  return gradient;
}

/// Returns the elastic energy of a cell [J].
inline double cell_energy(const CellNumbers<double>& cell, const Corners<double>& x) noexcept {
  const CellVolumes<double> volumes = volumes_of(x, cell.volume);
  double collapse = 0.0;
  for (const CornerEdges<double>& edges : volumes.corner) {
    collapse += CollapseSlopes::at(edges.volume / cell.volume).energy;
  }
  const double growth = volumes.mean - 1.0;
  return cell.volume * (0.5 * cell.stiffness * growth * growth + 0.125 * cell.collapse * collapse);
}

/// Returns the smallest volume of a corner in units of V0; at most zero in a cell that is inside
/// out.
inline double smallest_corner(const Corners<double>& x, double rest_volume) noexcept {
  double least = edges_at(x, 0).volume / rest_volume;
  for (std::size_t n = 1; n < 8; ++n) {
    least = std::fmin(least, edges_at(x, n).volume / rest_volume);
  }
  return least;
}

}  // namespace palpate
