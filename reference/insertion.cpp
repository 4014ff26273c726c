// SPDX-License-Identifier: MIT
#include "reference/insertion.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cvode/cvode.h>
#include <exception>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "reference/insertion_transitions.hpp"
#include "reference/sundials.hpp"

namespace palpate::reference {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using insertion::Mechanics;
using insertion::Mode;
using insertion::Root;
using insertion::RootValue;
using insertion::Transitions;

using VectorMap = Eigen::Map<VectorXd>;

const char* const solver_name = "insertion";

/// Adams-Moulton with functional iteration over y of Mechanics, restarted at every event.
class Flow {
 public:
  Flow(Mechanics& mechanics, const Tolerance& tolerance, const InsertionOptions& options)
      : mechanics_(mechanics), y_(VectorXd::Zero(mechanics.size())) {
    SUNContext context = nullptr;
    check(SUNContext_Create(nullptr, &context), "SUNContext_Create");
    context_.reset(context);
    state_.reset(N_VNew_Serial(mechanics.size(), context));
    absolute_.reset(N_VNew_Serial(mechanics.size(), context));
    memory_.reset(CVodeCreate(CV_ADAMS, context));
    if (!state_ || !absolute_ || !memory_) { fail(solver_name, "CVodeCreate", "NULL", 0.0, ""); }
    set_tolerance(tolerance);
    VectorMap(N_VGetArrayPointer(state_.get()), mechanics.size()).setZero();
    check(CVodeSetErrHandlerFn(memory_.get(), complain, this), "CVodeSetErrHandlerFn");
    check(CVodeInit(memory_.get(), right_hand_side, 0.0, state_.get()), "CVodeInit");
    check(CVodeSetUserData(memory_.get(), this), "CVodeSetUserData");
    check(CVodeSVtolerances(memory_.get(), tolerance.relative, absolute_.get()),
          "CVodeSVtolerances");
    check(CVodeSetMaxNumSteps(memory_.get(), step_limit), "CVodeSetMaxNumSteps");
    check(CVodeSetMaxStep(memory_.get(), options.longest_step), "CVodeSetMaxStep");
    fixed_point_.reset(SUNNonlinSol_FixedPoint(state_.get(), 0, context));
    check(CVodeSetNonlinearSolver(memory_.get(), fixed_point_.get()), "CVodeSetNonlinearSolver");
  }
  Flow(const Flow&) = delete;  // the library keeps its address
  Flow& operator=(const Flow&) = delete;

  void restart(double time, double stop, const Mode& mode, const VectorXd& y) {
    steps_ += steps_since_restart();
    mode_ = mode;
    time_ = time;
    VectorMap(N_VGetArrayPointer(state_.get()), y.size()) = y;
    names_.clear();
    for (const RootValue& root : roots_of(time, mode_, y, mechanics_)) {
      names_.push_back(root.root);
    }
    const auto count = static_cast<int>(names_.size());
    check(CVodeReInit(memory_.get(), time, state_.get()), "CVodeReInit");
    check(CVodeRootInit(memory_.get(), count, count > 0 ? roots : nullptr), "CVodeRootInit");
    if (count > 0) {
      std::vector<int> falling(names_.size(), -1);
      check(CVodeSetRootDirection(memory_.get(), falling.data()), "CVodeSetRootDirection");
      check(CVodeSetNoInactiveRootWarn(memory_.get()), "CVodeSetNoInactiveRootWarn");
    }
    check(CVodeSetStopTime(memory_.get(), stop), "CVodeSetStopTime");
    check(CVodeSetMinStep(memory_.get(), 1e-14 * stop), "CVodeSetMinStep");
  }

  /// Goes on to `time` or to the first event before it; returns what happened.
  std::set<Root> advance(double time, VectorXd& y) {
    const int flag = CVode(memory_.get(), time, state_.get(), &time_, CV_NORMAL);
    if (flag < 0) { CVodeGetCurrentTime(memory_.get(), &time_); }
    check(flag, "CVode");
    y = VectorMap(N_VGetArrayPointer(state_.get()), y.size());
    std::set<Root> fired;
    if (flag == CV_ROOT_RETURN) {
      std::vector<int> found(names_.size(), 0);
      check(CVodeGetRootInfo(memory_.get(), found.data()), "CVodeGetRootInfo");
      for (std::size_t n = 0; n < found.size(); ++n) {
        if (found[n] != 0) { fired.insert(names_[n]); }
      }
    }
    return fired;
  }

  [[nodiscard]] double time() const { return time_; }
  [[nodiscard]] long steps() const { return steps_ + steps_since_restart(); }

 private:
  void set_tolerance(const Tolerance& tolerance) {
    VectorMap absolute(N_VGetArrayPointer(absolute_.get()), mechanics_.size());
    const Index n = mechanics_.dof();
    absolute.head(n).setConstant(tolerance.relative * tolerance.position_scale);
    absolute.segment(n, n).setConstant(tolerance.relative * tolerance.velocity_scale);
    absolute(mechanics_.place()) = tolerance.relative * tolerance.position_scale;
    absolute(mechanics_.speed()) = tolerance.relative * tolerance.velocity_scale;
    constexpr double energy_scale = 1e-2;  // [J] of some newtons over some millimetres
    absolute.tail<4>().setConstant(tolerance.relative * energy_scale);
  }

  [[nodiscard]] long steps_since_restart() const {
    long steps = 0;
    CVodeGetNumSteps(memory_.get(), &steps);
    return steps;
  }

  void check(int flag, const char* function) const {
    if (flag >= 0) { return; }
    const std::unique_ptr<char, sundials::Deleter<std::free>> name(CVodeGetReturnFlagName(flag));
    fail(solver_name, function, name ? name.get() : std::to_string(flag), time_,
         cause_.empty() ? complaint_ : cause_);
  }

  static int right_hand_side(realtype t, N_Vector y, N_Vector dy, void* flow) {
    auto& self = *static_cast<Flow*>(flow);
    try {
      self.y_ = VectorMap(N_VGetArrayPointer(y), self.y_.size());
      self.mechanics_.evaluate(t, self.mode_, self.y_, &self.dy_);
      VectorMap(N_VGetArrayPointer(dy), self.y_.size()) = self.dy_;
      if (self.dy_.allFinite()) { return 0; }
      self.cause_ = "the right-hand side is not finite";
    } catch (const std::exception& error) { self.cause_ = error.what(); }
    return -1;
  }

  static int roots(realtype t, N_Vector y, realtype* values, void* flow) {
    auto& self = *static_cast<Flow*>(flow);
    try {
      self.y_ = VectorMap(N_VGetArrayPointer(y), self.y_.size());
      for (const RootValue& root : roots_of(t, self.mode_, self.y_, self.mechanics_)) {
        *values++ = root.value;
      }
      return 0;
    } catch (const std::exception& error) { self.cause_ = error.what(); }
    return -1;
  }

  static void complain(int code, const char*, const char* function, char* message, void* flow) {
    if (code >= 0) { return; }
    static_cast<Flow*>(flow)->complaint_ = std::string(function) + ": " + message;
  }

  Mechanics& mechanics_;
  Mode mode_{};
  VectorXd y_, dy_;
  std::vector<Root> names_;
  sundials::Context context_;
  sundials::Vector state_;
  sundials::Vector absolute_;
  sundials::NonlinearSolver fixed_point_;
  std::unique_ptr<void, sundials::Deleter<CVodeFree>> memory_;  // freed before what it points to
  double time_ = 0.0;
  long steps_ = 0;
  std::string complaint_;
  std::string cause_;
};

InsertionInstant instant_of(double time, const VectorXd& y, const Transitions& transitions,
                            Mechanics& mechanics) {
  const Mode& mode = transitions.mode();
  const insertion::Contact now = mechanics.evaluate(time, mode, y, nullptr);
  const Index n = mechanics.dof();
  InsertionInstant out{.time = time, .place = y(2 * n), .velocity = y(2 * n + 1)};
  out.depth = now.depth;
  out.cut = mode.tip == insertion::Tip::cutting ? now.depth : mode.cut;
  out.friction = now.shaft_force;
  (mode.tip == insertion::Tip::cutting ? out.cutting : out.stiffness) = now.tip_force;
  const double hand = mode.hand.at(time);
  out.stiffness += now.bone_force;
  if (mode.support == insertion::Support::bone && !mechanics.pushes()) {
    out.stiffness += mechanics.drive().grip_stiffness * (hand - out.place);
  }
  out.total = out.cutting + out.friction + out.stiffness;
  out.applied =
      mechanics.pushes() ? hand - mechanics.drive().hand_viscosity * out.velocity : out.total;
  out.lateral = now.lateral;
  out.position = mechanics.problem().initial_position() + y.head(n);
  out.velocities = y.segment(n, n);
  const auto work = y.tail<4>();
  out.energy = {.hand = work(0), .dampers = work(1), .friction = work(2), .cutting = work(3),
                .impacts = transitions.impact_loss(),
                .stored = mechanics.stored_energy(time, mode, y)};
  return out;
}

/// Instants where the hand's motion or a load has a kink, from 0 to `end`, `end` included.
std::vector<double> stops_until(double end, const std::vector<HandPiece>& hand,
                                const std::vector<double>& loads) {
  std::vector<double> stops{0.0, end};
  for (const HandPiece& piece : hand) { stops.push_back(piece.start); }
  stops.insert(stops.end(), loads.begin(), loads.end());
  std::ranges::sort(stops);
  std::erase_if(stops, [end](double t) { return t > end; });
  // Two stops closer than this cannot be told apart by a solver that adds steps up.
  const auto same = [end](double a, double b) { return b - a <= 1e-13 * end; };
  stops.erase(std::unique(stops.begin(), stops.end(), same), stops.end());
  return stops;
}

const HandPiece& piece_at(const std::vector<HandPiece>& hand, double time) {
  const auto after = std::ranges::upper_bound(hand, time, {}, &HandPiece::start);
  return after == hand.begin() ? hand.front() : *(after - 1);
}

void check_times(const std::vector<double>& times) {
  if (times.empty() || times.front() != 0.0 || std::ranges::adjacent_find(times, std::greater_equal<>()) != times.end()) {
    throw SolverError("insertion: the requested times must ascend from 0 s");
  }
}

}  // namespace

Insertion solve_insertion(const Scene& scene, const SpringNetwork& network,
                          const std::vector<double>& times, const Tolerance& tolerance,
                          const InsertionOptions& options) {
  const auto begun = std::chrono::steady_clock::now();
  check_times(times);
  Mechanics mechanics(scene, network, tolerance, options);
  Transitions transitions(mechanics, options);
  Flow flow(mechanics, tolerance, options);
  const double end = times.back();
  const std::vector<HandPiece> hand = hand_motion(mechanics.drive(), end);
  const std::vector<double> stops = stops_until(end, hand, mechanics.problem().breaks());
  VectorXd y = VectorXd::Zero(mechanics.size());
  y.segment(mechanics.dof(), mechanics.dof()) = mechanics.problem().initial_velocity();
  y(mechanics.place()) = mechanics.drive().from;
  Insertion result{.version = sundials::version()};
  std::size_t next = 0;
  for (std::size_t n = 0; n + 1 < stops.size(); ++n) {
    const double middle = 0.5 * (stops[n] + stops[n + 1]);
    transitions.begin_piece(stops[n], piece_at(hand, middle), middle, y);
    if (n == 0) { result.instants.push_back(instant_of(0.0, y, transitions, mechanics)), ++next; }
    flow.restart(stops[n], stops[n + 1], transitions.mode(), y);
    while (flow.time() < stops[n + 1]) {
      const double goal = next < times.size() ? std::min(times[next], stops[n + 1]) : stops[n + 1];
      // A goal at the present instant is what the present state shows.
      const bool there = goal - flow.time() <= 1e-13 * end;
      const std::set<Root> fired = there ? std::set<Root>{} : flow.advance(goal, y);
      if (!fired.empty()) {
        transitions.settle(flow.time(), fired, y);
        if (stops[n + 1] - flow.time() <= 1e-13 * end) { break; }
        flow.restart(flow.time(), stops[n + 1], transitions.mode(), y);
      } else if (next < times.size() && times[next] <= goal) {
        result.instants.push_back(instant_of(times[next++], y, transitions, mechanics));
      } else if (there) {
        break;
      }
    }
    while (next < times.size() && times[next] <= stops[n + 1] + 1e-13 * end) {
      result.instants.push_back(instant_of(times[next++], y, transitions, mechanics));
    }
  }
  result.events = transitions.events();
  result.steps = flow.steps();
  result.evaluations = mechanics.evaluations();
  result.largest_drift = transitions.largest_drift();
  result.largest_slip = transitions.largest_slip();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return result;
}

}  // namespace palpate::reference
