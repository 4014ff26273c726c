// SPDX-License-Identifier: MIT
/// What happens to a tool, and what of it is told.
#include "model/stepping/tool_contact.hpp"

namespace palpate {

std::string_view name_of(ToolEvent event) {
  switch (event) {
    case ToolEvent::contact: return "contact";
    case ToolEvent::puncture: return "puncture";
    case ToolEvent::loss_of_resistance: return "loss-of-resistance";
    case ToolEvent::bone: return "bone";
    case ToolEvent::dural_puncture: return "dural-puncture";
    case ToolEvent::withdrawn: break;
  }
  return "withdrawn";
}

template <class Real>
void ToolContact<Real>::happen(double t, ToolEvent event, std::size_t interval) noexcept {
  if (happening_count_ < happenings_.size()) {
    happenings_[happening_count_++] = {t, event, interval};
  }
}

/// The tip begins to cut an interval: reported once each, in order.
template <class Real>
void ToolContact<Real>::enter(std::size_t interval, double t) noexcept {
  for (std::size_t next = entered_ ? deepest_ + 1 : 0; next <= interval; ++next) {
    const TissueRole role = path_.intervals()[next].role;
    happen(t,
           role == TissueRole::epidural_space ? ToolEvent::loss_of_resistance
           : role == TissueRole::dura         ? ToolEvent::dural_puncture
                                              : ToolEvent::puncture,
           next);
    deepest_ = next;
    entered_ = true;
  }
}

template <class Real>
void ToolContact<Real>::leave(double t) noexcept {
  if (present_) { happen(t, ToolEvent::withdrawn, 0); }
  present_ = false;
}

template void ToolContact<double>::happen(double, ToolEvent, std::size_t) noexcept;
template void ToolContact<float>::happen(double, ToolEvent, std::size_t) noexcept;
template void ToolContact<double>::enter(std::size_t, double) noexcept;
template void ToolContact<float>::enter(std::size_t, double) noexcept;
template void ToolContact<double>::leave(double) noexcept;
template void ToolContact<float>::leave(double) noexcept;

}  // namespace palpate
