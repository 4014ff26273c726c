// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <utility>

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

void add_notes_on_force(const CalibrationReport& report, std::vector<std::string>& notes) {
  const std::size_t plunger = with_force(report, ForceSource::plunger);
  if (plunger > 0) {
    notes.push_back("In " + std::to_string(plunger) + " continuous recording" + (plunger == 1 ? "" : "s") +
                    " pressure times plunger area stands for the force along the needle (Eq. 1): true as far "
                    "as the thumb on the plunger is what drives it.");
  }
  if (plunger + with_force(report, ForceSource::recorded) == 0) {
    notes.emplace_back("No force was seen, so nothing tells cutting force and friction.");
  }
}

/// A thumb's force over another area is another pressure.
void add_note_on_plungers(const CalibrationReport& report, std::vector<std::string>& notes) {
  constexpr double same = 0.01;  // [1] of the area: as well as a pressure's gain is known
  const auto& syringe = report.result.fitted.syringe;
  if (!syringe) { return; }
  const auto others = std::ranges::count_if(report.recordings, [&](const CalibratedRecording& each) {
    return std::abs(each.subject.plunger_area / syringe->plunger_area - 1.0) > same;
  });
  if (others == 0) { return; }
  notes.push_back(std::to_string(others) +
                  (others == 1 ? " recording is" : " recordings are") +
                  " of a plunger of another area than the scene's " +
                  short_number(syringe->plunger_area, 4) +
                  " m^2: the thumb's force is then that of the scene's plunger and of nobody's thumb.");
}

/// pool() moves depths where all have a BMI, so one without it stops that for all.
void add_note_on_body_mass(const CalibrationReport& report, std::vector<std::string>& notes) {
  const auto without = std::ranges::count_if(
      report.recordings, [](const CalibratedRecording& each) { return !each.subject.body_mass_index; });
  if (without == 0 || std::cmp_equal(without, report.recordings.size())) { return; }
  notes.push_back(std::to_string(without) + " of " + std::to_string(report.recordings.size()) +
                  " recordings have no BMI: no depth was moved to a common one.");
}

void add_notes_on_recordings(const CalibrationReport& report, std::vector<std::string>& notes) {
  if (report.reconstructed()) {
    notes.emplace_back(
        "Recordings that were rebuilt from published summary values give back what was put into them: "
        "peaks, plateaus and depths are published, the lines between them and the spread of subjects "
        "are assumed. Forces within a layer follow from such lines.");
  }
  add_notes_on_force(report, notes);
  add_note_on_plungers(report, notes);
  add_note_on_body_mass(report, notes);
  if (report.result.fit.data.subjects < least_subjects) {
    notes.emplace_back("Fewer than three subjects: intervals hold for these alone.");
  }
  if (std::ranges::any_of(report.recordings, [](const auto& each) { return each.subject.person.empty(); })) {
    notes.emplace_back(
        "A recording that names no subject counts as one of its own: several of one person make intervals too "
        "narrow.");
  }
}

void add_notes_on_fit(const Calibration& result, std::vector<std::string>& notes) {
  if (!result.fit.converged) {
    notes.emplace_back("The search did not converge: values are the best that were tried.");
  }
  for (const HeldOut& each : result.held_out) {
    if (each.converged) { continue; }
    notes.push_back("Without " + (each.group.empty() ? "recordings of no group" : each.group) +
                    " the search did not converge: what is foretold of them is the best that was tried.");
  }
  for (const FittedParameter& each : result.fit.parameters) {
    if (each.at_bound) {
      notes.push_back(each.parameter.key + " lies at its bound: nothing is known beyond it.");
    }
  }
  if (result.fit.widening > 1.0) {
    notes.push_back(
        "The misfit is more than chance: the model cannot follow these recordings. Intervals are "
        "widened by " +
        short_number(result.fit.widening, 3) + ".");
  }
  if (!(result.shortcut_cost() < 1.0)) {
    notes.push_back("The coarser block that was fitted differs from the scene by " +
                    short_number(result.shortcut_cost(), 3) + " uncertainties: too coarse.");
  }
}

void add_notes_on_what_is_left(const Fit& fit, std::vector<std::string>& notes) {
  for (const auto& [telling, words] :
       {std::pair{Telling::insensitive,
                  "Left at their prior, as one spread of it moves what was seen by less than that is "
                  "uncertain: "},
        {Telling::wide, "Left at their prior, as other parameters do the same to all that was seen: "}}) {
    const std::string keys = joined_keys(fit, telling);
    if (!keys.empty()) { notes.push_back(words + keys + "."); }
  }
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
  std::vector<std::string> notes;
  add_notes_on_recordings(report, notes);
  add_notes_on_fit(report.result, notes);
  add_notes_on_what_is_left(report.result.fit, notes);
  return notes;
}

}  // namespace palpate
