// SPDX-License-Identifier: MIT

#include "validation/calibration/observation.hpp"

#include <algorithm>
#include <cmath>

#include "validation/comparison/features.hpp"
#include "validation/signal.hpp"

namespace palpate::calibration {
namespace {

using namespace comparison;

/// Minimum share of a depth interval that must be covered [1].
constexpr double least_seen = 0.8;
/// Initial travel of the tip that is ignored, because the thumb does not yet press fully and the
/// plunger force is not that of the needle [m].
constexpr double first_advance = 0.25e-3;

/// Work of the force over a depth interval, and its length.
struct Way {
  double work = 0.0;    ///< integral of the force over the depth [J]
  double length = 0.0;  ///< [m]
};

/// Trapezoidal rule over the depth; samples without advance have no weight, so the speed of the
/// hand has no effect.
Way way_through(const Samples& force, const Samples& depth, double begin, double end,
                std::size_t last) {
  Way way;
  for (std::size_t n = 1; n <= last && n < force.size(); ++n) {
    const double from = depth.value[n - 1];
    const double to = depth.value[n];
    const double middle = 0.5 * (from + to);
    if (!(to > from) || middle < begin || middle >= end) { continue; }
    const double mean = 0.5 * (force.value[n - 1] + force.value[n]);
    if (!std::isfinite(mean)) { continue; }
    way.work += mean * (to - from);
    way.length += to - from;
  }
  return way;
}

double first_number(const std::vector<double>& values) {
  const auto found = std::ranges::find_if(values, [](double v) { return std::isfinite(v); });
  return found == values.end() ? not_measured : *found;
}

void add_bins(const Samples& force, const Samples& depth, double depth_of_loss, std::size_t last,
              Observation& value) {
  const double pressed_from = first_number(depth.value) + first_advance;
  Eigen::Index index = index_of(Observable::force);
  for (const ForceBin& bin : force_bins) {
    const double begin = depth_of_loss + bin.begin;
    const double end = depth_of_loss + bin.end;
    const Way way = way_through(force, depth, std::fmax(begin, pressed_from), end, last);
    if (way.length >= least_seen * (end - begin)) { value[index] = way.work / way.length; }
    ++index;
  }
}

void add_force(const RawTrace& trace, std::span<const double> forces, const PreparedTrace& prepared,
               double cutoff, Observation& value) {
  const Features& found = prepared.features;
  const auto& time_of_loss = found[Feature::time_of_loss].value;
  if (forces.empty() || !time_of_loss) { return; }
  const Samples force = zero_phase(regular(trace.time, forces), cutoff);
  const std::size_t last = force.index_at(*time_of_loss);
  const std::vector<double> before = finite_only(std::span(force.value).first(last + 1));
  value[index_of(Observable::force_peak)] = before.empty() ? -1e300 : std::ranges::max(before);
  const auto& depth_of_loss = found[Feature::depth_of_loss].value;
  if (depth_of_loss && prepared.input.depth.size() == force.size()) {
    add_bins(force, prepared.input.depth, *depth_of_loss, last, value);
  }
}

/// The drop of the force is at the loss of resistance of the pressure: both drop when the tip
/// enters the epidural space.
ObservedInsertion observe_trace(const RawTrace& trace, std::span<const double> force,
                                double cutoff) {
  ObservedInsertion seen{.value = Observation::Constant(observable_count, not_measured)};
  const double rate = 1.0 / usual_interval(trace.time);
  const double used = std::fmin(cutoff, 0.25 * rate);
  const PreparedTrace prepared = prepare(trace, used, {});
  if (!prepared.refusal.empty()) {
    seen.refusal = prepared.refusal;
    return seen;
  }
  if (!prepared.features.loss.fell()) {
    seen.refusal = "shows no loss of resistance: " + prepared.features.loss.reason;
    return seen;
  }
  for (const auto& [observable, feature] : {std::pair{Observable::pressure_peak, Feature::peak},
                                            {Observable::plateau, Feature::plateau},
                                            {Observable::drop_time, Feature::drop_time},
                                            {Observable::depth_of_loss, Feature::depth_of_loss}}) {
    seen.value[index_of(observable)] = prepared.features[feature].value.value_or(not_measured);
  }
  add_force(trace, force, prepared, used, seen.value);
  return seen;
}

/// Name and unit of every observable.
constexpr std::array<std::pair<std::string_view, std::string_view>, 10> naming{
    {{"pressure.peak", "Pa"},
     {"pressure.plateau", "Pa"},
     {"pressure.drop_time", "s"},
     {"depth_of_loss", "m"},
     {"force.peak", "N"},
     {"force.-10_to_-8_mm", "N"},
     {"force.-8_to_-6_mm", "N"},
     {"force.-6_to_-4_mm", "N"},
     {"force.-4_to_-2_mm", "N"},
     {"force.-2_to_-0.5_mm", "N"}}};
static_assert(naming.size() == observable_count);

}  // namespace

std::string_view name_of(Eigen::Index observable) {
  return naming[static_cast<std::size_t>(observable)].first;
}
std::string_view unit_of(Eigen::Index observable) {
  return naming[static_cast<std::size_t>(observable)].second;
}

std::string_view name_of(ForceSource source) {
  constexpr std::array<std::string_view, 3> names{"none", "recorded", "plunger"};
  return names[static_cast<std::size_t>(source)];
}

ForceSource force_source(const Recording& recording) {
  if (recording.force.size() == recording.time.size() && !recording.force.empty()) {
    return ForceSource::recorded;
  }
  const bool driven =
      recording.technique == "continuous" && recording.regime == Recording::Regime::thumb;
  return driven ? ForceSource::plunger : ForceSource::none;
}

ObservedInsertion observe(const Recording& recording, double cutoff) {
  const ForceSource source = force_source(recording);
  std::vector<double> force;
  if (source == ForceSource::recorded) { force = recording.force; }
  if (source == ForceSource::plunger) {
    force = recording.pressure;
    for (double& f : force) { f *= recording.plunger_area; }
  }
  ObservedInsertion seen =
      observe_trace({recording.time, recording.pressure, recording.depth}, force, cutoff);
  seen.force = source;
  return seen;
}

ObservedInsertion observe(const Trace& trace, double cutoff) {
  const Column* pressure = trace.find("syringe.pressure_pa");
  const Column* depth = trace.find("tool.depth_m");
  const Column* force = trace.find("tool.force_n");
  if (pressure == nullptr || depth == nullptr || force == nullptr) {
    return {.value = Observation::Constant(observable_count, not_measured),
            .refusal = "has no syringe or no tool"};
  }
  ObservedInsertion seen =
      observe_trace({trace.time, pressure->values, depth->values}, force->values, cutoff);
  seen.force = ForceSource::recorded;
  return seen;
}

namespace {

std::optional<double> mean_body_mass_index(std::span<const ObservedRecording> subjects) {
  double sum = 0.0;
  for (const ObservedRecording& subject : subjects) {
    if (!subject.recording.body_mass_index) { return std::nullopt; }
    sum += *subject.recording.body_mass_index;
  }
  return subjects.empty() ? std::nullopt
                          : std::optional(sum / static_cast<double>(subjects.size()));
}

/// One row per subject.
Eigen::MatrixXd table_of(std::span<const ObservedRecording> subjects,
                         const std::optional<double>& body_mass_index) {
  Eigen::MatrixXd table(static_cast<Eigen::Index>(subjects.size()), observable_count);
  for (std::size_t n = 0; n < subjects.size(); ++n) {
    auto row = table.row(static_cast<Eigen::Index>(n));
    row = subjects[n].seen.value.transpose();
    if (body_mass_index) {
      row[index_of(Observable::depth_of_loss)] +=
          depth_per_body_mass_index * (*body_mass_index - *subjects[n].recording.body_mass_index);
    }
  }
  return table;
}

/// Returns the covariance of means from deviations scaled by the count of each column; missing
/// values deviate by zero, so the matrix has no negative eigenvalue.
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

/// Returns the covariance of common errors: each source changes all affected observables together.
Eigen::MatrixXd shared_covariance(const Eigen::VectorXd& mean, bool plunger, double area,
                                  const SharedUncertainty& u) {
  Eigen::MatrixXd sources =
      Eigen::MatrixXd::Zero(observable_count, 4);  // zero, gain, friction, force gain
  Eigen::VectorXd own = Eigen::VectorXd::Zero(observable_count);
  for (Eigen::Index c = 0; c < observable_count; ++c) {
    if (unit_of(c) == "Pa") {
      sources(c, 0) = u.transducer.zero;
      sources(c, 1) = u.transducer.gain * mean[c];
    } else if (unit_of(c) == "N") {
      sources(c, 0) = plunger ? u.transducer.zero * area : 0.0;
      sources(c, 1) = plunger ? u.transducer.gain * mean[c] : 0.0;
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
  for (const Eigen::Index c : present()) {
    fewest = std::min(fewest, count[static_cast<std::size_t>(c)]);
  }
  return fewest - 1;
}

std::vector<ObservedRecording> by_subject(std::span<const ObservedRecording> recordings) {
  std::vector<std::string> codes;
  for (const auto& [recording, seen] : recordings) {
    codes.push_back(recording.subject.empty() ? "" : recording.group + '\n' + recording.subject);
  }
  const std::vector<std::size_t> subject = subject_indices(codes);
  std::vector<ObservedRecording> subjects(subject_count(subject));
  std::vector<Eigen::VectorXi> counts(subjects.size());
  for (std::size_t n = 0; n < recordings.size(); ++n) {
    ObservedRecording& own = subjects[subject[n]];
    Eigen::VectorXi& count = counts[subject[n]];
    const ObservedInsertion& seen = recordings[n].seen;
    if (count.size() == 0) {
      own = recordings[n];
      own.seen.value.setZero();
      count = Eigen::VectorXi::Zero(observable_count);
    }
    for (Eigen::Index c = 0; c < observable_count; ++c) {
      if (std::isfinite(seen.value[c])) { own.seen.value[c] += seen.value[c], ++count[c]; }
    }
    if (seen.force != ForceSource::none) { own.seen.force = seen.force; }
  }
  for (std::size_t n = 0; n < subjects.size(); ++n) {
    subjects[n].seen.value.array() /= counts[n].cast<double>().array();  // NaN without a number
  }
  return subjects;
}

Pooled pool(std::span<const ObservedRecording> subjects, const SharedUncertainty& shared) {
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
  const bool plunger = std::ranges::any_of(
      subjects, [](const ObservedRecording& s) { return s.seen.force == ForceSource::plunger; });
  const double area = subjects.empty() ? 0.0 : subjects.front().recording.plunger_area;
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
