// SPDX-License-Identifier: MIT
#include "validation/calibration/pooled.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "tests/check.hpp"

using namespace palpate::calibration;

namespace {

constexpr SharedUncertainty nothing{.zero = 0.0,
                                    .gain = 0.0,
                                    .plunger_friction = 0.0,
                                    .force_gain = 0.0,
                                    .depth = 0.0,
                                    .drop_time = 0.0,
                                    .model = 0.0};

Subject subject(double pressure, double force) {
  Subject made{
      .seen = {.value = Observation::Constant(observable_count, force), .force = ForceSource::plunger}};
  made.seen.value[0] = pressure;
  return made;
}

TEST("the spread of a mean is the standard error") {
  const std::vector<Subject> subjects{subject(1.0, 5.0), subject(2.0, 6.0), subject(6.0, 7.0)};
  const Pooled pooled = pool(subjects, nothing);
  CHECK_NEAR(pooled.mean[0], 3.0, 1e-15);
  CHECK_NEAR(pooled.covariance(0, 0), 7.0 / 3.0, 1e-14);  // variance 7 of three
  CHECK_NEAR(pooled.covariance(0, 4), 2.5 / 3.0, 1e-14);  // covariance 2.5 of three
  CHECK(pooled.degrees_of_freedom() == 2);
}

TEST("several recordings of one person count as their mean, and only within a group") {
  std::vector<Subject> recordings{subject(1.0, 5.0), subject(4.0, 6.0), subject(3.0, 7.0), subject(9.0, 8.0)};
  recordings[0].person = recordings[2].person = recordings[3].person = "A";
  recordings[3].group = "another";
  recordings[2].seen.value[3] = std::nan("");
  recordings[2].seen.force = ForceSource::none;
  const std::vector<Subject> people = by_person(recordings);
  CHECK(people.size() == 3);
  CHECK_NEAR(people[0].seen.value[0], 2.0, 0.0);
  CHECK_NEAR(people[0].seen.value[3], 5.0, 0.0);  // of the only one that has it
  CHECK(people[0].seen.force == ForceSource::plunger);
  CHECK_NEAR(people[1].seen.value[0], 4.0, 0.0);
  CHECK_NEAR(people[2].seen.value[0], 9.0, 0.0);
  const std::vector<Subject> nameless{subject(1.0, 5.0), subject(1.0, 5.0)};
  CHECK(by_person(nameless).size() == 2);
}

TEST("two recordings give no spread, and what a transducer adds is shared by all that it touches") {
  const std::vector<Subject> subjects{subject(50e3, 8.0), subject(60e3, 10.0)};
  SharedUncertainty only_zero = nothing;
  only_zero.zero = 57.0;
  const Pooled pooled = pool(subjects, only_zero);
  CHECK(pooled.degrees_of_freedom() == 0);
  CHECK_NEAR(pooled.covariance(0, 0), 57.0 * 57.0, 1e-9);
  const double area = subjects[0].plunger_area;
  CHECK_NEAR(pooled.covariance(0, 5), 57.0 * 57.0 * area, 1e-12);  // fully correlated
}

TEST("what few have seen is left out, and no eigenvalue is negative") {
  std::vector<Subject> subjects{subject(1.0, 5.0), subject(2.0, 7.0), subject(6.0, 6.0), subject(4.0, 6.5)};
  subjects[0].seen.value[2] = subjects[1].seen.value[2] = std::nan("");
  subjects[3].seen.value[5] = std::nan("");
  const Pooled pooled = pool(subjects, nothing);
  CHECK(std::isnan(pooled.mean[2]) && pooled.count[2] == 2 && pooled.covariance(2, 2) == 0.0);
  CHECK_NEAR(pooled.mean[5], 6.0, 1e-15);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(pooled.covariance, Eigen::EigenvaluesOnly);
  CHECK(solver.eigenvalues().minCoeff() > -1e-12);
}

TEST("depths are moved to the mean body mass by the published slope") {
  std::vector<Subject> subjects{subject(1.0, 5.0), subject(2.0, 5.0), subject(6.0, 5.0)};
  for (std::size_t n = 0; n < 3; ++n) {
    subjects[n].body_mass_index = 20.0 + 10.0 * static_cast<double>(n);
    subjects[n].seen.value[3] = 0.04 + depth_per_body_mass_index * (*subjects[n].body_mass_index - 20.0);
  }
  const Pooled pooled = pool(subjects, nothing);
  CHECK_NEAR(pooled.mean[3], 0.04 + 10.0 * depth_per_body_mass_index, 1e-15);
  CHECK_NEAR(pooled.covariance(3, 3), 0.0, 1e-18);  // rounding: nothing but body mass differs
}

}  // namespace
