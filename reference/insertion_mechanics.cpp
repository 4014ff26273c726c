// SPDX-License-Identifier: MIT

#include "reference/insertion_mechanics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::reference {

namespace {

/// Returns the velocity at which a shaft slides under a load F / L. Without an exponent all of its
/// velocity is slip from the load 1 on; the solver needs a slope, which it has in a narrow band
/// below.
double slip_of(double load, double velocity, double exponent) {
  constexpr double sliding_speed = 1e-3;  // v_1 [m/s]
  constexpr double band = 1e-3;
  if (exponent > 0.0) {
    return std::copysign(sliding_speed * std::pow(std::abs(load), 1.0 / exponent), load);
  }
  if (velocity * load <= 0.0) { return 0.0; }
  return velocity * std::clamp(1.0 + (std::abs(load) - 1.0) / band, 0.0, 1.0);
}

using Pieces = std::vector<HandPiece>;

/// Adds a segment; it replaces a segment with the same start.
void add(Pieces& pieces, const HandPiece& piece) {
  if (!pieces.empty() && pieces.back().start >= piece.start) { pieces.pop_back(); }
  pieces.push_back(piece);
}

/// Adds the way in and returns when it ends.
double advance(const Drive& drive, double end, Pieces& pieces) {
  const double depth = drive.depth.value_or(std::numeric_limits<double>::infinity());
  const bool pauses = drive.technique == Drive::Technique::intermittent;
  double t = drive.start;
  double s = drive.from;
  for (int n = 1; t <= end; ++n) {
    const double goal = pauses ? drive.from + n * drive.advance : depth;
    const bool last = !(goal < depth - 1e-9 * drive.advance);
    add(pieces, {t, s, drive.speed});
    t += ((last ? depth : goal) - s) / drive.speed;
    if (last) { return t; }
    s = goal;
    add(pieces, {t, s, 0.0});
    t += drive.pause;
  }
  return std::numeric_limits<double>::infinity();
}

Pieces trajectory(const Drive& drive, double end) {
  Pieces pieces{{0.0, drive.from, 0.0}};
  const double there = advance(drive, end, pieces);
  if (there > end) { return pieces; }
  add(pieces, {there, *drive.depth, 0.0});
  if (drive.withdraw_speed <= 0.0) { return pieces; }
  const double turn = there + drive.hold;
  add(pieces, {turn, *drive.depth, -drive.withdraw_speed});
  add(pieces, {turn + (*drive.depth - drive.from) / drive.withdraw_speed, drive.from, 0.0});
  return pieces;
}

Pieces force(const Drive& drive, double end) {
  const double full = drive.start + drive.rise;
  const double turn =
      drive.withdraw_force > 0.0 ? full + drive.hold : std::numeric_limits<double>::infinity();
  Pieces pieces{{0.0, 0.0, 0.0}};
  if (drive.rise > 0.0) { add(pieces, {drive.start, 0.0, drive.force / drive.rise}); }
  add(pieces, {full, drive.force, 0.0});
  if (drive.technique == Drive::Technique::intermittent) {
    const double last = std::min(end, turn);
    for (int n = 0; full + n * (drive.push + drive.pause) + drive.push < last; ++n) {
      const double off = full + n * (drive.push + drive.pause) + drive.push;
      add(pieces, {off, 0.0, 0.0});
      if (off + drive.pause < last) { add(pieces, {off + drive.pause, drive.force, 0.0}); }
    }
  }
  if (turn < std::numeric_limits<double>::infinity()) {
    add(pieces, {turn, -drive.withdraw_force, 0.0});
  }
  return pieces;
}

}  // namespace

std::vector<HandPiece> hand_motion(const Drive& drive, double end) {
  return drive.kind == Drive::Kind::trajectory ? trajectory(drive, end) : force(drive, end);
}

}  // namespace palpate::reference

namespace palpate::reference::insertion {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

Mechanics::Mechanics(const Scene& scene, const SpringNetwork& network, const Tolerance& tolerance,
                     const InsertionOptions& options)
    : problem_(network, resolve_loads(scene, network), scene.tissue.gravity,
               scene.simulation.printed),
      track_(needle_track(scene, network)),
      drive_(scene.drive.value_or(Drive{})),
      options_(options),
      slip_error_(tolerance.relative * tolerance.velocity_scale),
      tool_mass_(scene.needle ? scene.needle->mass : scene.probe->mass),
      origin_(problem_.initial_position()),
      inverse_mass_(problem_.mass().cwiseInverse()),
      position_(dof()),
      velocity_(dof()),
      force_(dof()),
      still_(VectorXd::Zero(dof())) {
  const NodeVectors start = network.initial_position() - network.rest_position;
  for (const TrackKnot& knot : track_.knots) {
    auto& nodes = supports_.emplace_back();
    Vector3d offset = Vector3d::Zero();
    double mobility = 0.0;
    for (const TrackSupport& support : knot.supports) {
      offset += support.weight * start.col(support.node);
      const Index c = problem_.coordinate(support.node);
      if (c < 0) { continue; }
      nodes.push_back({c, support.weight, support.weight * inverse_mass_(c)});
      mobility += support.weight * nodes.back().per_mass;
    }
    offset_.push_back(offset);
    mobility_.push_back(mobility);
  }
  std::vector<double> scales;
  if (relaxes(network)) {
    relaxing_ = std::make_unique<NetworkEquations<double>>(problem_);
    scales = relaxing_->branch_scales(tolerance.position_scale);
    tissue_states_ = scales.size();
  }
  for (std::size_t n = 0; n < track_.intervals.size(); ++n) {
    const TrackInterval& part = track_.intervals[n];
    if (!track_.give.empty()) { contact_states_ = std::max(contact_states_, part.branches.size()); }
    if (!scene.needle || part.travel == 0.0 || part.friction == 0.0) { continue; }
    creeping_.push_back(n);
  }
  constexpr double of_tools = 0.1;  // force of tip and shaft [N]
  scales.resize(tissue_states_ + contact_states_ + creeping_.size(), of_tools);
  scales_ = VectorXd::Map(scales.data(), static_cast<Index>(scales.size()));
  if (!has_energies() && options.account == InsertionOptions::Account::energy) {
    throw SolverError("insertion: relaxing tissue and creeping friction have no account of energy");
  }
  dy_.resize(size());
}

double Mechanics::tool_mobility(const Mode& mode) const {
  return pushes() && mode.support == Support::hand ? 1.0 / tool_mass_ : 0.0;
}

Vector3d Mechanics::knot_mean(std::size_t knot, const VectorXd& y, Index from) const {
  Vector3d mean = Vector3d::Zero();
  for (const FreeNode& node : supports_[knot]) {
    mean += node.weight * y.segment<3>(from + node.coordinate);
  }
  return mean;
}

double Mechanics::knot_displacement(std::size_t knot, const VectorXd& y) const {
  return track_.direction.dot(offset_[knot] + knot_mean(knot, y, 0));
}

void Mechanics::push_knot(std::size_t knot, const Vector3d& impulse, VectorXd& y,
                          Index from) const {
  for (const FreeNode& node : supports_[knot]) {
    y.segment<3>(from + node.coordinate) += node.per_mass * impulse;
  }
}

double Mechanics::pace(const Mode& mode, const VectorXd& y) const {
  return pace_at(mode, depth_of(mode, y), y);
}

double Mechanics::pace_at(const Mode& mode, double depth, const VectorXd& y) const {
  const bool above_tissue = mode.tip == Tip::in_track && depth < track_.entry();
  double slope = 1.0;
  const std::size_t k = mode.segment;
  if (k + 1 < track_.knots.size() && !above_tissue) {
    slope += (knot_displacement(k + 1, y) - knot_displacement(k, y)) /
             (track_.knots[k + 1].depth - track_.knots[k].depth);
  }
  if (mode.tip == Tip::cutting) {
    const double force = track_.intervals[mode.interval].cutting_force;
    slope += track_.gap_at(mode.interval, mode.stretch, depth, force)[1];
  }
  return slope;
}

/// Solves d + U(d) + gap(d, T) = s on the segment and stretch of the mode by Newton's method; U is
/// linear there, and so is the gap without a toe. T is F_c of a tip that cuts and 0 in the track,
/// which the tip does not leave while the tissue before it recovers.
double Mechanics::depth_of(const Mode& mode, const VectorXd& y) const {
  if (mode.tip == Tip::outside) { return track_.entry(); }
  if (mode.tip == Tip::stuck) { return mode.cut; }
  const double first = track_.knots[mode.segment].depth;
  const double offset = y(place()) - first - knot_displacement(mode.segment, y);
  if (mode.tip == Tip::in_track) {
    if (offset < 0.0 && mode.segment == 0) { return first + offset; }
    return std::min(first + offset / pace_at(mode, first, y), mode.cut);
  }
  const double force = track_.intervals[mode.interval].cutting_force;
  const double in_tissue = pace_at({.segment = mode.segment}, first, y);
  double depth = track_.give.empty() ? first : track_.give[mode.stretch].depth;
  for (int n = 0; n < 50; ++n) {
    const auto [gap, slope] = track_.gap_at(mode.interval, mode.stretch, depth, force);
    const double change = (offset - in_tissue * (depth - first) - gap) / (in_tissue + slope);
    depth += change;
    if (!(std::abs(change) > 1e-15)) { break; }
  }
  return depth;
}

double Mechanics::tip_lead(const Mode& mode, const VectorXd& y) const {
  const std::size_t segment = track_.segment_at(mode.cut);
  const auto hats = track_.hats(segment, mode.cut);
  double lead = y(place()) - mode.cut - hats[0] * knot_displacement(segment, y);
  if (hats[1] != 0.0) { lead -= hats[1] * knot_displacement(segment + 1, y); }
  return lead;
}

const std::vector<RelaxationBranch>& Mechanics::contact_branches(const Mode& mode) const {
  static const std::vector<RelaxationBranch> none;
  constexpr double band = 4e-12;  // of a cut that ends at the border of a layer [m]
  return track_.give.empty() ? none
                             : track_.intervals[track_.interval_at(mode.cut + band)].branches;
}

double Mechanics::relaxed_force(const Mode& mode, const VectorXd& y) const {
  double sum = 0.0;
  Index at = memory() + static_cast<Index>(tissue_states_);
  for (const RelaxationBranch& branch : contact_branches(mode)) { sum += branch.share * y(at++); }
  return sum;
}

double Mechanics::residual_gap(const Mode& mode, const VectorXd& y) const {
  const double force = relaxed_force(mode, y);
  const bool track_of_skin = mode.tip == Tip::outside && mode.cut > track_.entry();
  if (force == 0.0 || track_of_skin) { return 0.0; }
  const std::size_t interval = track_.interval_at(mode.cut);
  return track_.gap_at(interval, track_.stretch_at(mode.cut), mode.cut, force)[0];
}

void Mechanics::forget_contact(VectorXd& y) const {
  y.segment(memory() + static_cast<Index>(tissue_states_), static_cast<Index>(contact_states_))
      .setZero();
}

/// The interval from b is touched down to r, and L = f (r - b). z = delta F / L is dragged along
/// while r = xi - z, of whose two solutions z is the smaller one.
CreepingShaft Mechanics::creeping_shaft(std::size_t interval, double depth, double force) const {
  const TrackInterval& part = track_.intervals[interval];
  const double end = std::min(part.end, track_.knots.back().depth);
  const double entered = depth - part.begin;
  const double pull = part.travel * force / part.friction;  // z (r - b)
  CreepingShaft shaft;
  if (depth - pull / (end - part.begin) >= end) {
    shaft.reached = end;
  } else {
    const double square = entered * entered - 4.0 * pull;
    shaft.at_least = square < 0.0;
    shaft.reached = part.begin + 0.5 * (entered + std::sqrt(std::max(square, 0.0)));
    if (shaft.reached > end || entered < 0.0) { shaft.reached = std::min(shaft.reached, end); }
    shaft.lengthens = shaft.reached > part.begin ? part.friction : 0.0;
  }
  shaft.shares = track_.creeping_shares(interval, shaft.reached);
  shaft.limit = shaft.shares.sum();
  if (!(shaft.limit > 0.0)) { return shaft; }
  shaft.shares /= shaft.limit;
  shaft.drag = part.travel * force / shaft.limit;
  return shaft;
}

double Mechanics::pulled_surface(const Mode& mode, const VectorXd& y) const {
  if (creeping_.empty() || creeping_.front() != 0 || mode.tip == Tip::outside) { return 0.0; }
  const double force = y(size() - static_cast<Index>(creeping_.size()));
  return std::min(creeping_shaft(0, depth_of(mode, y), force).drag, 0.0);
}

Mechanics::Dragged Mechanics::dragged(const Mode& mode, const VectorXd& y) const {
  return {kinematics(mode, y).depth, y.tail(static_cast<Index>(creeping_.size()))};
}

void Mechanics::add_creeping(const Mode& mode, const VectorXd& y, Contact& contact) {
  // In the track of relaxed tissue the tip can be ahead of the tissue that it has cut.
  const bool moves =
      mode.tip == Tip::cutting || (mode.tip == Tip::in_track && contact.depth < mode.cut);
  const double deepening = moves ? contact.slip / pace_at(mode, contact.depth, y) : 0.0;
  for (std::size_t n = 0; n < creeping_.size(); ++n) {
    const Index at = size() - static_cast<Index>(creeping_.size() - n);
    dy_(at) = 0.0;
    if (mode.tip == Tip::outside) { continue; }
    const TrackInterval& part = track_.intervals[creeping_[n]];
    const double force = y(at);
    const CreepingShaft shaft = creeping_shaft(creeping_[n], contact.depth, force);
    if (!(shaft.limit > 0.0)) { continue; }
    double dragging = y(speed());
    for (std::size_t k = 0; k < track_.knots.size(); ++k) {
      const double share = shaft.shares(static_cast<Index>(k));
      if (share == 0.0) { continue; }
      dragging -= share * track_.direction.dot(knot_mean(k, y, dof()));
      push_knot(k, share * force * track_.direction, dy_, dof());
    }
    const double load = force / shaft.limit;
    dragging -= slip_of(load, dragging, part.exponent);
    const double reaching = shaft.at_least ? 0.5 * deepening : deepening - dragging;
    dy_(at) =
        shaft.limit / part.travel * dragging + load * shaft.lengthens * std::min(reaching, 0.0);
    contact.creeping_force += force;
  }
}

/// Shaft that enters tissue at once has rubbed on it over the way that it entered. Bisection finds
/// the length of shaft that agrees with its drag.
void Mechanics::reach(const Dragged& before, const Mode& mode, VectorXd& y) const {
  constexpr double no_way = 1e-9;  // [m]
  const auto count = static_cast<Index>(creeping_.size());
  if (mode.tip == Tip::outside) {
    y.tail(count).setZero();
    return;
  }
  y.tail(count) = before.force;
  const double after = kinematics(mode, y).depth;
  if (std::abs(after - before.depth) <= no_way) { return; }
  for (std::size_t n = 0; n < creeping_.size(); ++n) {
    const TrackInterval& part = track_.intervals[creeping_[n]];
    double& force = y(size() - static_cast<Index>(creeping_.size() - n));
    const CreepingShaft old = creeping_shaft(creeping_[n], before.depth, force);
    const double rest = part.begin;
    const double end = std::max(rest, std::min(part.end, track_.knots.back().depth));
    const double start = std::clamp(old.reached, rest, end);
    const auto force_at = [&](double reached) {
      const double new_shaft = reached - start;
      if (new_shaft < 0.0) { return force * (reached - rest) / (start - rest); }
      return force + part.friction * new_shaft * std::min(new_shaft / part.travel, 1.0);
    };
    const auto too_deep = [&](double reached) {  // the drag takes the border of the tissue down
      const double limit = part.friction * (reached - rest);
      return limit > 0.0 && reached > after - part.travel * force_at(reached) / limit;
    };
    double low = std::clamp(0.5 * (after + rest), rest, end);
    double high = end;
    if (!too_deep(high)) { low = high; }
    while (high - low > 1e-15) {
      const double middle = 0.5 * (low + high);
      if (!(middle > low && middle < high)) { break; }
      (too_deep(middle) ? high : low) = middle;
    }
    force = force_at(low);
  }
}

void Mechanics::add_relaxation_of_contact(const Mode& mode, const Contact& contact,
                                          const VectorXd& y) {
  Index at = memory() + static_cast<Index>(tissue_states_);
  dy_.segment(at, static_cast<Index>(contact_states_)).setZero();
  if (mode.tip == Tip::cutting) { return; }
  const double elastic = mode.tip == Tip::stuck ? contact.elastic_force : relaxed_force(mode, y);
  for (const RelaxationBranch& branch : contact_branches(mode)) {
    dy_(at) = (elastic - y(at)) / branch.time;
    ++at;
  }
}

void Mechanics::add_shaft(const Mode& mode, Contact& contact) const {
  if (mode.tip == Tip::outside) { return; }
  contact.shaft_weights = track_.friction_shares(mode.segment, mode.interval, contact.depth);
  contact.capacity = contact.shaft_weights.sum();
  constexpr double no_friction = 1e-14;  // of a shaft that has just entered [N]
  if (std::abs(contact.capacity) < no_friction) {
    contact.capacity = 0.0;
    contact.shaft_weights = contact.tip_weights;
  } else {
    contact.shaft_weights /= contact.capacity;
  }
}

Contact Mechanics::kinematics(const Mode& mode, const VectorXd& y) const {
  Contact contact{.depth = depth_of(mode, y)};
  const auto count = static_cast<Index>(track_.knots.size());
  contact.tip_weights = VectorXd::Zero(count);
  const auto hats = track_.hats(mode.segment, contact.depth);
  const auto k = static_cast<Index>(mode.segment);
  contact.tip_weights(k) = hats[0];
  if (k + 1 < count) { contact.tip_weights(k + 1) = hats[1]; }
  contact.shaft_weights = contact.tip_weights;
  add_shaft(mode, contact);
  contact.slip = y(speed());
  contact.shaft_slip = y(speed());
  for (Index i = 0; i <= std::min(k + 1, count - 1); ++i) {
    const auto knot = static_cast<std::size_t>(i);
    const double velocity = track_.direction.dot(knot_mean(knot, y, dof()));
    const double h = contact.tip_weights(i);
    const double share = contact.shaft_weights(i);
    contact.slip -= h * velocity;
    contact.shaft_slip -= share * velocity;
    contact.tip_mobility += h * h * mobility_[knot];
    contact.shaft_mobility += share * share * mobility_[knot];
    contact.mixed_mobility += h * share * mobility_[knot];
  }
  if (mode.tip == Tip::stuck && !track_.give.empty()) {
    const std::size_t stretch = track_.stretch_at(mode.cut);
    contact.give = track_.give_at(mode.interval, stretch, mode.cut)[0];
    contact.elastic_force = track_.force_at(mode.interval, stretch, mode.cut, tip_lead(mode, y));
    contact.tip_force = contact.elastic_force - relaxed_force(mode, y);
    contact.pressed_energy =
        track_.energy_at(mode.interval, stretch, mode.cut, contact.elastic_force);
  } else if (mode.tip == Tip::cutting) {
    contact.give = track_.give_at(mode.interval, mode.stretch, contact.depth)[0];
    contact.tip_force = track_.intervals[mode.interval].cutting_force;
    contact.pressed_energy =
        track_.energy_at(mode.interval, mode.stretch, contact.depth, contact.tip_force);
  }
  const double tool = tool_mobility(mode);
  contact.tip_mobility += tool;
  contact.shaft_mobility += tool;
  contact.mixed_mobility += tool;
  return contact;
}

/// Computes T and F_f from the slip rates in their absence.
void Mechanics::solve_forces(const Mode& mode, double slip_rate, double shaft_rate,
                             Contact& c) const {
  const bool sticks = mode.shaft == Shaft::sticks && mode.tip != Tip::outside;
  const bool rigid = mode.tip == Tip::stuck && c.give == 0.0;
  if (!sticks && mode.tip != Tip::outside) {
    c.shaft_force = mode.shaft == Shaft::forward ? c.capacity : -c.capacity;
  }
  if (rigid && sticks) {
    const double gram = c.tip_mobility * c.shaft_mobility - c.mixed_mobility * c.mixed_mobility;
    c.tip_force = (c.shaft_mobility * slip_rate - c.mixed_mobility * shaft_rate) / gram;
    c.shaft_force = (c.tip_mobility * shaft_rate - c.mixed_mobility * slip_rate) / gram;
  } else if (rigid) {
    c.tip_force = (slip_rate - c.mixed_mobility * c.shaft_force) / c.tip_mobility;
  } else if (sticks) {
    c.shaft_force = (shaft_rate - c.mixed_mobility * c.tip_force) / c.shaft_mobility;
  }
  c.slip_rate = slip_rate - c.tip_mobility * c.tip_force - c.mixed_mobility * c.shaft_force;
  c.shaft_slip_rate =
      shaft_rate - c.mixed_mobility * c.tip_force - c.shaft_mobility * c.shaft_force;
  c.tool_acceleration -= tool_mobility(mode) * (c.tip_force + c.shaft_force);
}

/// Computes accelerations in dy_ without the tool, with passed contact points held across n.
void Mechanics::free_acceleration(double time, const Mode& mode, const VectorXd& y,
                                  Contact& contact) {
  const Index n = dof();
  position_ = origin_ + y.head(n);
  velocity_ = y.segment(n, n);
  dy_.head(n) = velocity_;
  if (relaxing_) {
    const auto further = y.segment(memory(), static_cast<Index>(tissue_states_));
    state_.assign(y.begin(), y.begin() + 2 * n);
    state_.insert(state_.end(), further.begin(), further.end());
    relaxing_->derivative(time, mode.gate, state_, state_rate_);
    dy_.segment(n, n) = VectorXd::Map(state_rate_.data() + n, n);
    dy_.segment(memory(), further.size()) =
        VectorXd::Map(state_rate_.data() + 2 * n, further.size());
  } else {
    problem_.force(time, mode.gate, position_, velocity_, force_);
    dy_.segment(n, n) = force_.cwiseProduct(inverse_mass_);
  }
  add_creeping(mode, y, contact);
  const Vector3d& direction = track_.direction;
  for (std::size_t k = 0; k < mode.locked_at.size(); ++k) {
    if (mobility_[k] == 0.0) { continue; }
    const Vector3d mean = knot_mean(k, dy_, n);
    const Vector3d hold = -(mean - direction.dot(mean) * direction) / mobility_[k];
    push_knot(k, hold, dy_, n);
    contact.lateral -= hold;
  }
}

/// Returns the factor of (h_k - l_k / L) in the rate of l_k / L due to motion of the tip in the
/// tissue [1/s].
double Mechanics::share_rate(const Mode& mode, const Contact& contact, const VectorXd& y) const {
  // In the track of relaxed tissue the tip can be ahead of the tissue that it has cut.
  const bool moves =
      mode.tip == Tip::cutting || (mode.tip == Tip::in_track && contact.depth < mode.cut);
  const TrackInterval& part = track_.intervals[mode.interval];
  if (!moves || contact.capacity == 0.0 || part.travel > 0.0) { return 0.0; }
  const double deepening = contact.slip / pace_at(mode, contact.depth, y);
  return part.friction * deepening / contact.capacity;
}

Contact Mechanics::evaluate(double time, const Mode& mode, const VectorXd& y, VectorXd* dy) {
  ++evaluations_;
  Contact contact = kinematics(mode, y);
  free_acceleration(time, mode, y, contact);
  const double hand = mode.hand.at(time);
  if (pushes() && mode.support == Support::hand) {
    contact.tool_acceleration =
        (hand - drive_.hand_viscosity * y(speed()) - contact.creeping_force) / tool_mass_;
  }
  double slip_rate = contact.tool_acceleration;
  double shaft_rate = contact.tool_acceleration;
  const double rate = share_rate(mode, contact, y);
  const Index last =
      std::min(static_cast<Index>(mode.segment) + 1, static_cast<Index>(track_.knots.size()) - 1);
  for (Index k = 0; k <= last; ++k) {
    const auto knot = static_cast<std::size_t>(k);
    const double acceleration = track_.direction.dot(knot_mean(knot, dy_, dof()));
    const double velocity = track_.direction.dot(knot_mean(knot, y, dof()));
    const double share = contact.shaft_weights(k);
    slip_rate -= contact.tip_weights(k) * acceleration;
    shaft_rate -= share * acceleration + rate * (contact.tip_weights(k) - share) * velocity;
  }
  solve_forces(mode, slip_rate, shaft_rate, contact);
  if (pushes() && mode.support == Support::bone) {
    contact.bone_force = hand - contact.tip_force - contact.shaft_force - contact.creeping_force;
  }
  for (Index k = 0; k <= last && mode.tip != Tip::outside; ++k) {
    const double force =
        contact.tip_force * contact.tip_weights(k) + contact.shaft_force * contact.shaft_weights(k);
    push_knot(static_cast<std::size_t>(k), force * track_.direction, dy_, dof());
  }
  if (dy != nullptr) {
    dy_(place()) = y(speed());
    dy_(speed()) = contact.tool_acceleration;
    add_relaxation_of_contact(mode, contact, y);
    add_powers(time, mode, contact, y, dy_);
    *dy = dy_;
  }
  return contact;
}

void Mechanics::add_powers(double time, const Mode& mode, const Contact& contact, const VectorXd& y,
                           VectorXd& dy) {
  const double speed_now = y(speed());
  auto power = dy.segment<4>(work());
  if (pushes()) {
    power(0) = (mode.hand.at(time) - drive_.hand_viscosity * speed_now) * speed_now;
  } else {
    power(0) = (contact.tip_force + contact.shaft_force + contact.creeping_force) * speed_now;
    if (mode.support == Support::bone) {
      power(0) += drive_.grip_stiffness * (mode.hand.at(time) - y(place())) * mode.hand.rate;
    }
  }
  power(1) = 0.0;
  if (options_.account == InsertionOptions::Account::energy) {
    const double with = velocity_.dot(force_);
    problem_.force(time, mode.gate, position_, still_, force_);
    power(1) = velocity_.dot(force_) - with;
  }
  power(2) = contact.shaft_force * contact.shaft_slip;
  const bool moves = mode.tip == Tip::cutting || contact.give > 0.0;
  power(3) = moves ? contact.tip_force * contact.slip : 0.0;
}

double Mechanics::stored_energy(double time, const Mode& mode, const VectorXd& y) const {
  double energy = problem_.energy(origin_ + y.head(dof()), y.segment(dof(), dof()));
  energy += kinematics(mode, y).pressed_energy;
  if (pushes()) {
    energy += 0.5 * tool_mass_ * y(speed()) * y(speed());
  } else if (mode.support == Support::bone) {
    const double stretch = mode.hand.at(time) - y(place());
    energy += 0.5 * drive_.grip_stiffness * stretch * stretch;
  }
  return energy;
}

}  // namespace palpate::reference::insertion
