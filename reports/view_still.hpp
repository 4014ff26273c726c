// SPDX-License-Identifier: MIT
#pragma once
/// Still pictures of a view, painted from far to near without a GPU: for paper, and for browsers
/// that cannot show the view itself.

#include <string>

#include "reports/view.hpp"

namespace palpate {

/// <svg> of the undeformed tissue in the colours of what it is made of.
std::string still_at_rest(const View& view);

/// <svg> at a frame, coloured by displacement, whose movement is `enlarged` so many times.
std::string still_at(const View& view, std::size_t frame, double enlarged);

}  // namespace palpate
