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

/// Returns a view; the vectors of GSL's solver are contiguous.
Eigen::Map<Eigen::VectorXd> view(const gsl_vector* v) {
  return {v->data, static_cast<Eigen::Index>(v->size)};
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
    view(f) = problem.residuals(view(x));
    return view(f).allFinite();
  });
}

int jacobian(const gsl_vector* x, void* data, gsl_matrix* out) {
  return guarded(data, [&](const LeastSquaresProblem& problem) {
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<Rows, 0, Eigen::OuterStride<>> view_of_out(
        out->data, static_cast<Eigen::Index>(out->size1), static_cast<Eigen::Index>(out->size2),
        Eigen::OuterStride<>(static_cast<Eigen::Index>(out->tda)));
    view_of_out = problem.jacobian(view(x));
    return view_of_out.allFinite();
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
  // No better step exists within rounding, so the present point is the solution. If it is the
  // start, GSL reports the limit of iterations and gives the reason apart.
  const bool stalled = status == GSL_ENOPROG || (status == GSL_EMAXITER && reason == GSL_ENOPROG);
  return {.x = view(gsl_multifit_nlinear_position(work.get())),
          .residuals = view(gsl_multifit_nlinear_residual(work.get())),
          .iterations = gsl_multifit_nlinear_niter(work.get()),
          .converged = status == GSL_SUCCESS || stalled};
}

}  // namespace palpate::reference
