// SPDX-License-Identifier: MIT
/// CVODE integrator over y of Mechanics, restarted at every event. Private to
/// reference/insertion*.cpp.

#include "reference/insertion.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cvode/cvode.h>
#include <exception>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <vector>

#include "reference/insertion_transitions.hpp"
#include "reference/sundials.hpp"

namespace palpate::reference::insertion {

/// Adams-Moulton up to order 12 with functional iteration. Throws SolverError with the library's
/// flag.
class Flow {
 public:
  Flow(Mechanics& mechanics, const Tolerance& tolerance, const InsertionOptions& options);
  Flow(const Flow&) = delete;  // the library keeps its address
  Flow& operator=(const Flow&) = delete;
  ~Flow();

  /// Restarts from y at `time` in one mode; never integrates beyond `stop` [s].
  void restart(double time, double stop, const Mode& mode, const Eigen::VectorXd& y);
  /// Integrates to `goal` [s] or to the first event before it; returns the events.
  std::set<Root> advance(double goal, Eigen::VectorXd& y);
  [[nodiscard]] double time() const { return time_; }
  [[nodiscard]] long steps() const { return steps_ + steps_since_restart(); }

 private:
  void set_tolerance(const Tolerance& tolerance);
  void set_roots(const Eigen::VectorXd& y);
  [[nodiscard]] long steps_since_restart() const;
  void check(int flag, const char* function) const;
  static int right_hand_side(realtype t, N_Vector y, N_Vector dy, void* flow);
  static int roots(realtype t, N_Vector y, realtype* values, void* flow);
  static void complain(int code, const char*, const char* function, char* message, void* flow);

  Mechanics& mechanics_;
  Mode mode_{};
  Eigen::VectorXd y_, dy_;
  std::vector<Root> names_;
  sundials::Context context_;
  sundials::Vector state_;
  sundials::Vector absolute_;
  sundials::NonlinearSolver fixed_point_;
  void* memory_ = nullptr;  ///< freed before what it points to
  double time_ = 0.0;
  long steps_ = 0;
  std::string complaint_;  ///< last message of the library
  std::string cause_;      ///< reason of a failure in a callback
};

}  // namespace palpate::reference::insertion

namespace palpate::reference {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using insertion::Flow;
using insertion::Mechanics;
using insertion::Mode;
using insertion::Root;
using insertion::Transitions;

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
  out.energy = {.hand = work(0),
                .dampers = work(1),
                .friction = work(2),
                .cutting = work(3),
                .impacts = transitions.impact_loss(),
                .stored = mechanics.stored_energy(time, mode, y)};
  return out;
}

/// Returns the instants at which the hand's motion or a load has a kink, from 0 to `end` inclusive.
std::vector<double> stops_until(double end, const std::vector<HandPiece>& hand,
                                const std::vector<double>& loads) {
  std::vector<double> stops{0.0, end};
  for (const HandPiece& piece : hand) { stops.push_back(piece.start); }
  stops.insert(stops.end(), loads.begin(), loads.end());
  std::ranges::sort(stops);
  std::erase_if(stops, [end](double t) { return t > end; });
  // A solver cannot distinguish stops that are closer than this.
  const auto same = [end](double a, double b) { return b - a <= 1e-13 * end; };
  stops.erase(std::unique(stops.begin(), stops.end(), same), stops.end());
  return stops;
}

const HandPiece& piece_at(const std::vector<HandPiece>& hand, double time) {
  const auto after = std::ranges::upper_bound(hand, time, {}, &HandPiece::start);
  return after == hand.begin() ? hand.front() : *(after - 1);
}

void check_times(const std::vector<double>& times) {
  const bool ascend = std::ranges::adjacent_find(times, std::greater_equal<>()) == times.end();
  if (times.empty() || times.front() != 0.0 || !ascend) {
    throw SolverError("insertion: the requested times must ascend from 0 s");
  }
}

/// Solution of one insertion from 0 to the last requested time.
class Run {
 public:
  Run(const Scene& scene, const SpringNetwork& network, const std::vector<double>& times,
      const Tolerance& tolerance, const InsertionOptions& options)
      : times_(times),
        apart_(1e-13 * times.back()),
        mechanics_(scene, network, tolerance, options),
        transitions_(mechanics_, options),
        flow_(mechanics_, tolerance, options),
        y_(VectorXd::Zero(mechanics_.size())) {
    y_.segment(mechanics_.dof(), mechanics_.dof()) = mechanics_.problem().initial_velocity();
    y_(mechanics_.place()) = mechanics_.drive().from;
  }

  Insertion solve() {
    const std::vector<HandPiece> hand = hand_motion(mechanics_.drive(), times_.back());
    const auto stops = stops_until(times_.back(), hand, mechanics_.problem().breaks());
    for (std::size_t n = 0; n + 1 < stops.size(); ++n) {
      const double middle = 0.5 * (stops[n] + stops[n + 1]);
      transitions_.begin_piece(stops[n], piece_at(hand, middle), middle, y_);
      if (n == 0) { record(); }
      go_through(stops[n], stops[n + 1]);
    }
    if (instants_.empty()) {  // only 0 s was requested
      transitions_.begin_piece(0.0, piece_at(hand, 0.0), 0.0, y_);
      record();
    }
    Insertion result{.version = sundials::version(), .instants = std::move(instants_)};
    result.events = transitions_.events();
    result.steps = flow_.steps();
    result.evaluations = mechanics_.evaluations();
    result.largest_drift = transitions_.largest_drift();
    result.largest_slip = transitions_.largest_slip();
    return result;
  }

 private:
  [[nodiscard]] bool due(double time) const {
    return instants_.size() < times_.size() && times_[instants_.size()] <= time + apart_;
  }

  void record() {
    instants_.push_back(instant_of(times_[instants_.size()], y_, transitions_, mechanics_));
  }

  void go_through(double start, double stop) {
    flow_.restart(start, stop, transitions_.mode(), y_);
    while (stop - flow_.time() > apart_) {
      const double goal =
          instants_.size() < times_.size() ? std::min(times_[instants_.size()], stop) : stop;
      // An event may be too near to an instant for a step between them.
      const bool there = goal - flow_.time() <= apart_;
      const std::set<Root> fired = there ? std::set<Root>{} : flow_.advance(goal, y_);
      if (!fired.empty()) {
        transitions_.settle(flow_.time(), fired, y_);
        if (stop - flow_.time() > apart_) {
          flow_.restart(flow_.time(), stop, transitions_.mode(), y_);
        }
      } else if (due(goal)) {
        record();
      }
    }
    while (due(stop)) { record(); }
  }

  const std::vector<double>& times_;
  double apart_ = 0.0;  ///< instants closer than this are merged [s]
  Mechanics mechanics_;
  Transitions transitions_;
  Flow flow_;
  VectorXd y_;
  std::vector<InsertionInstant> instants_;
};

}  // namespace

Insertion solve_insertion(const Scene& scene, const SpringNetwork& network,
                          const std::vector<double>& times, const Tolerance& tolerance,
                          const InsertionOptions& options) {
  const auto begun = std::chrono::steady_clock::now();
  check_times(times);
  Insertion result = Run(scene, network, times, tolerance, options).solve();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return result;
}

}  // namespace palpate::reference

namespace palpate::reference::insertion {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using VectorMap = Eigen::Map<VectorXd>;

VectorMap values_of(N_Vector vector) { return {N_VGetArrayPointer(vector), N_VGetLength(vector)}; }

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
  // Without a minimum step, a failing right-hand side leads to millions of steps of length zero.
  check(CVodeSetMinStep(memory_, 1e-14 * stop), "CVodeSetMinStep");
}

/// Sets the root functions. They are positive while the mode lasts, so only a downward zero
/// crossing is an event.
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
  constexpr double energy_scale = 1e-2;  // work of some newtons over some millimetres [J]
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
  if (code >= 0) { return; }  // a warning; results are checked separately
  static_cast<Flow*>(flow)->complaint_ = std::string(function) + ": " + message;
}

}  // namespace palpate::reference::insertion
