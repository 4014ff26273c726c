// SPDX-License-Identifier: MIT

#include "reference/static_equilibrium.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <limits>
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

/// Solves with one round of iterative refinement, which compensates for stiffness contrasts. The
/// residual also reveals a singular matrix that rounding hides in the factors.
template <class Factors>
VectorXd refined(const Factors& factors, const Sparse& matrix, const VectorXd& right) {
  VectorXd x = factors.solve(right);
  x += factors.solve(right - matrix * x);
  const bool solved = (right - matrix * x).norm() <= 1e-6 * right.norm();
  if (!solved) { throw SolverError(singular); }
  return x;
}

}  // namespace

class StaticResponse::Solver {
 public:
  virtual ~Solver() = default;
  [[nodiscard]] virtual VectorXd solve(const VectorXd& force) const = 0;
};

class StaticResponse::Cholesky final : public Solver {
 public:
  explicit Cholesky(const Sparse& stiffness) : stiffness_(stiffness), factors_(stiffness_) {}
  [[nodiscard]] bool is_definite() const {
    return factors_.info() == Eigen::Success &&
           factors_.vectorD().minCoeff() > 1e-13 * factors_.vectorD().maxCoeff();
  }
  [[nodiscard]] VectorXd solve(const VectorXd& force) const override {
    return refined(factors_, stiffness_, force);
  }

 private:
  Sparse stiffness_;
  Eigen::SimplicialLDLT<Sparse> factors_;
};

class StaticResponse::Gauss final : public Solver {
 public:
  explicit Gauss(Sparse stiffness) : stiffness_(std::move(stiffness)), factors_(stiffness_) {
    if (factors_.info() != Eigen::Success) { throw SolverError(singular); }
  }
  [[nodiscard]] VectorXd solve(const VectorXd& force) const override {
    return refined(factors_, stiffness_, force);
  }

 private:
  Sparse stiffness_;
  Eigen::SparseLU<Sparse> factors_;
};

class StaticResponse::Gradients final : public Solver {
 public:
  Gradients(Sparse stiffness, int most_rounds) : stiffness_(std::move(stiffness)) {
    solver_.setTolerance(1e-10);
    solver_.setMaxIterations(most_rounds);
    solver_.compute(stiffness_);
  }
  [[nodiscard]] VectorXd solve(const VectorXd& force) const override {
    VectorXd x = solver_.solve(force);
    if (solver_.info() != Eigen::Success || !x.allFinite()) {
      throw NotConverged("conjugate gradients do not converge in " +
                         std::to_string(solver_.maxIterations()) +
                         " rounds; the body may be free to move");
    }
    return x;
  }

 private:
  Sparse stiffness_;
  Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper> solver_;
};

StaticResponse::StaticResponse(const Problem& problem, Eigen::Index most_factorised,
                               int most_rounds)
    : StaticResponse(LinearProblem(problem).stiffness(), most_factorised, most_rounds) {}

StaticResponse::StaticResponse(Sparse stiffness, Eigen::Index most_factorised, int most_rounds) {
  if (is_symmetric(stiffness)) {
    if (stiffness.rows() > most_factorised) {
      solver_ = std::make_unique<Gradients>(std::move(stiffness), most_rounds);
      return;
    }
    auto factors = std::make_unique<Cholesky>(stiffness);
    if (factors->is_definite()) {
      solver_ = std::move(factors);
      return;
    }
  }
  solver_ = std::make_unique<Gauss>(std::move(stiffness));
}

StaticResponse::~StaticResponse() = default;
StaticResponse::StaticResponse(StaticResponse&&) noexcept = default;
StaticResponse& StaticResponse::operator=(StaticResponse&&) noexcept = default;

VectorXd StaticResponse::operator()(const VectorXd& force) const { return solver_->solve(force); }

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

}  // namespace palpate::reference
