// SPDX-License-Identifier: MIT

#include <algorithm>
#include <exception>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <gsl/gsl_version.h>
#include <memory>
#include <string>

#include "reference/integrate.hpp"
#include "reference/solvers.hpp"

namespace palpate::reference {

namespace {

struct DriverDeleter {
  void operator()(gsl_odeiv2_driver* driver) const { gsl_odeiv2_driver_free(driver); }
};

class GslDriver final : public SystemIntegrator {
 public:
  GslDriver(std::string name, const gsl_odeiv2_step_type* type, const Problem& problem,
            const Tolerance& tolerance)
      : SystemIntegrator(problem),
        name_(std::move(name)),
        type_(type),
        relative_(tolerance.relative),
        equations_{derivative, jacobian, static_cast<std::size_t>(system_.size()), this},
        state_(system_.initial_state()),
        scale_(system_.scales(tolerance)) {
    return_gsl_errors();
  }

  void begin(const Segment& segment) override {
    system_.set_gate(segment.gate);
    const double first = 1e-3 * segment.max_step;
    driver_.reset(gsl_odeiv2_driver_alloc_scaled_new(&equations_, type_, first, relative_,
                                                     relative_, 1.0, 0.0, scale_.data()));
    if (!driver_) { fail(name_, "gsl_odeiv2_driver_alloc_scaled_new", "NULL", segment.start, ""); }
    check(gsl_odeiv2_driver_set_hmax(driver_.get(), segment.max_step),
          "gsl_odeiv2_driver_set_hmax");
    check(gsl_odeiv2_driver_set_hmin(driver_.get(), 1e-12 * (segment.end - segment.start)),
          "gsl_odeiv2_driver_set_hmin");
    check(gsl_odeiv2_driver_set_nmax(driver_.get(), step_limit), "gsl_odeiv2_driver_set_nmax");
    time_ = segment.start;
    steps_ = 0;
  }

  void advance(double time) override {
    check(gsl_odeiv2_driver_apply(driver_.get(), &time_, time, state_.data()),
          "gsl_odeiv2_driver_apply");
    steps_ += static_cast<long>(driver_->n);
  }

  [[nodiscard]] long segment_steps() const override { return steps_; }

  [[nodiscard]] const double* state() const override { return state_.data(); }

 private:
  static int derivative(double t, const double* y, double* dy, void* driver) {
    auto& self = *static_cast<GslDriver*>(driver);
    try {
      if (self.system_.derivative(t, y, dy)) { return GSL_SUCCESS; }
      self.cause_ = "the right-hand side is not finite";
    } catch (const std::exception& error) { self.cause_ = error.what(); }
    return GSL_EBADFUNC;  // ends the integration; any other value only shortens the step
  }

  /// Computes df/dy, row-major. df/dt is zero, because neither method used here reads it.
  static int jacobian(double, const double* y, double* dfdy, double* dfdt, void* driver) {
    auto& self = *static_cast<GslDriver*>(driver);
    try {
      using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      const Eigen::Index size = self.system_.size();
      Eigen::Map<RowMajor>(dfdy, size, size) = first_order_jacobian(self.system_, y);
      std::fill_n(dfdt, size, 0.0);
      return GSL_SUCCESS;
    } catch (const std::exception& error) { self.cause_ = error.what(); }
    return GSL_EBADFUNC;
  }

  void check(int flag, const char* function) const {
    if (flag != GSL_SUCCESS) { fail(name_, function, gsl_strerror(flag), time_, cause_); }
  }

  std::string name_;
  const gsl_odeiv2_step_type* type_;
  double relative_;
  gsl_odeiv2_system equations_;
  Eigen::VectorXd state_;
  Eigen::VectorXd scale_;
  std::unique_ptr<gsl_odeiv2_driver, DriverDeleter> driver_;
  std::string cause_;
  double time_ = 0.0;
  long steps_ = 0;
};

Trace solve(const char* name, const gsl_odeiv2_step_type* type, const Problem& problem,
            const std::vector<double>& times, const Tolerance& tolerance) {
  GslDriver integrator(name, type, problem, tolerance);
  return integrate({name, std::string("GSL ") + gsl_version}, problem, times, tolerance,
                   integrator);
}

}  // namespace

void return_gsl_errors() { static_cast<void>(gsl_set_error_handler_off()); }

Trace solve_gsl_rk8pd(const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance) {
  return solve("gsl-rk8pd", gsl_odeiv2_step_rk8pd, problem, times, tolerance);
}

Trace solve_gsl_msbdf(const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance) {
  if (2 * problem.dof() > dense_state_limit) {
    throw SolverError("gsl-msbdf: " + std::to_string(2 * problem.dof()) +
                      " states; its dense Jacobian is for at most " +
                      std::to_string(dense_state_limit));
  }
  return solve("gsl-msbdf", gsl_odeiv2_step_msbdf, problem, times, tolerance);
}

}  // namespace palpate::reference
