// SPDX-License-Identifier: MIT

#include "reports/results/baseline_file.hpp"

#include <functional>
#include <stdexcept>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/hdf5_file.hpp"
#include "model/problem/input_error.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/results/results_json.hpp"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

constexpr int baseline_schema = 1;
constexpr std::size_t most_bytes = 1U << 30U;
constexpr const char* seal_key = "seal";

/// Hash of all contents except the hash itself. It detects edits by hand.
std::string seal_of(Json json) {
  json.erase(seal_key);
  return io::content_hash(json_text(json));
}

gate::Spread spread_from(const Json& json) {
  return {
      .quantities = json.at("quantities"), .curves = json.at("curves"), .runs = json.at("runs")};
}

Json approval_json(const gate::Approval& entry) {
  return object("date", entry.date, "commit", entry.commit, "reason", entry.reason, "cases",
                entry.cases);
}

gate::Approval approval_from(const Json& json) {
  return {.date = json.at("date"),
          .commit = json.at("commit"),
          .reason = json.at("reason"),
          .cases = json.at("cases")};
}

Json accepted_json(const gate::AcceptedCase& accepted) {
  Json json = case_json(accepted.outcome);
  for (const char* key : {"seconds", "tables", "traces", "notes", "timings"}) { json.erase(key); }
  const gate::Spread& spread = accepted.spread;
  json["spread"] =
      object("runs", spread.runs, "quantities", spread.quantities, "curves", spread.curves);
  return json;
}

Json to_json(const gate::Baseline& baseline, const std::string& hash_of_curves) {
  Json json =
      object("kind", "palpate baseline", "schema", baseline_schema, "command", baseline.command,
             "ledger", list_of(baseline.ledger, approval_json), "provenance", baseline.provenance,
             "curves", hash_of_curves, "cases", list_of(baseline.cases, accepted_json));
  json[seal_key] = seal_of(json);
  return json;
}

gate::AcceptedCase accepted_from(Json json) {
  json["seconds"] = 0.0;
  for (const char* key : {"tables", "notes", "timings"}) { json[key] = Json::array(); }
  return {.outcome = case_from_json(json), .spread = spread_from(json.at("spread"))};
}

gate::Baseline baseline_from(const Json& json) {
  if (json.value("kind", "") != "palpate baseline") { throw std::runtime_error("is no baseline"); }
  if (json.at("schema") != baseline_schema) {
    throw std::runtime_error("schema " + json.at("schema").dump() + "; this version reads " +
                             std::to_string(baseline_schema));
  }
  if (json.value(seal_key, "") != seal_of(json)) {
    throw std::runtime_error("was changed by something else than palpate approve");
  }
  gate::Baseline baseline{.command = json.at("command")};
  baseline.provenance = json.at("provenance").get<std::map<std::string, std::string>>();
  for (const Json& each : json.at("ledger")) { baseline.ledger.push_back(approval_from(each)); }
  for (const Json& each : json.at("cases")) { baseline.cases.push_back(accepted_from(each)); }
  if (baseline.cases.empty()) { throw std::runtime_error("holds no case"); }
  return baseline;
}

std::string group_of(const gate::AcceptedCase& accepted) { return "/" + accepted.outcome.name; }

/// Writes the curves and returns the hash of the written file.
std::string write_curves(const std::filesystem::path& path, const gate::Baseline& baseline) {
  io::Hdf5File file = io::Hdf5File::create(path);
  for (const gate::AcceptedCase& accepted : baseline.cases) {
    write_figures(file, group_of(accepted), accepted.outcome.figures);
  }
  file.commit();
  return io::content_hash(io::read_bytes(path, most_bytes));
}

std::filesystem::path curves_of_baseline(const std::filesystem::path& path) {
  return std::filesystem::path(path).replace_extension(".h5");
}

namespace fs = std::filesystem;

/// Removes the temporary folder from a message, since it differs between runs.
std::string without_folder(std::string text, const fs::path& folder) {
  const std::string name = folder.string() + "/";
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) {
    text.erase(at, name.size());
  }
  return text;
}

Outcome sample(double height) {
  Outcome outcome{.name = "sample", .suite = "accuracy", .claim = "A parabola is one."};
  outcome.judge({.name = "height", .value = height, .upper = 10.0, .bound_from = "of a sample"});
  Series curve{.label = "parabola"};
  for (int n = 0; n < 2000; ++n) {
    curve.x.push_back(0.001 * n);
    curve.y.push_back(height * 1e-6 * n * n);
  }
  outcome.figures.push_back({.id = "curve",
                             .title = "Parabola",
                             .x = {.label = "time (s)"},
                             .y = {.label = "height (m)"},
                             .series = {curve}});
  conclude(outcome);
  return outcome;
}

gate::Baseline baseline_of(double height) {
  return gate::accept({}, {.command = "sample", .reason = "sample", .outcomes = {sample(height)}});
}

struct Damage {
  std::string name{};
  std::function<void(const io::ScratchFolder&)> inflict{};
};

std::vector<Damage> damages() {
  using Folder = io::ScratchFolder;
  const auto remove = [](const char* file) {
    return [file](const Folder& s) { fs::remove(s / file); };
  };
  const auto cut = [](const char* file) {
    return [file](const Folder& s) { fs::resize_file(s / file, fs::file_size(s / file) / 2); };
  };
  const auto edit = [](const char* file, const char* old, const char* text) {
    return [=](const Folder& s) {
      std::string bytes = io::read_bytes(s / file, 1U << 24U);
      bytes.replace(bytes.find(old), std::string_view(old).size(), text);
      io::replace_file(s / file, bytes);
    };
  };
  const char* results = "results/results.json";
  return {
      {"the baseline's file is missing", remove("b.json")},
      {"the baseline's file is empty", [](const Folder& s) { fs::resize_file(s / "b.json", 0); }},
      {"the baseline's file is cut short", cut("b.json")},
      {"a line of the baseline is garbled", edit("b.json", "\"ledger\": [", "\"ledger\": ")},
      {"a number of the baseline was edited", edit("b.json", "\"value\": 3.0", "\"value\": 4.0")},
      {"a unit of the baseline was edited", edit("b.json", "\"unit\": \"1\"", "\"unit\": \"m\"")},
      {"the baseline's curves are missing", remove("b.h5")},
      {"the baseline's curves have another name",
       [](const Folder& s) { fs::rename(s / "b.h5", s / "c.h5"); }},
      {"the baseline's curves are cut short", cut("b.h5")},
      {"the curves belong to another baseline",
       [](const Folder& s) {
         write_baseline(s / "other.json", baseline_of(5.0));
         fs::rename(s / "other.h5", s / "b.h5");
       }},
      {"the results are cut short", cut(results)},
      {"a trace of the results is missing", remove("results/traces/sample.h5")},
      {"a trace of the results is cut short", cut("results/traces/sample.h5")},
      {"a failure of the results says pass", edit(results, "\"value\": 3.0", "\"value\": 30.0")},
      {"a number of the results is not one",
       edit(results, "\"value\": 3.0", "\"value\": \"nan\"")}};
}

}  // namespace

void write_baseline(const std::filesystem::path& path, const gate::Baseline& baseline) {
  if (path.extension() == ".h5") {
    throw InputError(path.string() + ": the curves go there; a name with another ending, as .json");
  }
  const std::string hash = write_curves(curves_of_baseline(path), baseline);
  io::replace_file(path, json_text(to_json(baseline, hash)));
}

gate::Baseline read_baseline(const std::filesystem::path& path) {
  const std::string text = io::read_text(path, most_bytes);
  gate::Baseline baseline;
  std::string hash;
  try {
    const Json json = Json::parse(text);
    baseline = baseline_from(json);
    hash = json.at("curves");
  } catch (const std::exception& problem) {
    throw json_trouble(path.string(), text, problem, "a baseline as palpate approve wrote it");
  }
  const std::filesystem::path curves = curves_of_baseline(path);
  if (io::content_hash(io::read_bytes(curves, most_bytes)) != hash) {
    throw InputError(curves.string() + ": does not belong to " + path.string() +
                     ", or is damaged; the curves that palpate approve wrote with it");
  }
  const io::Hdf5File file = io::Hdf5File::open(curves);
  for (gate::AcceptedCase& accepted : baseline.cases) {
    read_figures(file, curves, group_of(accepted), accepted.outcome.figures);
  }
  return baseline;
}

std::vector<std::pair<std::string, std::string>> try_damaged_files() {
  std::vector<std::pair<std::string, std::string>> found;
  for (const Damage& damage : damages()) {
    const io::ScratchFolder scratch;
    write_baseline(scratch / "b.json", baseline_of(3.0));
    write_results_folder(scratch / "results",
                         {.title = "sample", .command = "sample", .outcomes = {sample(3.0)}});
    damage.inflict(scratch);
    std::string refusal;
    try {
      (void)read_baseline(scratch / "b.json");
      (void)read_results_folder(scratch / "results");
    } catch (const InputError& problem) {
      refusal = without_folder(problem.what(), scratch.path());
    }
    found.emplace_back(damage.name, refusal);
  }
  return found;
}

}  // namespace palpate
