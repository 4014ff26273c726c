// SPDX-License-Identifier: MIT
/// Implicit steps hold tip and shaft by what was foreseen when they began; here it is foreseen, and revised
/// (model/EQUATIONS.md, "Held constraints").
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/stepping/tool_contact.hpp"

namespace palpate {

/// A tip that stuck goes on pushing by as much more as in the last step; one that begins to stick has to
/// bring the tissue to its own velocity, whose response to that is known. Where that is more than F_c the step
/// is begun cutting, so that it need not be solved twice; revise() has the last word.
template <class Real>
void ToolContact<Real>::foresee_cutting() noexcept {
  if (tip_ != TipMode::stuck || !held_.learned() || !(contact_.tip_tip > 0.0)) { return; }
  const double response = held_.response_at(at_.knot, at_.share, n_) + tool_mobility();
  const double more = stuck_before_ ? step_tip_change_ : stopped_ / (step_length_ * response);
  if (step_tip_force_ + more > cutting_force()) { tip_ = TipMode::cutting; }
}

template <class Real>
bool ToolContact<Real>::revise(const State<Real>& state) noexcept {
  if (!in_tissue()) { return false; }
  gather(state.position, state.velocity);
  if (is_coordinate()) { velocity_ = static_cast<double>(state.velocity(tool_)); }
  const Slack allowed = slack();
  const bool tip = revise_tip(velocity_ - velocity_at(at_), allowed);
  const bool shaft = revise_shaft(slip_now(), allowed);
  first_evaluation_ = true;
  return tip || shaft;
}

/// The solver's tolerance on velocities and the rounding of places, and the forces over a step that change
/// what is held by as much. A law that is broken by less is the solver's doing: solving again finds it broken
/// the other way. What is left of it is settled when the step ends.
template <class Real>
typename ToolContact<Real>::Slack ToolContact<Real>::slack() const noexcept {
  constexpr double roundings = 8.0 * static_cast<double>(std::numeric_limits<Real>::epsilon());
  double fastest = std::abs(velocity_);
  for (const Knot& knot : knots_) { fastest = std::max(fastest, std::abs(knot.velocity)); }
  const double velocity =
      tolerance_ * fastest + roundings * std::max(std::abs(place_), knots_.back().depth) / step_length_;
  Slack allowed{.velocity = velocity};
  const auto force = [&](std::size_t row) { return velocity / (step_length_ * held_.response_of(row)); };
  if (contact_.tip_held) { allowed.tip = force(0); }
  if (contact_.shaft_held) { allowed.shaft = force(contact_.tip_held ? 1 : 0); }
  return allowed;
}

/// `rate`: of the tip against the tissue when the step ended [m/s].
template <class Real>
bool ToolContact<Real>::revise_tip(double rate, const Slack& slack) noexcept {
  const TipMode before = tip_;
  switch (tip_) {
    case TipMode::outside: break;
    case TipMode::stuck:
      if (!contact_.tip_held) { break; }
      if (tip_force_ > cutting_force() + slack.tip) { tip_ = TipMode::cutting; }
      if (tip_force_ < -slack.tip) { tip_ = TipMode::in_track; }
      break;
    case TipMode::cutting:
    case TipMode::in_track:
      if (tip_ == TipMode::cutting ? rate < -slack.velocity
                                   : rate > slack.velocity && depth_begin_ >= cut_) {
        tip_ = contact_.tip_tip > 0.0 ? TipMode::stuck : tip_;
      }
      break;
  }
  return tip_ != before;
}

template <class Real>
bool ToolContact<Real>::revise_shaft(double slip, const Slack& slack) noexcept {
  if (!may_hold_shaft()) { return false; }
  const ShaftMode before = shaft_;
  if (shaft_ == ShaftMode::stick) {
    if (contact_.shaft_held && std::abs(shaft_force_) > limit_ + slack.shaft) {
      shaft_ = shaft_force_ > 0.0 ? ShaftMode::forward : ShaftMode::backward;
    }
  } else if (shaft_ == ShaftMode::forward ? slip < -slack.velocity : slip > slack.velocity) {
    shaft_ = ShaftMode::stick;
  }
  return shaft_ != before;
}

template void ToolContact<double>::foresee_cutting() noexcept;
template void ToolContact<float>::foresee_cutting() noexcept;
template bool ToolContact<double>::revise(const State<double>&) noexcept;
template bool ToolContact<float>::revise(const State<float>&) noexcept;

}  // namespace palpate
