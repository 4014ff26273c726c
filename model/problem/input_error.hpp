// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>

namespace palpate {

/// Invalid input, with one line per problem in the form "FILE:LINE: found; allowed".
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file that does not exist.
class AbsentFile : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace palpate
