// SPDX-License-Identifier: MIT
/// The command `calibrate`.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <thread>
#include <unistd.h>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/problems.hpp"
#include "fixtures/io/scene_file.hpp"
#include "model/problem/input_error.hpp"
#include "model/tissue/network_builder.hpp"
#include "reports/calibration_report.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/recording_input.hpp"
#include "validation/roll_out.hpp"

namespace palpate::cli {
namespace {

struct CalibrateOptions : CommonOptions {
  std::vector<std::filesystem::path> recordings{};
  std::filesystem::path scene{};
  std::vector<std::string> parameters{};  ///< keys; empty: all
  std::vector<std::string> priors{};      ///< KEY=VALUE:SPREAD
  std::vector<std::string> bounds{};      ///< KEY=LOWER:UPPER
  SubjectChoice subject{};                ///< simulator that is calibrated
  int jobs = 0;                           ///< parallel simulations; 0: one per core
  std::vector<std::string> conditions{};  ///< SCENE [KEY=VALUE]... RECORDING..., see split()
  std::vector<std::string> predictions{};
  int starts = 1;
};

using calibration::Parameter;

/// Throws InputError for a recording that was made with a pump or has no loss of resistance.
CalibratedRecording observed(const RecordingFile& read) {
  const Recording& recording = read.input.recording;
  if (recording.regime == Recording::Regime::pump) {
    throw InputError(read.file.string() +
                     ": recorded with a pump; the syringe of a scene is pressed by a thumb");
  }
  calibration::ObservedInsertion seen = calibration::observe(recording);
  if (!seen.refusal.empty()) {
    throw InputError(read.file.string() + ": " + seen.refusal +
                     "; an insertion with one is needed");
  }
  return {.file = read.file.filename().string(),
          .hash = read.hash,
          .observed = {recording, std::move(seen)}};
}

/// The parts of an option value "KEY=A:B".
struct Pair {
  std::string key{};
  double first = 0.0;
  double second = 0.0;
};

double positive_number(const std::string& text, const std::string& option) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !(value > 0.0) ||
      !std::isfinite(value)) {
    throw InputError(option + ": " + (text.empty() ? "no number" : text) +
                     "; must be a number > 0");
  }
  return value;
}

Pair parse_pair(const std::string& name, const std::string& text, const char* form) {
  const std::string option = name + " " + text;
  const std::size_t equals = text.find('=');
  const std::size_t colon = text.find(':', equals == text.npos ? 0 : equals);
  if (equals == text.npos || colon == text.npos) {
    throw InputError(option + ": not understood; " + form);
  }
  return {text.substr(0, equals),
          positive_number(text.substr(equals + 1, colon - equals - 1), option),
          positive_number(text.substr(colon + 1), option)};
}

Parameter& find(std::vector<Parameter>& parameters, const std::string& key,
                const std::string& option) {
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
                   (near.empty() ? "" : "; did you mean " + std::string(near) + "?") + "; one of " +
                   all);
}

void refuse_outside(const Parameter& p) {
  if (p.prior > p.lower && p.prior < p.upper) { return; }
  throw InputError("--bounds " + p.key + ": the prior " + std::to_string(p.prior) + " " + p.unit +
                   " is outside; the prior must be between the bounds");
}

/// Parameters with the changes of --parameter, --prior KEY=VALUE:SPREAD and --bounds
/// KEY=LOWER:UPPER. Throws InputError.
std::vector<Parameter> chosen_parameters(const CalibrateOptions& options,
                                         std::vector<Parameter> all) {
  std::set<std::pair<std::string, std::string>> given;
  const auto check_key = [&](const std::string& option, const std::string& text) {
    const std::string key = text.substr(0, text.find('='));
    if (!given.emplace(option, key).second) {
      throw InputError(option + " " + text + ": " + key + " is given twice; each key once");
    }
    const auto& fitted = options.parameters;
    if (fitted.empty() || std::ranges::count(fitted, key) > 0) { return; }
    throw InputError(option + " " + text + ": " + key + " is not fitted; --parameter " + key +
                     " fits it, and --set " + key + "=VALUE gives it a value");
  };
  for (const std::string& text : options.priors) {
    const Pair pair =
        parse_pair("--prior", text, "KEY=VALUE:SPREAD, spread being the SD of the logarithm");
    Parameter& p = find(all, pair.key, "--prior " + text);
    check_key("--prior", text);
    p.prior = pair.first;
    p.spread = pair.second;
    p.origin = "--prior";
    calibration::set_default_bounds(p);
    if (!(p.lower > 0.0) || !std::isfinite(p.upper)) {
      throw InputError("--prior " + text +
                       ": four spreads leave what numbers can hold; a smaller spread");
    }
  }
  for (const std::string& text : options.bounds) {
    const Pair pair = parse_pair("--bounds", text, "KEY=LOWER:UPPER");
    Parameter& p = find(all, pair.key, "--bounds " + text);
    check_key("--bounds", text);
    p.lower = pair.first;
    p.upper = pair.second;
    if (!(p.lower < p.upper)) {
      throw InputError("--bounds " + text +
                       ": the lower bound is not below the upper; KEY=LOWER:UPPER");
    }
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

using namespace calibration;

void tell_stage(const char* stage) { std::fprintf(stderr, "palpate: %s\n", stage); }

/// The simulator, without the recordings that it is to reproduce.
SubjectChoice simulator_of(const CalibrateOptions& options) {
  if (options.subject.subject.starts_with("trace:")) {
    throw InputError("--subject " + options.subject.subject +
                     ": a trace cannot be simulated at other values; PATH.so or exec:COMMAND");
  }
  std::vector<std::filesystem::path> hidden = options.recordings;
  for (const auto* words : {&options.conditions, &options.predictions}) {
    for (const std::string& word : *words) {
      if (std::filesystem::is_regular_file(word)) { hidden.emplace_back(word); }
    }
  }
  return confined(options.subject, options, hidden);
}

/// Simulates an insertion with a simulator of its own process. Each candidate is a scene folder.
Trace simulate_with(const SubjectChoice& choice, const std::shared_ptr<const io::SceneFile>& file,
                    const Scene& scene) {
  const std::unique_ptr<Subject> subject = make_subject(choice, file);
  try {
    subject->load(scene, build_network(scene), true);
  } catch (const CannotDo& problem) {
    throw InputError("--subject " + choice.subject + ": " + problem.what());
  }
  return run_to_end(*subject, scene, &interrupted);
}

CalibrationOptions calibration_options(const CalibrateOptions& options, const LoadedScene& loaded) {
  const auto cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  CalibrationOptions how{.jobs = options.jobs > 0 ? options.jobs : cores, .stop = &interrupted};
  if (!options.quiet && isatty(STDERR_FILENO) != 0) { how.progress = tell_stage; }
  if (options.subject.foreign()) {
    how.simulate = [choice = simulator_of(options),
                    file = std::make_shared<const io::SceneFile>(loaded.file)](const Scene& scene) {
      return observe_run(simulate_with(choice, file, scene));
    };
  }
  return how;
}

/// Adds the fitted values to the comment of a fitted scene.
void add_fitted(const Fit& fit, std::vector<std::string>& lines) {
  for (const std::size_t n : fit.told) {
    const FittedParameter& each = fit.parameters[n];
    char text[160];
    std::snprintf(text, sizeof text, ": %.5g (%.3g to %.3g) %s, was %.5g", each.value,
                  each.interval.lower, each.interval.upper, each.parameter.unit.c_str(),
                  each.parameter.prior);
    lines.push_back("  " + each.parameter.key + text);
  }
}

std::string recording_line(const std::string& file, const Recording& recording,
                           const std::string& hash) {
  return "  " + file + " (" + std::string(io::word_of(recording.kind)) + "), FNV-1a " + hash;
}

/// Comment at the start of fitted.toml. It contains nothing that differs between two runs.
std::vector<std::string> comment_of(const CalibrationReport& report) {
  std::vector<std::string> lines{"Calibrated from " + report.scene + " by `palpate calibrate`: " +
                                     calibration_verdict(report) + ".",
                                 calibration_detail(report), "Told, with 95 % intervals:"};
  add_fitted(report.result.fit, lines);
  lines.emplace_back("All other numbers are those of the scene. Recordings:");
  for (const CalibratedRecording& each : report.recordings) {
    lines.push_back(recording_line(each.file, each.observed.recording, each.hash));
  }
  return lines;
}

void tell_fitted(const Fit& fit) {
  for (const std::size_t n : fit.told) {
    const FittedParameter& each = fit.parameters[n];
    std::printf("  %-44s %.4g -> %.4g %s, 95 %%: %.3g to %.3g\n",
                io::printable(each.parameter.key).c_str(), each.parameter.prior, each.value,
                each.parameter.unit.c_str(), each.interval.lower, each.interval.upper);
  }
}

void tell_notes(const std::vector<std::string>& warnings, const std::filesystem::path& folder) {
  for (const std::string& warning : warnings) {
    std::fprintf(stderr, "palpate: note: %s\n", io::printable(warning).c_str());
  }
  std::printf("%s\n", io::printable((folder / "report.html").string()).c_str());
}

void tell(const CalibrationReport& report, const std::filesystem::path& folder,
          const CommonOptions& options) {
  std::printf("%s\n",
              in_colour(calibration_verdict(report), report.result.outcome().status).c_str());
  if (options.quiet) { return; }
  std::printf("%s\n", calibration_detail(report).c_str());
  tell_fitted(report.result.fit);
  for (const HeldOut& held : report.result.held_out) {
    std::printf("  without %s: error %.3g %% of those fitted, %.3g %% of those predicted\n",
                held.group.empty() ? "recordings of no group" : io::printable(held.group).c_str(),
                100.0 * held.error_fitted, 100.0 * held.error_predicted);
  }
  tell_notes(calibration_warnings(report), folder);
}

Scene scene_at_priors(const Scene& scene, const std::vector<Parameter>& parameters) {
  std::vector<double> values;
  for (const Parameter& each : parameters) { values.push_back(each.prior); }
  return with_values(scene, parameters, values);
}

// Insertions of several conditions.

/// A condition as given on the command line, and its files.
struct GivenCondition {
  LoadedScene scene;
  std::vector<RecordingFile> recordings{};
  calibration::Condition condition{};
};

/// Splits the values of all uses of an option into those of each use. Between them stands an empty
/// value, or "%%" with later versions of CLI11.
std::vector<std::vector<std::string>> split(const std::vector<std::string>& values) {
  std::vector<std::vector<std::string>> uses;
  bool first = true;
  for (const std::string& value : values) {
    if (value.empty() || value == "%%") {
      first = true;
      continue;
    }
    if (first) { uses.emplace_back(); }
    first = false;
    uses.back().push_back(value);
  }
  return uses;
}

/// Loads "SCENE [name=NAME] [KEY=VALUE]... RECORDING...". Throws InputError.
GivenCondition load_condition(const std::string& option, const std::vector<std::string>& words,
                              const CalibrateOptions& options, bool fitted) {
  constexpr const char* needed = "needed is SCENE [name=NAME] [KEY=VALUE]... RECORDING...";
  for (const std::string& word : words) {  // the command line takes the first words unseen
    if (word.starts_with("--")) {
      throw InputError(option + ": is followed by " + word + "; " + needed);
    }
  }
  const std::filesystem::path file = words.front();
  CommonOptions common = options;
  std::string name = file.stem().string();
  std::string given_name;
  std::vector<std::filesystem::path> recordings;
  std::set<std::string> keys;
  for (const std::string& word : std::span(words).subspan(1)) {
    if (word.starts_with("name=") && word.size() > 5) {
      given_name = word.substr(5);
    } else if (word.find('=') != word.npos && !std::filesystem::exists(word)) {
      const std::string key = word.substr(0, word.find('='));
      if (!keys.insert(key).second) {
        throw InputError(option + " " + file.string() + ": " + key + " is given twice");
      }
      common.overrides.push_back(word);
      name += " " + word;
    } else {
      recordings.emplace_back(word);
    }
  }
  if (recordings.empty()) {
    throw InputError(option + " " + file.string() + ": no recording; " + needed);
  }
  GivenCondition given{.scene = load_scene(file, common, false),
                       .recordings = read_recordings(recordings)};
  given.condition = {.name = given_name.empty() ? name : given_name,
                     .scene = given.scene.file.scene,
                     .fitted = fitted};
  for (const RecordingFile& each : given.recordings) {
    given.condition.recordings.push_back(each.input.recording);
  }
  if (const std::string why = why_not_calibrated(given.condition); !why.empty()) {
    throw InputError(option + " " + file.string() + ": " + why);
  }
  return given;
}

/// File name of the fitted scene of a condition.
std::string fitted_name(std::string name) {
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '.') { c = '_'; }
  }
  return name + "-fitted.toml";
}

std::vector<GivenCondition> load_conditions(const CalibrateOptions& options) {
  if (!options.recordings.empty() || !options.scene.empty()) {
    throw InputError(
        "calibrate: recordings and --scene are given beside --condition; each --condition needs "
        "its own: SCENE RECORDING...");
  }
  if (options.conditions.empty()) {
    throw InputError("calibrate: --predict needs a --condition to fit");
  }
  std::vector<GivenCondition> all;
  for (const auto& words : split(options.conditions)) {
    all.push_back(load_condition("--condition", words, options, true));
  }
  for (const auto& words : split(options.predictions)) {
    all.push_back(load_condition("--predict", words, options, false));
  }
  std::set<std::string> names;
  std::map<std::string, const GivenCondition*> used;  // by the hash of a recording
  for (const GivenCondition& each : all) {
    const std::string& name = each.condition.name;
    if (!names.insert(fitted_name(name)).second) {
      throw InputError("calibrate: " + name +
                       " is given twice; every condition needs a name of its own (name=NAME)");
    }
    for (const RecordingFile& one : each.recordings) {
      const auto [first, fresh] = used.try_emplace(one.hash, &each);
      if (fresh) { continue; }
      const calibration::Condition& other = first->second->condition;
      throw InputError(one.file.string() +
                       (other.fitted == each.condition.fitted
                            ? ": is in " + other.name + " too; every recording once"
                            : ": is fitted and predicted; a prediction needs recordings that the "
                              "fit has not seen"));
    }
  }
  return all;
}

ComparisonReport compared(const GivenCondition& given, const ConditionCheck& check,
                          const CalibrateOptions& options) {
  ComparisonReport report{.recordings = given.recordings,
                          .simulation = {.origin = ComparedSimulation::Origin::scene,
                                         .file = given.scene.file.inputs.front(),
                                         .hash = io::content_hash(given.scene.file.text),
                                         .title = check.scene.title,
                                         .trace = check.simulated},
                          .found = check.comparison,
                          .command = options.command};
  report.options.comparison.quantity = comparison::QuantityKind::insertion;
  report.options.comparison.column = comparison::column_of(report.options.comparison);
  return report;
}

std::vector<std::string> comment_of(const InsertionFitReport& report, const std::string& name) {
  std::vector<std::string> lines{
      "Fitted by `palpate calibrate`; condition " + name + ". " + calibration_verdict(report) + ".",
      "Fitted values, with 95 % intervals:"};
  add_fitted(report.result.fit, lines);
  lines.emplace_back("Recordings:");
  for (std::size_t n = 0; n < report.conditions.size(); ++n) {
    if (!report.result.conditions[n].fitted) { continue; }
    for (const RecordingFile& each : report.conditions[n].recordings) {
      lines.push_back(
          recording_line(each.file.filename().string(), each.input.recording, each.hash));
    }
  }
  return lines;
}

void tell(const InsertionFitReport& report, const std::filesystem::path& folder,
          const CommonOptions& options) {
  std::printf("%s\n",
              in_colour(calibration_verdict(report), report.result.outcome().status).c_str());
  if (options.quiet) { return; }
  tell_fitted(report.result.fit);
  tell_notes(calibration_warnings(report), folder);
}

int run_insertions(const CalibrateOptions& options) {
  std::vector<GivenCondition> given = load_conditions(options);
  std::vector<calibration::Condition> conditions;
  for (const GivenCondition& each : given) { conditions.push_back(each.condition); }
  const std::vector<Parameter> parameters =
      chosen_parameters(options, calibration::parameters_of(conditions));
  if (parameters.empty()) {
    throw InputError(
        "calibrate: the materials of the fitted conditions have no parameter above "
        "zero; friction, cutting_force or youngs_modulus are needed");
  }
  for (calibration::Condition& each : conditions) {
    each.scene = scene_at_priors(each.scene, parameters);
  }
  const CalibrationOptions how = calibration_options(options, given.front().scene);
  InsertionFitReport report{.command = options.command, .provenance = build_provenance()};
  const SubjectChoice choice = simulator_of(options);
  // Refuses a scene that the simulator cannot represent.
  for (const GivenCondition& each : given) {
    if (const auto foreign = foreign_subject(choice, each.scene)) {
      report.provenance.merge(subject_provenance(foreign->facts()));
    }
  }
  try {
    InsertionFitOptions fit_options{
        .jobs = how.jobs, .starts = options.starts, .stop = &interrupted};
    if (how.progress) {
      fit_options.progress = [](const std::string& stage) { tell_stage(stage.c_str()); };
    }
    if (choice.foreign()) {
      fit_options.simulate = [&choice](const Scene& scene) {
        return simulate_with(choice, nullptr, scene);
      };
    }
    report.result = fit_insertions(conditions, parameters, fit_options);
  } catch (const std::invalid_argument& problem) {
    throw InputError("--condition " + given.front().scene.file.inputs.front().string() + ": " +
                     problem.what() +
                     "; conditions of two recordings or more, whose forces have features");
  } catch (const Interrupted&) {
    std::fprintf(stderr, "palpate: interrupted before a fit; nothing was written\n");
    return interrupted_code;
  }
  std::vector<std::pair<std::string, std::string>> files;
  for (std::size_t n = 0; n < given.size(); ++n) {
    report.conditions.push_back(compared(given[n], report.result.conditions[n], options));
  }
  for (std::size_t n = 0; n < given.size(); ++n) {
    const std::string& name = report.result.conditions[n].name;
    files.emplace_back(
        fitted_name(name),
        io::rewrite_scene(given[n].scene.file,
                          changes(given[n].scene.file.scene, report.result.conditions[n].scene),
                          comment_of(report, name)));
  }
  files.emplace_back("calibration.json", to_json(report));
  files.emplace_back("report.html", to_html(report));
  std::vector<std::string> names;
  for (const auto& [name, text] : files) { names.push_back(name); }
  const std::filesystem::path folder = options.make_folder(names);
  const io::WholeWrite whole;
  for (const auto& [name, text] : files) { io::replace_file(folder / name, text); }
  tell(report, folder, options);
  return report.result.outcome().status == Status::pass ? done : fell_short;
}

int run_calibrate(const CalibrateOptions& options) {
  keep_results_of_interrupted();
  if (!options.conditions.empty() || !options.predictions.empty()) {
    return run_insertions(options);
  }
  if (options.recordings.empty() || options.scene.empty()) {
    throw InputError(
        "calibrate: recordings and --scene SCENE are needed, or --condition SCENE "
        "RECORDING... for insertions with force and depth");
  }
  const LoadedScene loaded = load_scene(options.scene, options, false);
  const Scene& scene = loaded.file.scene;
  if (const std::string why = why_not_calibrated(scene); !why.empty()) {
    throw InputError(options.scene.string() + ": " + why);
  }
  const std::vector<Parameter> parameters =
      chosen_parameters(options, calibration::parameters_of(scene));
  CalibrationReport report;
  read_recordings(options.recordings, [&report](const RecordingFile& read) {
    report.recordings.push_back(observed(read));
  });
  report.scene = options.scene.filename().string();
  report.scene_hash = io::content_hash(loaded.file.text);
  report.command = options.command;
  report.provenance = build_provenance();
  // Refuses a scene that the simulator cannot represent.
  if (const auto foreign = foreign_subject(simulator_of(options), loaded)) {
    report.provenance.merge(subject_provenance(foreign->facts()));
  }
  std::vector<calibration::ObservedRecording> subjects;
  for (const CalibratedRecording& each : report.recordings) { subjects.push_back(each.observed); }
  try {
    report.result = calibration::calibrate(scene_at_priors(scene, parameters), parameters, subjects,
                                           calibration_options(options, loaded));
  } catch (const Interrupted&) {
    std::fprintf(stderr, "palpate: interrupted before a fit; nothing was written\n");
    return interrupted_code;
  }
  const std::string page = to_html(report);
  const std::string fitted =
      io::rewrite_scene(loaded.file, changes(scene, report.result.fitted), comment_of(report));
  const std::filesystem::path folder =
      options.make_folder({"calibration.json", "fitted.toml", "report.html"});
  const io::WholeWrite whole;
  io::replace_file(folder / "fitted.toml", fitted);
  io::replace_file(folder / "calibration.json", to_json(report));
  io::replace_file(folder / "report.html", page);
  tell(report, folder, options);
  return report.result.outcome().status == Status::pass ? done : fell_short;
}

}  // namespace

void add_calibrate(Program& program) {
  const auto [command, options] = add_command(
      program, "calibrate", "fit layers and syringe of a scene to recordings", run_calibrate);
  add_value(command, "recordings", options.recordings, "RECORDING",
            "recordings in any format that import reads");
  add_value(command, "--scene", options.scene, "SCENE",
            "scene file: needle, layers, syringe (docs/scenes.md)");
  const auto add_condition = [&](const char* name, std::vector<std::string>& values,
                                 const char* help) {
    command.add_option(name, values, help)
        ->type_name("SCENE [name=NAME] [KEY=VALUE]... RECORDING...")
        ->expected(2, CLI::detail::expected_max_vector_size)
        ->inject_separator();
  };
  add_condition("--condition", options.conditions,
                "measured insertions with force and depth, and the scene that simulates them; "
                "repeatable, fitted together");
  add_condition("--predict", options.predictions,
                "insertions that are not fitted but predicted; repeatable");
  command.add_option("--starts", options.starts, "searches from different places [1]")
      ->check(CLI::Range(1, 100));
  add_overrides(command, options);
  add_value(command, "--parameter", options.parameters, "KEY",
            "fit this key, as material.NAME.friction; repeatable [all]");
  add_value(command, "--prior", options.priors, "KEY=VALUE:SPREAD",
            "value and SD of its logarithm, instead of the scene's; repeatable");
  add_value(command, "--bounds", options.bounds, "KEY=LOWER:UPPER",
            "least and largest value [4 spreads either side]; repeatable");
  add_subject_options(command, options.subject);
  command.add_option("--jobs", options.jobs, "simulations at a time [one per core]")
      ->check(CLI::Range(1, 1024));
  add_json(command, options, "calibration.json");
  command.footer(
      "Keys: material.NAME.cutting_force, friction, youngs_modulus; layer.INDEX.thickness of the "
      "fat;\nsyringe.thumb_force, compliance, tissue_resistance, epidural_resistance. What "
      "recordings cannot\ntell stays as it is and is named. Nothing is drawn at random: the same "
      "input, the same fit.\nWrites fitted.toml, calibration.json, report.html. "
      "docs/calibration.md shows how.");
}

}  // namespace palpate::cli
