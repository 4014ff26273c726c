// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>

namespace palpate {

/// Bad input: one line per problem, each already in the form "FILE:LINE: found; allowed".
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace palpate
