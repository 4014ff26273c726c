// SPDX-License-Identifier: MIT
#include "reports/cli/calibrate_inputs.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "fixtures/io/content_hash.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/problems.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/recording_input.hpp"

namespace palpate::cli {
namespace {

using calibration::Parameter;

constexpr std::size_t most_bytes = std::size_t{1} << 30U;

CalibratedRecording read_one(const std::filesystem::path& path) {
  const Recording recording = read_any_recording(path).recording;
  if (recording.regime == Recording::Regime::pump) {
    throw InputError(path.string() +
                     ": a pump injected; a thumb on the plunger is what the scene's syringe is under");
  }
  calibration::ObservedInsertion seen = calibration::observe(recording);
  if (!seen.refusal.empty()) {
    throw InputError(path.string() + ": " + seen.refusal + "; an insertion with one is needed");
  }
  return {.file = path.filename().string(),
          .hash = io::content_hash(io::read_bytes(path, most_bytes)),
          .source = recording.source,
          .technique = recording.technique,
          .kind = recording.kind,
          .subject = {.name = recording.name.empty() ? path.stem().string() : recording.name,
                      .person = recording.subject,
                      .group = recording.group,
                      .body_mass_index = recording.body_mass_index,
                      .seen = std::move(seen),
                      .plunger_area = recording.plunger_area}};
}

/// "KEY=A:B" of an option.
struct Pair {
  std::string key{};
  double first = 0.0;
  double second = 0.0;
};

double positive_number(const std::string& text, const std::string& option) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !(value > 0.0) || !std::isfinite(value)) {
    throw InputError(option + ": " + (text.empty() ? "no number" : text) + "; must be a number > 0");
  }
  return value;
}

Pair parse_pair(const std::string& name, const std::string& text, const char* form) {
  const std::string option = name + " " + text;
  const std::size_t equals = text.find('=');
  const std::size_t colon = text.find(':', equals == text.npos ? 0 : equals);
  if (equals == text.npos || colon == text.npos) { throw InputError(option + ": not understood; " + form); }
  return {text.substr(0, equals), positive_number(text.substr(equals + 1, colon - equals - 1), option),
          positive_number(text.substr(colon + 1), option)};
}

Parameter& find(std::vector<Parameter>& parameters, const std::string& key, const std::string& option) {
  const auto found = std::ranges::find(parameters, key, &Parameter::key);
  if (found != parameters.end()) { return *found; }
  std::vector<std::string_view> keys;
  std::string all;
  for (const Parameter& each : parameters) {
    keys.push_back(each.key);
    all += (all.empty() ? "" : ", ") + each.key;
  }
  const std::string_view near = io::nearest_word(key, keys);
  throw InputError(option + ": " + key + " is no parameter" +
                   (near.empty() ? "" : "; did you mean " + std::string(near) + "?") + "; one of " + all);
}

void refuse_outside(const Parameter& p) {
  if (p.prior > p.lower && p.prior < p.upper) { return; }
  throw InputError("--bounds " + p.key + ": the prior " + std::to_string(p.prior) + " " + p.unit +
                   " lies outside; bounds must hold it between them");
}

}  // namespace

std::vector<CalibratedRecording> read_calibrated(const std::vector<std::filesystem::path>& paths) {
  std::vector<CalibratedRecording> recordings;
  std::string problems;
  for (const std::filesystem::path& path : paths) {
    try {
      CalibratedRecording read = read_one(path);
      const auto twin = std::ranges::find(recordings, read.hash, &CalibratedRecording::hash);
      if (twin != recordings.end()) {
        throw InputError(path.string() + ": the same bytes as " + twin->file + "; every recording once");
      }
      recordings.push_back(std::move(read));
    } catch (const InputError& problem) {
      problems += (problems.empty() ? "" : "\n") + std::string(problem.what());
    }
  }
  if (!problems.empty()) { throw InputError(problems); }
  return recordings;
}

std::vector<Parameter> chosen_parameters(const CalibrateOptions& options, const Scene& scene) {
  std::vector<Parameter> all = calibration::parameters_of(scene);
  for (const std::string& text : options.priors) {
    const Pair pair = parse_pair("--prior", text, "KEY=VALUE:SPREAD, spread being the SD of the logarithm");
    Parameter& p = find(all, pair.key, "--prior " + text);
    p.prior = pair.first;
    p.spread = pair.second;
    p.origin = "--prior";
    calibration::set_default_bounds(p);
    if (!(p.lower > 0.0) || !std::isfinite(p.upper)) {
      throw InputError("--prior " + text + ": four spreads leave what numbers can hold; a smaller spread");
    }
  }
  for (const std::string& text : options.bounds) {
    const Pair pair = parse_pair("--bounds", text, "KEY=LOWER:UPPER");
    Parameter& p = find(all, pair.key, "--bounds " + text);
    p.lower = pair.first;
    p.upper = pair.second;
    refuse_outside(p);
  }
  if (options.parameters.empty()) { return all; }
  std::vector<Parameter> chosen;
  for (const std::string& key : options.parameters) {
    const Parameter& p = find(all, key, "--parameter");
    if (std::ranges::find(chosen, key, &Parameter::key) == chosen.end()) { chosen.push_back(p); }
  }
  return chosen;
}

}  // namespace palpate::cli
