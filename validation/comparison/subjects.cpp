// SPDX-License-Identifier: MIT
#include "validation/comparison/subjects.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "validation/comparison/statistics.hpp"

namespace palpate::comparison {

std::vector<std::size_t> subject_indices(std::span<const std::string> codes) {
  std::vector<std::size_t> subject;
  std::map<std::string, std::size_t> known;
  std::size_t count = 0;
  for (const std::string& code : codes) {
    if (code.empty()) {
      subject.push_back(count++);
    } else {
      const auto [place, is_new] = known.try_emplace(code, count);
      count += is_new ? 1 : 0;
      subject.push_back(place->second);
    }
  }
  return subject;
}

std::size_t subject_count(std::span<const std::size_t> subject) {
  return subject.empty() ? 0 : std::ranges::max(subject) + 1;
}

OverSubjects over_subjects(std::span<const double> value, std::span<const std::size_t> subject) {
  std::map<std::size_t, std::vector<double>> by_subject;
  for (std::size_t n = 0; n < value.size(); ++n) {
    if (std::isfinite(value[n])) { by_subject[subject.empty() ? n : subject[n]].push_back(value[n]); }
  }
  OverSubjects over;
  double square = 0.0;
  double repeats = 0.0;       // sum of n_i - 1
  double inverse_count = 0.0;  // <1/n_i>
  for (const auto& [index, own] : by_subject) {
    const double mean = over.means.emplace_back(mean_of(own));
    for (const double v : own) { square += (v - mean) * (v - mean); }
    over.recordings += own.size();
    repeats += static_cast<double>(own.size() - 1);
    inverse_count += 1.0 / static_cast<double>(own.size() * by_subject.size());
  }
  if (over.means.empty()) { return over; }
  over.mean = mean_of(over.means);
  over.deviation = deviation_of(over.means);
  const double within = repeats > 0.0 ? square / repeats : 0.0;
  over.of_recording = std::sqrt(over.deviation * over.deviation + within * (1.0 - inverse_count));
  return over;
}

}  // namespace palpate::comparison
