// SPDX-License-Identifier: MIT
#pragma once
/// Capabilities of a subject: names of the bits of palpate_subject.h, and those that a scene needs.

#include <cstdint>
#include <stdexcept>
#include <string>

#include "model/problem/scene.hpp"
#include "validation/subject/palpate_subject.h"

namespace palpate {

using Capabilities = std::uint64_t;
inline constexpr Capabilities every_capability = 2 * PALPATE_CAN_REPEAT - 1;

/// Returns the names of the bits, separated by spaces: "springs state".
std::string names_of(Capabilities bits);

/// Returns what a subject needs for a scene. `network` is the tissue of the scene. Throws CannotDo
/// for an oscillator and for the printed equations of the paper, which only the model has.
Capabilities needs_of(const Scene& scene, const SpringNetwork& network);

/// Returns the needs that capabilities lack. A subject with its own discretisation needs none of
/// springs, damping and fixed nodes for tissue in layers with a tool.
Capabilities missing(Capabilities capabilities, const Scene& scene, Capabilities needs);

/// The subject does not declare a capability. The case is skipped.
class CannotDo : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The subject refuses a scene of which it declares every need. The case ends with an error.
class Refused : public CannotDo {
  using CannotDo::CannotDo;
};

/// The subject crashed, did not answer, broke the protocol or reported a failure. The case ends
/// with an error.
class SubjectFailure : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Self-description of a subject.
struct SubjectFacts {
  std::string name{};
  std::string version{};
  std::string licence{};      ///< SPDX identifier
  std::string parameters{};   ///< names, comma-separated
  std::string carrier{};      ///< "in process", "shared library", "pipe", "trace"
  std::string confinement{};  ///< "confined", or why the subject could read references; empty: none
  Capabilities capabilities = 0;
  bool replayed = false;  ///< a trace: one step, one stiffness, no time
  bool sparse = false;    ///< columns that it does not have are NaN from the first row on
};

/// Returns true if the subject declares a parameter of that name.
inline bool has_parameter(const SubjectFacts& facts, const std::string& name) {
  return ("," + facts.parameters + ",").find("," + name + ",") != std::string::npos;
}

}  // namespace palpate
