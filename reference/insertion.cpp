// SPDX-License-Identifier: MIT
/// CVODE integrator over y of Mechanics, restarted at every event. Private to
/// reference/insertion*.cpp.

#include "reference/insertion.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "reference/insertion_transitions.hpp"
#include "reference/sundials.hpp"

namespace palpate::reference::insertion {

/// CVODE over y of Mechanics, restarted at every event.
class Flow {
 public:
  Flow(Mechanics& mechanics, const Tolerance& tolerance, const InsertionOptions& options);

  /// Restarts from y at `time` in one mode; never integrates beyond `stop` [s].
  void restart(double time, double stop, const Mode& mode, const Eigen::VectorXd& y);
  /// Integrates to `goal` [s] or to the first event before it; returns the events.
  std::set<Root> advance(double goal, Eigen::VectorXd& y);
  [[nodiscard]] double time() const { return cvode_.time(); }
  [[nodiscard]] long steps() const { return steps_ + cvode_.steps(); }

 private:
  [[nodiscard]] static Eigen::VectorXd absolute(const Mechanics& mechanics,
                                                const Tolerance& tolerance);

  Mechanics& mechanics_;
  double longest_step_;
  Mode mode_{};
  Eigen::VectorXd y_, dy_;
  std::vector<Root> names_;
  sundials::Cvode cvode_;
  long steps_ = 0;
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

using Eigen::Index;
using Eigen::VectorXd;

VectorXd Flow::absolute(const Mechanics& mechanics, const Tolerance& tolerance) {
  constexpr double energy_scale = 1e-2;  // work of some newtons over some millimetres [J]
  const Index n = mechanics.dof();
  VectorXd scales(mechanics.size());
  scales << VectorXd::Constant(n, tolerance.position_scale),
      VectorXd::Constant(n, tolerance.velocity_scale), tolerance.position_scale,
      tolerance.velocity_scale, VectorXd::Constant(4, energy_scale);
  return tolerance.relative * scales;
}

Flow::Flow(Mechanics& mechanics, const Tolerance& tolerance, const InsertionOptions& options)
    : mechanics_(mechanics),
      longest_step_(options.longest_step),
      y_(VectorXd::Zero(mechanics.size())),
      cvode_("insertion", CV_ADAMS, y_, tolerance.relative, absolute(mechanics, tolerance),
             [this](double t, const double* y, double* dy) {
               y_ = VectorXd::Map(y, y_.size());
               mechanics_.evaluate(t, mode_, y_, &dy_);
               VectorXd::Map(dy, dy_.size()) = dy_;
               return dy_.allFinite();
             }) {}

void Flow::restart(double time, double stop, const Mode& mode, const VectorXd& y) {
  steps_ += cvode_.steps();
  mode_ = mode;
  cvode_.restart(time, stop, longest_step_, y);
  names_.clear();
  for (const RootValue& root : roots_of(time, mode_, y, mechanics_)) {
    names_.push_back(root.root);
  }
  // Root functions are positive while the mode lasts, so only a downward crossing is an event.
  cvode_.set_falling_roots(names_.size(), [this](double t, const double* state, double* values) {
    y_ = VectorXd::Map(state, y_.size());
    for (const RootValue& root : roots_of(t, mode_, y_, mechanics_)) { *values++ = root.value; }
  });
}

std::set<Root> Flow::advance(double goal, VectorXd& y) {
  const bool at_root = cvode_.evolve(goal);
  y = VectorXd::Map(cvode_.values(), y_.size());
  std::set<Root> fired;
  if (!at_root) { return fired; }
  for (const std::size_t n : cvode_.found_roots()) { fired.insert(names_[n]); }
  return fired;
}

}  // namespace palpate::reference::insertion
