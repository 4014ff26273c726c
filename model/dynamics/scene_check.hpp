// SPDX-License-Identifier: MIT
#pragma once
/// Every physical rule on a Scene, checked at once.

#include <stdexcept>
#include <string>
#include <vector>

#include "model/dynamics/scene.hpp"

namespace palpate {

/// One broken rule: the dotted key it is about ("tissue.lattice.spacing", "layer[2].thickness")
/// and what was found and what is allowed.
struct Violation {
  std::string key{};
  std::string message{};
};

/// What to say of a material that is not among `known`.
std::string unknown_material(const std::string& name, const std::vector<Material>& known);

/// All broken rules of a scene; empty when it can be simulated.
std::vector<Violation> check_scene(const Scene& scene);

/// Bad input: one line per problem, each already in the form "FILE:LINE: found; allowed".
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace palpate
