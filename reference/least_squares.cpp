// SPDX-License-Identifier: MIT

#include "reference/least_squares.hpp"

#include <exception>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <memory>
#include <stdexcept>

#include "reference/integrate.hpp"

namespace palpate::reference {
namespace {

struct WorkspaceDeleter {
  void operator()(gsl_multifit_nlinear_workspace* w) const { gsl_multifit_nlinear_free(w); }
};

/// Data of GSL's callbacks; it stores an exception until GSL has returned.
struct Bridge {
  const LeastSquaresProblem& problem;
  std::exception_ptr thrown{};
};

Eigen::VectorXd to_eigen(const gsl_vector* v) {
  Eigen::VectorXd x(static_cast<Eigen::Index>(v->size));
  for (std::size_t i = 0; i < v->size; ++i) {
    x[static_cast<Eigen::Index>(i)] = gsl_vector_get(v, i);
  }
  return x;
}

template <class Work> int guarded(void* data, Work&& work) {
  auto& bridge = *static_cast<Bridge*>(data);
  try {
    return work(bridge.problem) ? GSL_SUCCESS : GSL_EDOM;
  } catch (...) {
    bridge.thrown = std::current_exception();
    return GSL_EFAILED;
  }
}

int residuals(const gsl_vector* x, void* data, gsl_vector* f) {
  return guarded(data, [&](const LeastSquaresProblem& problem) {
    const Eigen::VectorXd r = problem.residuals(to_eigen(x));
    for (std::size_t i = 0; i < f->size; ++i) {
      gsl_vector_set(f, i, r[static_cast<Eigen::Index>(i)]);
    }
    return r.allFinite();
  });
}

int jacobian(const gsl_vector* x, void* data, gsl_matrix* out) {
  return guarded(data, [&](const LeastSquaresProblem& problem) {
    const Eigen::MatrixXd j = problem.jacobian(to_eigen(x));
    for (std::size_t row = 0; row < out->size1; ++row) {
      for (std::size_t column = 0; column < out->size2; ++column) {
        gsl_matrix_set(out, row, column,
                       j(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)));
      }
    }
    return j.allFinite();
  });
}

}  // namespace

LeastSquaresSolution least_squares(const LeastSquaresProblem& problem, const Eigen::VectorXd& start,
                                   const LeastSquaresRule& rule) {
  return_gsl_errors();
  Bridge bridge{problem};
  const Eigen::VectorXd first = problem.residuals(start);
  if (first.size() < start.size()) {
    throw std::invalid_argument("least squares: fewer residuals than parameters");
  }
  gsl_multifit_nlinear_fdf functions{.f = residuals,
                                     .df = jacobian,
                                     .fvv = nullptr,
                                     .n = static_cast<std::size_t>(first.size()),
                                     .p = static_cast<std::size_t>(start.size()),
                                     .params = &bridge,
                                     .nevalf = 0,
                                     .nevaldf = 0,
                                     .nevalfvv = 0};
  const gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
  const std::unique_ptr<gsl_multifit_nlinear_workspace, WorkspaceDeleter> work(
      gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, functions.n,
                                 functions.p));
  if (!work) { throw std::bad_alloc(); }
  const auto x = gsl_vector_const_view_array(start.data(), functions.p);
  int reason = 0;
  int status = gsl_multifit_nlinear_init(&x.vector, &functions, work.get());
  if (status == GSL_SUCCESS) {
    status = gsl_multifit_nlinear_driver(rule.most_iterations, rule.step_tolerance,
                                         rule.gradient_tolerance, 0.0, nullptr, nullptr, &reason,
                                         work.get());
  }
  if (bridge.thrown) { std::rethrow_exception(bridge.thrown); }
  // No better step exists within rounding, so the present point is the solution.
  const bool stalled = status == GSL_ENOPROG;
  return {.x = to_eigen(gsl_multifit_nlinear_position(work.get())),
          .residuals = to_eigen(gsl_multifit_nlinear_residual(work.get())),
          .iterations = gsl_multifit_nlinear_niter(work.get()),
          .converged = status == GSL_SUCCESS || stalled};
}

}  // namespace palpate::reference
