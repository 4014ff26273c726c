// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/check.hpp"
#include "validation/claims/groups.hpp"

namespace {

using namespace palpate;

Outcome outcome_of(const std::string& name, const Mutation* mutation) {
  const std::vector<Case> cases = oscillator_cases();
  const auto found = std::ranges::find(cases, name, &Case::name);
  if (found == cases.end()) {
    return {.name = name, .status = Status::error, .reasons = {"no case"}};
  }
  return run_case(*found, {.quick = true, .mutation = mutation});
}

/// Checks that the case passes without the fault and fails with it because of a measured value.
void check_caught(const std::vector<std::string>& names, const Mutation& mutation) {
  for (const std::string& name : names) {
    const Status sound = outcome_of(name, nullptr).status;
    const Status faulty = outcome_of(name, &mutation).status;
    if (sound != Status::pass || faulty != Status::fail) {
      std::printf("  %s: %s without and %s with \"%s\"\n", name.c_str(), name_of(sound).data(),
                  name_of(faulty).data(), mutation.name.c_str());
    }
    CHECK(sound == Status::pass);
    CHECK(faulty == Status::fail);
  }
}

const std::vector<std::string>& schemes() {
  static const std::vector<std::string> all{
      "euler",           "euler-cromer", "feynman-newton", "feynman-newton-printed", "leapfrog",
      "velocity-verlet", "rk4",          "implicit-euler", "implicit-midpoint"};
  return all;
}

/// Names "oscillator/<check>/<scheme>" of all schemes, or of the explicit ones.
std::vector<std::string> of_every_scheme(const std::string& check, bool with_implicit = true) {
  std::vector<std::string> names;
  for (const std::string& scheme : schemes()) {
    if (!with_implicit && scheme.starts_with("implicit")) { continue; }
    names.push_back("oscillator/" + check + "/" + scheme);
  }
  return names;
}

const std::vector<std::string>& single_cases() {
  static const std::vector<std::string> names{"oscillator/regimes",        "oscillator/figure-6",
                                              "oscillator/figure-7",       "oscillator/figure-8",
                                              "oscillator/figure-9",       "oscillator/figure-10",
                                              "oscillator/who-is-closest", "oscillator/sweep"};
  return names;
}

void check_caught_everywhere(const Mutation& mutation) {
  check_caught(of_every_scheme("order"), mutation);
  check_caught(of_every_scheme("discrete"), mutation);
  check_caught(of_every_scheme("stability-limit", false), mutation);
  check_caught(single_cases(), mutation);
}

TEST("each contracted case exists and every one passes as it is") {
  std::vector<std::string> names = single_cases();
  for (const std::string check : {"order", "discrete", "stability-limit"}) {
    std::ranges::copy(of_every_scheme(check), std::back_inserter(names));
  }
  const std::vector<Case> cases = oscillator_cases();
  CHECK(cases.size() == names.size());
  for (const std::string& name : names) { CHECK(outcome_of(name, nullptr).status == Status::pass); }
}

TEST("a damper that feeds energy in turns every case red") {
  check_caught_everywhere({.name = "sign of damping", .model = [](Scene& scene, SpringNetwork&) {
                             scene.tissue.oscillator.viscosity *= -1.0;
                           }});
}

TEST("a step taken with twice its length turns every case red") {
  check_caught_everywhere({.name = "step twice", .step_twice = true});
}

TEST("a stiffness that is 1 % too high turns every case red") {
  check_caught_everywhere({.name = "stiffness + 1 %", .model = [](Scene& scene, SpringNetwork&) {
                             scene.tissue.oscillator.stiffness *= 1.01;
                           }});
}

TEST("one position that is not a number turns every case red") {
  const Mutation mutation{.name = "NaN", .trace = [](Trace& motion) {
                            motion.position(0, motion.position.cols() / 2) =
                                std::numeric_limits<double>::quiet_NaN();
                          }};
  check_caught_everywhere(mutation);
  check_caught(
      {"oscillator/stability-limit/implicit-euler", "oscillator/stability-limit/implicit-midpoint"},
      mutation);
}

/// Stability cases and first-order cases are excluded: a stability limit does not depend on sample
/// times, and a first-order error hides a fault of the same size.
TEST("samples shifted by one step turn every trajectory check red") {
  const Mutation mutation{.name = "shifted by one", .trace = [](Trace& motion) {
                            for (Eigen::MatrixXd* samples : {&motion.position, &motion.velocity}) {
                              if (samples->cols() < 2) { continue; }
                              const Eigen::MatrixXd all = *samples;
                              samples->rightCols(all.cols() - 1) = all.leftCols(all.cols() - 1);
                            }
                          }};
  check_caught(of_every_scheme("discrete"), mutation);
  check_caught({"oscillator/order/leapfrog", "oscillator/order/velocity-verlet",
                "oscillator/order/rk4", "oscillator/order/implicit-midpoint"},
               mutation);
  check_caught(single_cases(), mutation);
}

TEST("a motion that ends early turns every case red") {
  check_caught_everywhere({.name = "half of the samples", .trace = [](Trace& motion) {
                             const Eigen::Index half = motion.position.cols() / 2;
                             motion.position.conservativeResize(Eigen::NoChange, half);
                             motion.velocity.conservativeResize(Eigen::NoChange, half);
                             motion.time.resize(static_cast<std::size_t>(half));
                           }});
}

TEST("two runs of a case give the same numbers") {
  for (const std::string name : {"oscillator/order/rk4", "oscillator/stability-limit/leapfrog",
                                 "oscillator/who-is-closest"}) {
    const Outcome first = outcome_of(name, nullptr);
    const Outcome second = outcome_of(name, nullptr);
    REQUIRE(first.quantities.size() == second.quantities.size());
    for (std::size_t n = 0; n < first.quantities.size(); ++n) {
      CHECK_NEAR(first.quantities[n].value, second.quantities[n].value, 1e-300);
    }
    CHECK(first.notes == second.notes);
  }
}

}  // namespace
