// SPDX-License-Identifier: MIT
#include "model/dynamics/spring_list.hpp"

#include <algorithm>

#include "model/dynamics/lattice.hpp"
#include "tests/check.hpp"
#include "tests/model/random_network.hpp"

namespace {

using namespace palpate;

bool same(const Spring& one, const Spring& other) {
  return one.a == other.a && one.b == other.b && one.stiffness == other.stiffness && one.viscosity == other.viscosity &&
         one.rest_length == other.rest_length;
}

bool holds(const SpringList& list, const std::vector<Spring>& springs) {
  bool all = list.size() == springs.size() && list.empty() == springs.empty() &&
             std::ranges::equal(list, springs, same) && std::ranges::equal(list.listed(), springs, same);
  for (std::size_t n = 0; n < springs.size(); ++n) { all = all && same(list[n], springs[n]); }
  return all;
}

/// As a lattice's builder would list them, without keeping any once.
std::vector<Spring> chains(int rows, int nodes) {
  std::vector<Spring> springs;
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i + 1 < nodes; ++i) {
      const int a = row * nodes + i;
      springs.push_back({a, a + 1, 50.0, 0.1, 0.01});
      if (i + 2 < nodes) { springs.push_back({a, a + 2, 20.0, 0.0, 0.02}); }
    }
  }
  return springs;
}

TEST("a list gives back its springs in their order, whatever they are") {
  CHECK(holds({}, {}));
  CHECK(holds(chains(1, 9), chains(1, 9)));
  CHECK(holds(chains(7, 9), chains(7, 9)));
  std::vector<Spring> springs = random_network(5, {.nodes = 30, .springs = 200}).springs.listed();
  CHECK(springs.size() == 200 && holds(springs, springs));
  std::ranges::sort(springs, {}, &Spring::a);
  CHECK(holds(springs, springs));
  springs.insert(springs.end(), {springs.front(), springs.front(), springs[3], springs[3]});  // twice in a row
  CHECK(holds(springs, springs));
}

TEST("a spring may come after any other") {
  SpringList list = chains(4, 6);
  std::vector<Spring> springs = chains(4, 6);
  for (const Spring& more :
       {springs.back(), springs.front(), Spring{23, 0, 1.0, 0.0, 0.5}, Spring{24, 0, 1.0, 0.0, 0.5},
        Spring{25, 1, 1.0, 0.0, 0.5}}) {
    list.push_back(more);
    springs.push_back(more);
    CHECK(holds(list, springs));
  }
}

TEST("what was edited is what the list holds") {
  SpringList list = chains(3, 5);
  list.change_each([](Spring& spring) { spring.stiffness *= 2.0; });
  CHECK(std::ranges::all_of(list, [](const Spring& s) { return s.stiffness == 100.0 || s.stiffness == 40.0; }));
  list.edit([](std::vector<Spring>& all) { all.erase(all.begin() + 1); });
  CHECK(list.size() == chains(3, 5).size() - 1);
  CHECK(same(list[1], {1, 2, 100.0, 0.1, 0.01}));
}

TEST("a lattice's springs take kilobytes, one by one they would take megabytes") {
  const SpringList& list = uniform_lattice({{40, 40, 40}, 0.01, 26}, 50.0, 0.05, 1e-3).springs;
  CHECK(list.size() * sizeof(Spring) > 20'000'000);
  CHECK(list.memory_bytes() < 400'000);
}

TEST("a network whose springs all differ takes no more than twice its list") {
  SpringList list = uniform_lattice({{8, 8, 8}, 0.01, 26}, 50.0, 0.05, 1e-3).springs;
  double factor = 1.0;
  list.change_each([&](Spring& spring) { spring.stiffness *= (factor += 1e-3); });
  CHECK(list.memory_bytes() < 2 * list.size() * sizeof(Spring));
}

TEST("damping is found wherever it is") {
  std::vector<Spring> springs = chains(2, 5);
  for (Spring& spring : springs) { spring.viscosity = 0.0; }
  CHECK(!is_damped(springs) && !is_damped({}));
  springs[9].viscosity = 1e-9;
  CHECK(is_damped(springs));
}

}  // namespace
