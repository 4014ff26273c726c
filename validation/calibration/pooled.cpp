// SPDX-License-Identifier: MIT
#include "validation/calibration/pooled.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::calibration {
namespace {

std::optional<double> mean_body_mass_index(std::span<const Subject> subjects) {
  double sum = 0.0;
  for (const Subject& subject : subjects) {
    if (!subject.body_mass_index) { return std::nullopt; }
    sum += *subject.body_mass_index;
  }
  return subjects.empty() ? std::nullopt : std::optional(sum / static_cast<double>(subjects.size()));
}

/// Over those that have a number.
Observation mean_of(const std::vector<const Subject*>& recordings) {
  Observation mean = Observation::Constant(observable_count, std::nan(""));
  for (Eigen::Index c = 0; c < observable_count; ++c) {
    double sum = 0.0;
    int count = 0;
    for (const Subject* each : recordings) {
      if (std::isfinite(each->seen.value[c])) { sum += each->seen.value[c], ++count; }
    }
    if (count > 0) { mean[c] = sum / count; }
  }
  return mean;
}

/// One row per subject.
Eigen::MatrixXd table_of(std::span<const Subject> subjects, const std::optional<double>& body_mass_index) {
  Eigen::MatrixXd table(static_cast<Eigen::Index>(subjects.size()), observable_count);
  for (std::size_t n = 0; n < subjects.size(); ++n) {
    auto row = table.row(static_cast<Eigen::Index>(n));
    row = subjects[n].seen.value.transpose();
    if (body_mass_index) {
      row[index_of(Observable::depth_of_loss)] +=
          depth_per_body_mass_index * (*body_mass_index - *subjects[n].body_mass_index);
    }
  }
  return table;
}

/// Of means: deviations of each column over its own count; what is missing deviates by nothing, so the
/// matrix has no negative eigenvalue.
Eigen::MatrixXd spread_of_means(const Eigen::MatrixXd& table, const Pooled& pooled) {
  Eigen::MatrixXd deviation = Eigen::MatrixXd::Zero(table.rows(), table.cols());
  for (Eigen::Index c = 0; c < table.cols(); ++c) {
    const auto count = static_cast<double>(pooled.count[static_cast<std::size_t>(c)]);
    if (count < 2.0) { continue; }
    const double factor = std::sqrt(count / (count - 1.0)) / count;
    for (Eigen::Index r = 0; r < table.rows(); ++r) {
      if (std::isfinite(table(r, c))) { deviation(r, c) = factor * (table(r, c) - pooled.mean[c]); }
    }
  }
  return deviation.transpose() * deviation;
}

/// Each source of error moves all that it touches at once.
Eigen::MatrixXd shared_covariance(const Eigen::VectorXd& mean, bool plunger, double area,
                                  const SharedUncertainty& u) {
  Eigen::MatrixXd sources = Eigen::MatrixXd::Zero(observable_count, 4);  // zero, gain, friction, force gain
  Eigen::VectorXd own = Eigen::VectorXd::Zero(observable_count);
  for (Eigen::Index c = 0; c < observable_count; ++c) {
    if (is_pressure(c)) {
      sources(c, 0) = u.zero;
      sources(c, 1) = u.gain * mean[c];
    } else if (is_force(c)) {
      sources(c, 0) = plunger ? u.zero * area : 0.0;
      sources(c, 1) = plunger ? u.gain * mean[c] : 0.0;
      sources(c, 2) = plunger ? u.plunger_friction : 0.0;
      sources(c, 3) = plunger ? 0.0 : u.force_gain * mean[c];
      own[c] = u.model * mean[c];
    }
  }
  own[index_of(Observable::drop_time)] = u.drop_time;
  own[index_of(Observable::depth_of_loss)] = u.depth;
  Eigen::MatrixXd covariance = sources * sources.transpose();
  covariance.diagonal() += own.cwiseAbs2();
  return covariance;
}

void clear_absent(Eigen::MatrixXd& covariance, const Eigen::VectorXd& mean) {
  for (Eigen::Index c = 0; c < observable_count; ++c) {
    if (std::isfinite(mean[c])) { continue; }
    covariance.row(c).setZero();
    covariance.col(c).setZero();
  }
}

}  // namespace

std::vector<Eigen::Index> Pooled::present() const {
  std::vector<Eigen::Index> found;
  for (Eigen::Index c = 0; c < mean.size(); ++c) {
    if (std::isfinite(mean[c])) { found.push_back(c); }
  }
  return found;
}

std::size_t Pooled::degrees_of_freedom() const {
  if (subjects < least_subjects) { return 0; }
  std::size_t fewest = subjects;
  for (const Eigen::Index c : present()) { fewest = std::min(fewest, count[static_cast<std::size_t>(c)]); }
  return fewest - 1;
}

std::vector<Subject> by_person(std::span<const Subject> recordings) {
  std::vector<Subject> people;
  std::vector<std::vector<const Subject*>> theirs;
  for (const Subject& recording : recordings) {
    const auto same = std::ranges::find_if(people, [&](const Subject& person) {
      return !person.person.empty() && person.person == recording.person && person.group == recording.group;
    });
    if (same == people.end()) {
      people.push_back(recording);
      theirs.push_back({&recording});
      continue;
    }
    theirs[static_cast<std::size_t>(same - people.begin())].push_back(&recording);
    if (recording.seen.force != ForceSource::none) { same->seen.force = recording.seen.force; }
  }
  for (std::size_t n = 0; n < people.size(); ++n) {
    if (theirs[n].size() > 1) { people[n].seen.value = mean_of(theirs[n]); }
  }
  return people;
}

Pooled pool(std::span<const Subject> subjects, const SharedUncertainty& shared) {
  Pooled pooled{.mean = Eigen::VectorXd::Constant(observable_count, std::nan("")),
                .count = std::vector<std::size_t>(static_cast<std::size_t>(observable_count), 0),
                .subjects = subjects.size(),
                .body_mass_index = mean_body_mass_index(subjects)};
  const Eigen::MatrixXd table = table_of(subjects, pooled.body_mass_index);
  const std::size_t least = subjects.size() < least_subjects ? 1 : least_subjects;
  for (Eigen::Index c = 0; c < observable_count; ++c) {
    double sum = 0.0;
    std::size_t& count = pooled.count[static_cast<std::size_t>(c)];
    for (Eigen::Index r = 0; r < table.rows(); ++r) {
      if (std::isfinite(table(r, c))) { sum += table(r, c), ++count; }
    }
    if (count >= least) { pooled.mean[c] = sum / static_cast<double>(count); }
  }
  const bool plunger =
      std::ranges::any_of(subjects, [](const Subject& s) { return s.seen.force == ForceSource::plunger; });
  const double area = subjects.empty() ? 0.0 : subjects.front().plunger_area;
  pooled.covariance = shared_covariance(pooled.mean, plunger, area, shared);
  clear_absent(pooled.covariance, pooled.mean);
  if (subjects.size() >= least_subjects) {
    pooled.sampled = spread_of_means(table, pooled);
    clear_absent(pooled.sampled, pooled.mean);
    pooled.covariance += pooled.sampled;
  }
  return pooled;
}

}  // namespace palpate::calibration
