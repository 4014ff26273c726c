// SPDX-License-Identifier: MIT

#include "reference/static_equilibrium.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <gsl/gsl_integration.h>
#include <gsl/gsl_sf_bessel.h>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "reference/exact_problems.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

using Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

constexpr const char* singular =
    "static equilibrium: the stiffness is singular; the body can move freely";

bool is_symmetric(const Sparse& matrix) {
  const Sparse transposed = matrix.transpose();
  return (matrix - transposed).norm() <= 1e-14 * matrix.norm();
}

/// Factors of a matrix. A solution includes one round of iterative refinement, which compensates
/// for stiffness contrasts. The residual also reveals a singular matrix that rounding hides in the
/// factors.
template <class Factors> struct Factorised {
  explicit Factorised(const Sparse& stiffness) : matrix(stiffness), factors(matrix) {}

  VectorXd operator()(const VectorXd& right) const {
    VectorXd x = factors.solve(right);
    x += factors.solve(right - matrix * x);
    const bool solved = (right - matrix * x).norm() <= 1e-6 * right.norm();
    if (!solved) { throw SolverError(singular); }
    return x;
  }

  Sparse matrix;
  Factors factors;
};

struct ConjugateGradients {
  ConjugateGradients(Sparse stiffness, int most_rounds) : matrix(std::move(stiffness)) {
    solver.setTolerance(1e-10);
    solver.setMaxIterations(most_rounds);
    solver.compute(matrix);
  }

  VectorXd operator()(const VectorXd& force) const {
    VectorXd x = solver.solve(force);
    if (solver.info() != Eigen::Success || !x.allFinite()) {
      throw NotConverged("conjugate gradients do not converge in " +
                         std::to_string(solver.maxIterations()) +
                         " rounds; the body may be free to move");
    }
    return x;
  }

  Sparse matrix;
  Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper> solver{};
};

using Solution = std::function<VectorXd(const VectorXd&)>;

/// Returns the function of a solver, which std::function would copy.
template <class LinearSolver> Solution shared(std::shared_ptr<LinearSolver> solver) {
  return [solver](const VectorXd& force) { return (*solver)(force); };
}

Solution solution_of(Sparse stiffness, Eigen::Index most_factorised, int most_rounds) {
  if (is_symmetric(stiffness)) {
    if (stiffness.rows() > most_factorised) {
      return shared(std::make_shared<ConjugateGradients>(std::move(stiffness), most_rounds));
    }
    const auto cholesky = std::make_shared<Factorised<Eigen::SimplicialLDLT<Sparse>>>(stiffness);
    const auto& factors = cholesky->factors;
    if (factors.info() == Eigen::Success &&
        factors.vectorD().minCoeff() > 1e-13 * factors.vectorD().maxCoeff()) {
      return shared(cholesky);
    }
  }
  const auto gauss = std::make_shared<Factorised<Eigen::SparseLU<Sparse>>>(stiffness);
  if (gauss->factors.info() != Eigen::Success) { throw SolverError(singular); }
  return shared(gauss);
}

}  // namespace

StaticResponse::StaticResponse(const Problem& problem, Eigen::Index most_factorised,
                               int most_rounds)
    : StaticResponse(LinearProblem(problem).stiffness(), most_factorised, most_rounds) {}

StaticResponse::StaticResponse(Sparse stiffness, Eigen::Index most_factorised, int most_rounds)
    : solve_(solution_of(std::move(stiffness), most_factorised, most_rounds)) {}

namespace {

class Residual {
 public:
  Residual(const Problem& problem, const EquilibriumOptions& options)
      : problem_(problem), options_(options), still_(VectorXd::Zero(problem.dof())) {}

  VectorXd operator()(const VectorXd& q) const {
    VectorXd f(problem_.dof());
    problem_.force(options_.time, options_.gate, q, still_, f);
    return f;
  }

  Sparse stiffness(const VectorXd& q) const {
    Sparse k, c;
    problem_.jacobian(q, still_, k, c);
    return k;
  }

 private:
  const Problem& problem_;
  const EquilibriumOptions& options_;
  VectorXd still_;
};

double largest(const VectorXd& f) {
  return f.allFinite() ? f.cwiseAbs().maxCoeff() : std::numeric_limits<double>::infinity();
}

/// Returns the change of the forces due to rounding of positions.
double rounding_floor(const Sparse& stiffness, const VectorXd& q) {
  const VectorXd size = stiffness.cwiseAbs() * q.cwiseAbs();
  return 8.0 * std::numeric_limits<double>::epsilon() * size.maxCoeff();
}

}  // namespace

Equilibrium static_equilibrium(const Problem& problem, const EquilibriumOptions& options) {
  return static_equilibrium(problem, options, problem.initial_position());
}

Equilibrium static_equilibrium(const Problem& problem, const EquilibriumOptions& options,
                               const VectorXd& start) {
  const Residual residual(problem, options);
  Equilibrium result{.position = start};
  VectorXd f = residual(start);
  const double first = largest(f);
  double now = first;
  while (now > options.tolerance * first) {
    if (result.iterations++ >= options.iteration_limit || !std::isfinite(now)) {
      throw SolverError("static equilibrium: no convergence, residual " + std::to_string(now) +
                        " N after " + std::to_string(options.iteration_limit) + " iterations");
    }
    const Sparse stiffness = residual.stiffness(result.position);
    const VectorXd step = StaticResponse(stiffness)(f);
    double length = 1.0;
    VectorXd trial = result.position + step;
    VectorXd trial_force = residual(trial);
    while (!(largest(trial_force) < now) && length > 1e-3) {
      length /= 2.0;
      trial = result.position + length * step;
      trial_force = residual(trial);
    }
    const bool better = largest(trial_force) < now;
    if (!better && now <= rounding_floor(stiffness, result.position)) { break; }
    result.position = trial;
    f = trial_force;
    now = largest(f);
  }
  result.residual = first > 0.0 ? now / first : 0.0;
  return result;
}

namespace {

/// Nodes and weights of Gauss's rule with `count` points on (0, end).
struct GaussRule {
  GaussRule(int count, double end) : node(count), weight(count) {
    const std::unique_ptr<gsl_integration_glfixed_table,
                          decltype(&gsl_integration_glfixed_table_free)>
        table(gsl_integration_glfixed_table_alloc(static_cast<std::size_t>(count)),
              gsl_integration_glfixed_table_free);
    for (int n = 0; n < count; ++n) {
      gsl_integration_glfixed_point(0.0, end, static_cast<std::size_t>(n), &node(n), &weight(n),
                                    table.get());
    }
  }
  VectorXd node;
  VectorXd weight;
};

/// Displacement of the surface of a layer under a pressure of wavenumber k over that of a half
/// space, for u = k times the thickness. It is 1 for large u.
double layer_over_half_space(double u, double nu) {
  const double c = 3.0 - 4.0 * nu;
  const double e2 = std::exp(-2.0 * u);  // sinh and cosh of 2 u, both times 2 e^-2u
  const double e4 = e2 * e2;
  return (c * (1.0 - e4) - 4.0 * u * e2) / (c * (1.0 + e4) + (4.0 * u * u + 1.0 + c * c) * e2);
}

/// Wavenumbers of a quadrature, and its weights times 1 - L(k).
struct Waves {
  std::vector<double> k;
  std::vector<double> gap;
};

/// Solution of phi(t) - 2/pi int_0^a int_0^inf (1 - L(k)) cos(k t) cos(k s) dk phi(s) ds = f(t).
struct Phi {
  double mean = 0.0;  ///< over (0, a)
  double edge = 0.0;  ///< phi(a); the pressure is singular at the edge unless it is zero
};
/// Solutions for f = 1, the unit dent of a flat face, and f = (t / a)^2, the shape of a sphere.
struct PhiPair {
  Phi flat;
  Phi curved;
};

PhiPair solve_phi(double radius, const Waves& waves, int points) {
  const GaussRule t(points, radius);
  const auto count = std::ssize(waves.k);
  const Eigen::Map<const VectorXd> k(waves.k.data(), count);
  const Eigen::Map<const VectorXd> gap(waves.gap.data(), count);
  Eigen::MatrixXd wave(points, count);
  for (Eigen::Index j = 0; j < count; ++j) { wave.col(j) = (k(j) * t.node).array().cos(); }
  const Eigen::MatrixXd kernel =
      2.0 / std::numbers::pi * wave * gap.asDiagonal() * wave.transpose();
  const VectorXd kernel_at_edge =
      2.0 / std::numbers::pi * wave * gap.cwiseProduct((radius * k).array().cos().matrix());
  const Eigen::MatrixXd matrix =
      Eigen::MatrixXd::Identity(points, points) - kernel * t.weight.asDiagonal();
  Eigen::MatrixXd right = Eigen::MatrixXd::Ones(points, 2);
  right.col(1) = (t.node / radius).array().square();
  const Eigen::MatrixXd weighted = t.weight.asDiagonal() * matrix.partialPivLu().solve(right);
  const auto phi = [&](Eigen::Index n) {
    return Phi{weighted.col(n).sum() / radius, 1.0 + kernel_at_edge.dot(weighted.col(n))};
  };
  return {phi(0), phi(1)};
}

/// Returns kappa, the mean of phi. Lengths are in units of the thickness.
double factor_of_layer(double radius, double nu, int points) {
  const GaussRule k(points + static_cast<int>(40.0 * (1.0 + radius)), 22.0);  // 1 - L < 1e-15 there
  Waves waves;
  for (Eigen::Index j = 0; j < k.node.size(); ++j) {
    waves.k.push_back(k.node(j));
    waves.gap.push_back(k.weight(j) * (1.0 - layer_over_half_space(k.node(j), nu)));
  }
  return solve_phi(radius, waves, points).flat.mean;
}

/// Rows u / cos, w / sin, shear and normal stress of four solutions for one wavenumber, at the top
/// or the bottom of a layer: (1, Z) e^Z with Z = k (z - h), and (1, Z) e^-Z with Z = k z.
Eigen::Matrix4d solutions_of(const PunchLayer& layer, double k, bool bottom) {
  const double nu = layer.poissons_ratio;
  const double mu = 0.5 * layer.youngs_modulus / (1.0 + nu);
  const double lambda = 2.0 * mu * nu / (1.0 - 2.0 * nu);
  Eigen::Matrix4d all;
  for (int n = 0; n < 4; ++n) {
    const double s = n < 2 ? 1.0 : -1.0;
    const double a = n % 2 == 0 ? 1.0 : 0.0;
    const double b = 1.0 - a;
    const double z = k * layer.thickness * ((bottom ? 1.0 : 0.0) - (n < 2 ? 1.0 : 0.0));
    const double u = a + b * z;
    const double w = -s * u + b * (3.0 - 4.0 * nu);
    const double du = k * (s * u + b);
    const double dw = k * (s * w - s * b);
    all.col(n) << u, w, mu * (du - k * w), lambda * (k * u + dw) + 2.0 * mu * dw;
    all.col(n) *= std::exp(s * z);
  }
  return all;
}

/// Displacement of the surface of layers under a pressure of wavenumber k over that of a half space
/// of the first layer.
double layers_over_half_space(const std::vector<PunchLayer>& layers, double k) {
  const auto count = std::ssize(layers);
  const PunchLayer& first = layers.front();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(4 * count, 4 * count);
  VectorXd right = VectorXd::Zero(4 * count);
  const Eigen::Matrix4d top = solutions_of(first, k, false);
  matrix.block<2, 4>(0, 0) = top.bottomRows<2>();
  right(1) = -1.0;
  for (Eigen::Index n = 0; n < count; ++n) {
    const Eigen::Matrix4d here = solutions_of(layers[static_cast<std::size_t>(n)], k, true);
    if (n + 1 == count) {
      matrix.block<2, 4>(4 * n + 2, 4 * n) = here.topRows<2>();
    } else {
      matrix.block<4, 4>(4 * n + 2, 4 * n) = here;
      matrix.block<4, 4>(4 * n + 2, 4 * n + 4) =
          -solutions_of(layers[static_cast<std::size_t>(n + 1)], k, false);
    }
  }
  const VectorXd scale = matrix.rowwise().lpNorm<Eigen::Infinity>().cwiseInverse();
  const VectorXd found = (scale.asDiagonal() * matrix).fullPivLu().solve(scale.cwiseProduct(right));
  const double nu = first.poissons_ratio;
  return k * top.row(1).dot(found.head<4>()) * first.youngs_modulus / (2.0 * (1.0 - nu * nu));
}

Waves waves_of_layers(double radius, const std::vector<PunchLayer>& layers, int points) {
  double bottom = 0.0;
  for (const PunchLayer& layer : layers) { bottom += layer.thickness; }
  const double end = 16.0 / layers.front().thickness;  // 1 - L < 1e-10 there
  Waves waves;
  double to = 0.0;
  for (double from = 0.0; from < end; from = to) {
    to = std::min(std::max(0.1 / bottom, 1.3 * from), from + 2.0 / radius);
    const GaussRule k(points / 4, to - from);
    for (Eigen::Index j = 0; j < k.node.size(); ++j) {
      waves.k.push_back(from + k.node(j));
      waves.gap.push_back(k.weight(j) * (1.0 - layers_over_half_space(layers, waves.k.back())));
    }
  }
  return waves;
}

PhiPair phi_of_layers(double radius, const std::vector<PunchLayer>& layers, int points) {
  return solve_phi(radius, waves_of_layers(radius, layers, points), points);
}

/// Stiffness under a uniform pressure, whose transform is 2 J1(k a) / (k a).
double uniform_factor(double radius, const std::vector<PunchLayer>& layers, int points) {
  const Waves waves = waves_of_layers(radius, layers, points);
  double mean = 16.0 / (3.0 * std::numbers::pi);  // of a half space, times pi E a / (1 - nu^2)
  for (std::size_t n = 0; n < waves.k.size(); ++n) {
    const double x = waves.k[n] * radius;
    const double transform = 2.0 * gsl_sf_bessel_J1(x) / x;
    mean -= waves.gap[n] * radius * transform * transform;
  }
  return 0.5 * std::numbers::pi / mean;
}

/// Returns a result of a quadrature with 48 points and its difference from that with 24.
template <class Factor> PunchFactor refined(Factor factor) {
  const double fine = factor(48);
  return {fine, std::abs(fine - factor(24))};
}

SphereForce sphere_force(double dent, const SphericalFace& face,
                         const std::vector<PunchLayer>& layers, int points) {
  const double modulus = layers.front().youngs_modulus /
                         (1.0 - layers.front().poissons_ratio * layers.front().poissons_ratio);
  // The right-hand side is D - t^2 / R; phi(a) = 0 gives D, unless the whole face is in contact.
  const auto dent_of = [&](const PhiPair& phi, double a) {
    return a * a / face.tip_radius * phi.curved.edge / phi.flat.edge;
  };
  double low = 0.0;
  double a = face.radius;
  PhiPair phi = phi_of_layers(a, layers, points);
  if (dent < dent_of(phi, a)) {
    for (double high = a; high - low > 1e-9 * face.radius;) {
      a = 0.5 * (low + high);
      phi = phi_of_layers(a, layers, points);
      (dent < dent_of(phi, a) ? high : low) = a;
    }
  }
  const double mean = dent * phi.flat.mean - a * a / face.tip_radius * phi.curved.mean;
  return {.force = 2.0 * modulus * a * mean, .contact_radius = a};
}

}  // namespace

PunchFactor punch_on_layer(double radius_over_thickness, double poissons_ratio) {
  return refined(
      [&](int points) { return factor_of_layer(radius_over_thickness, poissons_ratio, points); });
}

PunchFactor punch_on_layers(double radius, const std::vector<PunchLayer>& layers) {
  return refined([&](int points) { return phi_of_layers(radius, layers, points).flat.mean; });
}

PunchFactor uniform_pressure_on_layers(double radius, const std::vector<PunchLayer>& layers) {
  return refined([&](int points) { return uniform_factor(radius, layers, points); });
}

SphereForce sphere_on_layers(double dent, const SphericalFace& face,
                             const std::vector<PunchLayer>& layers) {
  SphereForce fine = sphere_force(dent, face, layers, 48);
  fine.uncertainty = std::abs(sphere_force(dent, face, layers, 24).force / fine.force - 1.0);
  return fine;
}

}  // namespace palpate::reference
