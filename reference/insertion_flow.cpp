// SPDX-License-Identifier: MIT
#include "reference/insertion_flow.hpp"

#include <cstdlib>
#include <cvode/cvode.h>
#include <exception>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

namespace palpate::reference::insertion {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using VectorMap = Eigen::Map<VectorXd>;

VectorMap values_of(N_Vector vector) {
  return {N_VGetArrayPointer(vector), N_VGetLength(vector)};
}

}  // namespace

Flow::Flow(Mechanics& mechanics, const Tolerance& tolerance, const InsertionOptions& options)
    : mechanics_(mechanics), y_(VectorXd::Zero(mechanics.size())) {
  SUNContext context = nullptr;
  check(SUNContext_Create(nullptr, &context), "SUNContext_Create");
  context_.reset(context);
  state_.reset(N_VNew_Serial(mechanics.size(), context));
  absolute_.reset(N_VNew_Serial(mechanics.size(), context));
  memory_ = CVodeCreate(CV_ADAMS, context);
  if (!state_ || !absolute_ || memory_ == nullptr) { check(CV_MEM_FAIL, "CVodeCreate"); }
  set_tolerance(tolerance);
  values_of(state_.get()).setZero();
  check(CVodeSetErrHandlerFn(memory_, complain, this), "CVodeSetErrHandlerFn");
  check(CVodeInit(memory_, right_hand_side, 0.0, state_.get()), "CVodeInit");
  check(CVodeSetUserData(memory_, this), "CVodeSetUserData");
  check(CVodeSVtolerances(memory_, tolerance.relative, absolute_.get()), "CVodeSVtolerances");
  check(CVodeSetMaxNumSteps(memory_, step_limit), "CVodeSetMaxNumSteps");
  check(CVodeSetMaxStep(memory_, options.longest_step), "CVodeSetMaxStep");
  fixed_point_.reset(SUNNonlinSol_FixedPoint(state_.get(), 0, context));
  if (!fixed_point_) { check(CV_MEM_FAIL, "SUNNonlinSol_FixedPoint"); }
  check(CVodeSetNonlinearSolver(memory_, fixed_point_.get()), "CVodeSetNonlinearSolver");
}

Flow::~Flow() { CVodeFree(&memory_); }

void Flow::restart(double time, double stop, const Mode& mode, const VectorXd& y) {
  steps_ += steps_since_restart();
  mode_ = mode;
  time_ = time;
  values_of(state_.get()) = y;
  check(CVodeReInit(memory_, time, state_.get()), "CVodeReInit");
  set_roots(y);
  check(CVodeSetStopTime(memory_, stop), "CVodeSetStopTime");
  // Without it, a right-hand side that fails is approached by ten million steps of no length.
  check(CVodeSetMinStep(memory_, 1e-14 * stop), "CVodeSetMinStep");
}

/// The mode lasts while they are positive, so only the way down through zero is an event.
void Flow::set_roots(const VectorXd& y) {
  names_.clear();
  for (const RootValue& root : roots_of(time_, mode_, y, mechanics_)) {
    names_.push_back(root.root);
  }
  const auto count = static_cast<int>(names_.size());
  check(CVodeRootInit(memory_, count, count > 0 ? roots : nullptr), "CVodeRootInit");
  if (count == 0) { return; }
  std::vector<int> falling(names_.size(), -1);
  check(CVodeSetRootDirection(memory_, falling.data()), "CVodeSetRootDirection");
  check(CVodeSetNoInactiveRootWarn(memory_), "CVodeSetNoInactiveRootWarn");
}

std::set<Root> Flow::advance(double goal, VectorXd& y) {
  const int flag = CVode(memory_, goal, state_.get(), &time_, CV_NORMAL);
  if (flag < 0) { CVodeGetCurrentTime(memory_, &time_); }
  check(flag, "CVode");
  y = values_of(state_.get());
  std::set<Root> fired;
  if (flag != CV_ROOT_RETURN) { return fired; }
  std::vector<int> found(names_.size(), 0);
  check(CVodeGetRootInfo(memory_, found.data()), "CVodeGetRootInfo");
  for (std::size_t n = 0; n < found.size(); ++n) {
    if (found[n] != 0) { fired.insert(names_[n]); }
  }
  return fired;
}

void Flow::set_tolerance(const Tolerance& tolerance) {
  VectorMap absolute = values_of(absolute_.get());
  const Index n = mechanics_.dof();
  absolute.head(n).setConstant(tolerance.relative * tolerance.position_scale);
  absolute.segment(n, n).setConstant(tolerance.relative * tolerance.velocity_scale);
  absolute(mechanics_.place()) = tolerance.relative * tolerance.position_scale;
  absolute(mechanics_.speed()) = tolerance.relative * tolerance.velocity_scale;
  constexpr double energy_scale = 1e-2;  // [J] of some newtons over some millimetres
  absolute.tail<4>().setConstant(tolerance.relative * energy_scale);
}

long Flow::steps_since_restart() const {
  long steps = 0;
  check(CVodeGetNumSteps(memory_, &steps), "CVodeGetNumSteps");
  return steps;
}

void Flow::check(int flag, const char* function) const {
  if (flag >= 0) { return; }
  const std::unique_ptr<char, sundials::Deleter<std::free>> name(CVodeGetReturnFlagName(flag));
  fail("insertion", function, name ? name.get() : std::to_string(flag), time_,
       cause_.empty() ? complaint_ : cause_);
}

int Flow::right_hand_side(realtype t, N_Vector y, N_Vector dy, void* flow) {
  auto& self = *static_cast<Flow*>(flow);
  try {
    self.y_ = values_of(y);
    self.mechanics_.evaluate(t, self.mode_, self.y_, &self.dy_);
    values_of(dy) = self.dy_;
    if (self.dy_.allFinite()) { return 0; }
    self.cause_ = "the right-hand side is not finite";
  } catch (const std::exception& error) { self.cause_ = error.what(); }
  return -1;
}

int Flow::roots(realtype t, N_Vector y, realtype* values, void* flow) {
  auto& self = *static_cast<Flow*>(flow);
  try {
    self.y_ = values_of(y);
    for (const RootValue& root : roots_of(t, self.mode_, self.y_, self.mechanics_)) {
      *values++ = root.value;
    }
    return 0;
  } catch (const std::exception& error) { self.cause_ = error.what(); }
  return -1;
}

void Flow::complain(int code, const char*, const char* function, char* message, void* flow) {
  if (code >= 0) { return; }  // a warning; what matters is checked
  static_cast<Flow*>(flow)->complaint_ = std::string(function) + ": " + message;
}

}  // namespace palpate::reference::insertion
