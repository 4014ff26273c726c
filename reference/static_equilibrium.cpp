// SPDX-License-Identifier: MIT
#include "reference/static_equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "reference/static_response.hpp"

namespace palpate::reference {

using Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

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

/// What rounding of positions alone does to the forces.
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

}  // namespace palpate::reference
