// SPDX-License-Identifier: MIT

#include "reference/insertion_mechanics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::reference {

namespace {

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
      dy_(size()),
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
  double slope = 1.0;
  const std::size_t k = mode.segment;
  if (k + 1 < track_.knots.size()) {
    slope += (knot_displacement(k + 1, y) - knot_displacement(k, y)) /
             (track_.knots[k + 1].depth - track_.knots[k].depth);
  }
  if (mode.tip == Tip::cutting && !track_.give.empty()) {
    slope += track_.phi_in(mode.interval, track_.intervals[mode.interval].cutting_force) *
             track_.give_at(mode.interval, mode.stretch, 0.0)[1];
  }
  return slope;
}

/// Solves d + U(d) + c_s(d) T = s on the segment and stretch of the mode, where U and c_s are
/// linear; T is F_c of a tip that cuts and 0 in the track.
double Mechanics::depth_of(const Mode& mode, const VectorXd& y) const {
  if (mode.tip == Tip::outside) { return track_.entry(); }
  if (mode.tip == Tip::stuck) { return mode.cut; }
  const double begin = track_.knots[mode.segment].depth;
  double ahead = y(place()) - begin - knot_displacement(mode.segment, y);
  if (mode.tip == Tip::cutting && !track_.give.empty()) {
    ahead -= track_.phi_in(mode.interval, track_.intervals[mode.interval].cutting_force) *
             track_.give_at(mode.interval, mode.stretch, begin)[0];
  }
  return begin + ahead / pace(mode, y);
}

double Mechanics::tip_lead(const Mode& mode, const Contact& contact, const VectorXd& y) const {
  double lead = y(place()) - mode.cut;
  for (std::size_t k = mode.segment; k < track_.knots.size(); ++k) {
    const double h = contact.tip_weights(static_cast<Index>(k));
    if (h != 0.0) { lead -= h * knot_displacement(k, y); }
  }
  return lead;
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
  const TrackDent* large = track_.dent_in(mode.interval);
  if (mode.tip == Tip::stuck && !track_.give.empty()) {
    contact.give = track_.give_at(mode.interval, track_.stretch_at(mode.cut), mode.cut)[0];
    contact.tip_force = tip_lead(mode, contact, y) / contact.give;
    if (large != nullptr) { contact.tip_force = large->force_of(contact.tip_force); }
  } else if (mode.tip == Tip::cutting) {
    contact.give = track_.give_at(mode.interval, mode.stretch, contact.depth)[0];
    contact.tip_force = track_.intervals[mode.interval].cutting_force;
  }
  const double work = large != nullptr ? large->work(contact.tip_force)
                                       : 0.5 * contact.tip_force * contact.tip_force;
  contact.pressed_energy = contact.give * work;
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
  problem_.force(time, mode.gate, position_, velocity_, force_);
  dy_.head(n) = velocity_;
  dy_.segment(n, n) = force_.cwiseProduct(inverse_mass_);
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
  const bool moves = mode.tip == Tip::cutting || mode.tip == Tip::in_track;
  if (!moves || contact.capacity == 0.0) { return 0.0; }
  const double deepening = contact.slip / pace(mode, y);
  return track_.intervals[mode.interval].friction * deepening / contact.capacity;
}

Contact Mechanics::evaluate(double time, const Mode& mode, const VectorXd& y, VectorXd* dy) {
  ++evaluations_;
  Contact contact = kinematics(mode, y);
  free_acceleration(time, mode, y, contact);
  const double hand = mode.hand.at(time);
  if (pushes() && mode.support == Support::hand) {
    contact.tool_acceleration = (hand - drive_.hand_viscosity * y(speed())) / tool_mass_;
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
    contact.bone_force = hand - contact.tip_force - contact.shaft_force;
  }
  for (Index k = 0; k <= last && mode.tip != Tip::outside; ++k) {
    const double force =
        contact.tip_force * contact.tip_weights(k) + contact.shaft_force * contact.shaft_weights(k);
    push_knot(static_cast<std::size_t>(k), force * track_.direction, dy_, dof());
  }
  if (dy != nullptr) {
    dy_(place()) = y(speed());
    dy_(speed()) = contact.tool_acceleration;
    add_powers(time, mode, contact, y, dy_);
    *dy = dy_;
  }
  return contact;
}

void Mechanics::add_powers(double time, const Mode& mode, const Contact& contact, const VectorXd& y,
                           VectorXd& dy) {
  const double speed_now = y(speed());
  auto power = dy.tail<4>();
  if (pushes()) {
    power(0) = (mode.hand.at(time) - drive_.hand_viscosity * speed_now) * speed_now;
  } else {
    power(0) = (contact.tip_force + contact.shaft_force) * speed_now;
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
