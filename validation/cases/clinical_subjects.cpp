// SPDX-License-Identifier: MIT
/// Corridor and bootstrap over subjects who differ by a factor of their own.
#include <cmath>

#include "validation/cases/clinical_parts.hpp"
#include "validation/cases/clinical_traces.hpp"
#include "validation/comparison/group_comparison.hpp"

namespace palpate::clinical {

namespace {

using namespace comparison;

Samples subject(const std::vector<double>& time, double factor) {
  Samples samples{.step = time[1] - time[0], .value = pressures({}, time)};
  for (double& v : samples.value) { v *= factor; }
  return samples;
}

double drawn_factor(device::Seeded& seeded) { return 1.0 + 0.1 * seeded.normal(); }

/// A further subject lies in the corridor of the others with the probability it was made for.
void measure_corridor(const CaseContext& context, Outcome& outcome) {
  const std::vector<double> time = instants(10.0, 10.0);
  constexpr std::size_t trials = 1000;
  for (const std::size_t count : {3UL, 8UL}) {
    device::Seeded seeded(count);
    std::size_t inside = 0;
    for (std::size_t n = 0; n < trials; ++n) {
      std::vector<Samples> subjects;
      for (std::size_t m = 0; m < count; ++m) { subjects.push_back(subject(time, drawn_factor(seeded))); }
      Samples further = subject(time, drawn_factor(seeded));
      damage(context, further.value);
      const CorridorBuilt built = build_corridor(subjects);
      inside += built.corridor && coverage(*built.corridor, further).holds ? 1 : 0;
    }
    const Interval expected = expected_share(0.95, trials);
    outcome.judge({.name = "further_subjects_inside_of_" + std::to_string(count),
                   .value = static_cast<double>(inside) / trials,
                   .lower = expected.lower,
                   .upper = expected.upper,
                   .bound_from = "Student: 0.95 of further subjects; binomial, 0.999"});
  }
  const std::vector<Samples> one{subject(time, 1.0)};
  outcome.judge({.name = "corridors_of_one_subject",
                 .value = build_corridor(one).corridor ? 1.0 : 0.0,
                 .upper = 0.0,
                 .bound_from = "one subject has no spread: refused"});
}

/// Ten subjects; the bootstrap of their mean covers less than it says, by what theory tells.
void measure_bootstrap(const CaseContext& context, Outcome& outcome) {
  constexpr std::size_t trials = 400;
  constexpr std::size_t count = 10;
  device::Seeded seeded(77);
  std::size_t covered = 0;
  for (std::size_t n = 0; n < trials; ++n) {
    std::vector<double> values;
    for (std::size_t m = 0; m < count; ++m) { values.push_back(drawn_factor(seeded)); }
    damage(context, values);
    const auto interval = bootstrap_mean(values, {.draws = 500, .seed = n + 1});
    covered += interval && interval->holds(1.0) ? 1 : 0;
  }
  constexpr double normal_factor = 1.959964;  // 0.95 of a normal distribution
  const double theory = student_share(normal_factor * std::sqrt((count - 1.0) / count), count - 1);
  const Interval expected = expected_share(theory, trials);
  outcome.judge(
      {.name = "share_of_bootstrap_intervals_that_hold_the_mean",
       .value = static_cast<double>(covered) / trials,
       .lower = expected.lower,
       .upper = expected.upper,
       .bound_from = "theory: Student's t at 1.96 sqrt(9/10), 0.90 instead of 0.95; binomial, 0.999"});
}

}  // namespace

std::vector<Case> subject_cases() {
  return {
      {.name = "clinical/subjects/corridor",
       .suite = "clinical",
       .claim =
           "The corridor of a few subjects holds a further one as often as it says; of one there is none.",
       .measure = measure_corridor,
       .weight = 0.2},
      {.name = "clinical/subjects/bootstrap",
       .suite = "clinical",
       .claim = "Bootstrap intervals over subjects are as narrow as is known of them, and are said to be.",
       .measure = measure_bootstrap,
       .weight = 0.2}};
}

}  // namespace palpate::clinical
