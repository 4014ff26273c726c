// SPDX-License-Identifier: MIT
#include <algorithm>

#include "reports/calibration_report.hpp"
#include "reports/markup.hpp"

namespace palpate {
namespace {

using namespace calibration;

std::string joined_keys(const Fit& fit, Telling telling) {
  std::string text;
  for (const FittedParameter& each : fit.parameters) {
    if (each.telling == telling) { text += (text.empty() ? "" : ", ") + each.parameter.key; }
  }
  return text;
}

std::size_t with_force(const CalibrationReport& report, ForceSource source) {
  return static_cast<std::size_t>(std::ranges::count_if(
      report.recordings, [&](const CalibratedRecording& r) { return r.subject.seen.force == source; }));
}

}  // namespace

bool CalibrationReport::reconstructed() const {
  return std::ranges::any_of(
      recordings, [](const CalibratedRecording& r) { return r.kind == Recording::Kind::reconstructed; });
}

std::string calibration_verdict(const CalibrationReport& report) {
  const Fit& fit = report.result.fit;
  const std::string told = std::to_string(fit.told.size()) + " of " + std::to_string(fit.parameters.size());
  if (fit.told.empty()) {
    return "Nothing fitted: the recordings tell none of " + std::to_string(fit.parameters.size()) +
           " parameters";
  }
  if (report.result.held()) { return "Fitted: the recordings tell " + told + " parameters"; }
  return "Fell short: " + told + " parameters were fitted, and not every check of the fit holds";
}

std::string calibration_detail(const CalibrationReport& report) {
  const Fit& fit = report.result.fit;
  std::string text = "Sum of squares over " + std::to_string(fit.rows.size()) +
                     " observables: " + short_number(fit.misfit_before, 3) + " before, " +
                     short_number(fit.misfit_after, 3) + " after. From " +
                     std::to_string(report.recordings.size()) +
                     (report.recordings.size() == 1 ? " recording" : " recordings");
  text += report.reconstructed()
              ? ", reconstructed from published summary values: no evidence about patients."
              : ".";
  return text;
}

std::vector<std::string> calibration_warnings(const CalibrationReport& report) {
  const Fit& fit = report.result.fit;
  std::vector<std::string> notes;
  if (report.reconstructed()) {
    notes.emplace_back(
        "Recordings that were rebuilt from published summary values give back what was put into them: "
        "peaks, plateaus and depths are published, the lines between them and the spread of subjects "
        "are assumed. Forces within a layer follow from such lines.");
  }
  if (!fit.converged) {
    notes.emplace_back("The search did not converge: values are the best that were tried.");
  }
  for (const FittedParameter& each : fit.parameters) {
    if (each.at_bound) {
      notes.push_back(each.parameter.key + " lies at its bound: nothing is known beyond it.");
    }
  }
  if (fit.widening > 1.0) {
    notes.push_back(
        "The misfit is more than chance: the model cannot follow these recordings. Intervals are "
        "widened by " +
        short_number(fit.widening, 3) + ".");
  }
  if (const std::size_t count = with_force(report, ForceSource::plunger); count > 0) {
    notes.push_back(
        "In " + std::to_string(count) +
        " continuous recordings pressure times plunger area stands for the "
        "force along the needle (Eq. 1): true as far as the thumb on the plunger is what drives it.");
  }
  const std::size_t forces =
      with_force(report, ForceSource::plunger) + with_force(report, ForceSource::recorded);
  if (forces == 0) { notes.emplace_back("No force was seen, so nothing tells cutting force and friction."); }
  if (report.recordings.size() < least_subjects) {
    notes.emplace_back("Fewer than three recordings: intervals hold for these subjects alone.");
  } else {
    notes.emplace_back(
        "Every recording counts as a subject of its own: several of one woman make intervals too narrow.");
  }
  if (report.result.shortcut_cost() >= 1.0) {
    notes.push_back("The coarser block that was fitted differs from the scene by " +
                    short_number(report.result.shortcut_cost(), 3) + " uncertainties: too coarse.");
  }
  for (const auto& [telling, words] :
       {std::pair{Telling::insensitive, "Left at their prior, as nothing that was seen depends on them: "},
        {Telling::wide, "Left at their prior, as other parameters do the same to all that was seen: "}}) {
    const std::string keys = joined_keys(fit, telling);
    if (!keys.empty()) { notes.push_back(words + keys + "."); }
  }
  return notes;
}

}  // namespace palpate
