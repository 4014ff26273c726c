// SPDX-License-Identifier: MIT

#include "reports/results/results_folder.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/trace_file.hpp"
#include "model/problem/input_error.hpp"
#include "reports/results/results_json.hpp"
#include "validation/number_text.hpp"

namespace palpate {
namespace {

void write_figure(io::Hdf5File& file, const std::string& above, const Figure& figure) {
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    const Series& series = figure.series[n];
    const std::string group = above + series_group(figure, n);
    file.write(group + "/x", series.x, figure.x.label);
    file.write(group + "/y", series.y, figure.y.label);
    if (!series.y2.empty()) { file.write(group + "/y2", series.y2, figure.y.label); }
    file.write_attribute(group, "label", series.label);
  }
  if (figure.heat_map) {
    const std::string group = above + heat_map_group(figure);
    file.write(group + "/x", figure.heat_map->x, figure.x.label);
    file.write(group + "/y", figure.heat_map->y, figure.y.label);
    file.write(group + "/z", figure.heat_map->z, figure.heat_map->label);
  }
  const std::string group = above + "/figures/" + figure.id;
  file.make_group(group);
  file.write_attribute(group, "title", figure.title);
  file.write_attribute(group, "caption", figure.caption);
}

/// Throws an InputError with the file and the group unless `fits` is true.
void require(bool fits, const std::filesystem::path& file, const std::string& group) {
  if (!fits) {
    throw InputError(file.string() + ": " + group + ": data sets of different lengths");
  }
}

void read_figure(const io::Hdf5File& file, const std::filesystem::path& path,
                 const std::string& above, Figure& figure) {
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    Series& series = figure.series[n];
    const std::string group = above + series_group(figure, n);
    series.x = file.read(group + "/x");
    series.y = file.read(group + "/y");
    if (file.contains(group + "/y2")) { series.y2 = file.read(group + "/y2"); }
    require(series.x.size() == series.y.size() &&
                (!series.filled() || series.x.size() == series.y2.size()),
            path, group);
  }
  if (!figure.heat_map) { return; }
  HeatMap& map = *figure.heat_map;
  const std::string group = above + heat_map_group(figure);
  map.x = file.read(group + "/x");
  map.y = file.read(group + "/y");
  map.z = file.read(group + "/z");
  require(map.z.size() == map.x.size() * map.y.size(), path, group);
}

using Json = nlohmann::ordered_json;

constexpr std::size_t most_frames = 60;
constexpr std::size_t most_numbers = 2'000'000;  ///< numbers of all frames together

void add_number(Outcome& outcome, const std::string& name, const Json& value,
                const std::string& unit) {
  outcome.quantities.push_back({.name = name, .value = number_from_json(value), .unit = unit});
}

/// Converts a column name to an id: "tool.force_n" to "tool-force-n".
std::string id_of(const std::string& name) {
  std::string id;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    id += std::isalnum(byte) != 0 ? static_cast<char>(std::tolower(byte)) : '-';
  }
  return id;
}

Figure column_figure(const Trace& trace, const Column& column) {
  return {.id = id_of(column.name),
          .title = column.name,
          .x = {.label = "time (s)"},
          .y = {.label = column.name + " (" + column.unit + ")"},
          .series = {{.x = trace.time, .y = column.values}}};
}

/// Displacement of the nodes, one coordinate after the other; a norm could hide a changed
/// coordinate.
Series moved_by(const Trace& trace, std::size_t frame) {
  const NodeVectors moved = trace.frames.position[frame] - trace.frames.position.front();
  Series series{.label = "frame " + std::to_string(frame), .style = Series::Style::points};
  series.y.assign(moved.data(), moved.data() + moved.size());
  for (std::size_t n = 0; n < series.y.size(); ++n) { series.x.push_back(static_cast<double>(n)); }
  return series;
}

Figure node_figure(const Trace& trace) {
  Figure figure{.id = "nodes",
                .title = "How far every node has moved",
                .x = {.label = "coordinate (1)"},
                .y = {.label = "displacement (m)"}};
  const auto numbers = static_cast<std::size_t>(trace.frames.position.front().size());
  const std::size_t kept = std::clamp<std::size_t>(most_numbers / numbers, 1, most_frames);
  const std::size_t stride = (trace.frames.position.size() - 1 + kept - 1) / kept;
  for (std::size_t n = stride; n < trace.frames.position.size(); n += stride) {
    figure.series.push_back(moved_by(trace, n));
  }
  return figure;
}

/// Reason why a run cannot be accepted, a value that is not finite; empty if there is none.
std::string not_finite(const Outcome& outcome) {
  for (const Figure& figure : outcome.figures) {
    for (const Series& series : figure.series) {
      const auto found =
          std::ranges::find_if_not(series.y, [](double y) { return std::isfinite(y); });
      if (found == series.y.end()) { continue; }
      const double at = series.x[static_cast<std::size_t>(found - series.y.begin())];
      return figure.title + " is not finite at " + figure.x.label + " = " + plain_number(at);
    }
  }
  return {};
}

Outcome outcome_of(const Json& summary, const Trace& trace, const std::string& scene) {
  Outcome outcome{.name = "run", .suite = "run", .claim = scene};
  const auto status = summary.at("status").get<std::string>();
  if (status != "ok") {
    outcome.status = Status::error;
    outcome.reasons = {"the run " + status};
  }
  for (const char* key : {"nodes", "springs", "ticks", "steps", "substeps"}) {
    add_number(outcome, key, summary.at(key), "1");
  }
  for (const char* key : {"initial_j", "final_j", "max_j"}) {
    add_number(outcome, std::string("energy.") + key, summary.at("energy").at(key), "J");
  }
  std::map<std::string, int> met;  // by kind: another event renames none of other kinds
  for (const Json& event : summary.at("events")) {
    const auto detail = event.at("detail").get<std::string>();
    const std::string kind =
        event.at("kind").get<std::string>() + (detail.empty() ? "" : " " + detail);
    const int count = ++met[kind];
    add_number(outcome, "event: " + kind + (count > 1 ? " #" + std::to_string(count) : ""),
               event.at("time_s"), "s");
  }
  for (const Column& column : trace.columns) {
    outcome.figures.push_back(column_figure(trace, column));
  }
  if (trace.frames.position.size() > 1 && trace.frames.position.front().size() > 0) {
    outcome.figures.push_back(node_figure(trace));
  }
  if (std::string problem = not_finite(outcome);
      !problem.empty() && outcome.status == Status::pass) {
    outcome.status = Status::error;
    outcome.reasons = {std::move(problem)};
  }
  return outcome;
}

/// Text attributes of the root group of the file.
std::map<std::string, std::string> provenance_of(const std::filesystem::path& trace) {
  const io::Hdf5File file = io::Hdf5File::open(trace);
  std::map<std::string, std::string> provenance;
  for (const char* key :
       {"version", "commit", "compiler", "flags", "processor", "date", "scene", "overrides"}) {
    if (file.has_attribute("/", key)) { provenance[key] = file.text_attribute("/", key); }
  }
  return provenance;
}

/// Title with a hash of the scene text. A changed text makes an old baseline stale.
std::string scene_named(const std::string& title, std::map<std::string, std::string> provenance) {
  return title + ", scene " + io::content_hash(provenance["scene"] + provenance["overrides"]);
}

constexpr int baseline_schema = 1;
constexpr std::size_t most_bytes = 1U << 30U;       // of the curves of a baseline
constexpr std::size_t most_json_bytes = 1U << 26U;  // parsed, a text may take 20 times as much
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

std::string series_group(const Figure& figure, std::size_t index) {
  return "/figures/" + figure.id + "/series_" + std::to_string(index);
}

std::string heat_map_group(const Figure& figure) { return "/figures/" + figure.id + "/heat_map"; }

std::string trace_file_name(const std::string& case_name) {
  std::string name = case_name;
  std::ranges::replace(name, '/', '-');
  return name + ".h5";
}

void write_figure_data(const std::filesystem::path& traces, const Outcome& outcome) {
  if (outcome.figures.empty()) { return; }
  io::Hdf5File file = io::Hdf5File::create(traces / trace_file_name(outcome.name));
  write_figures(file, "", outcome.figures);
  file.write_attribute("/", "case", outcome.name);
  file.commit();
}

void read_figure_data(const std::filesystem::path& traces, Outcome& outcome) {
  if (outcome.figures.empty()) { return; }
  const std::filesystem::path path = traces / trace_file_name(outcome.name);
  const io::Hdf5File file = io::Hdf5File::open(path);
  read_figures(file, path, "", outcome.figures);
}

void write_figures(io::Hdf5File& file, const std::string& above,
                   const std::deque<Figure>& figures) {
  for (const Figure& figure : figures) { write_figure(file, above, figure); }
}

void read_figures(const io::Hdf5File& file, const std::filesystem::path& path,
                  const std::string& above, std::deque<Figure>& figures) {
  for (Figure& figure : figures) { read_figure(file, path, above, figure); }
}

bool is_run_folder(const std::filesystem::path& folder) {
  return std::filesystem::exists(folder / "summary.json") &&
         !std::filesystem::exists(folder / "results.json");
}

Results read_run_folder(const std::filesystem::path& folder) {
  constexpr std::size_t most_summary_bytes = 1U << 24U;
  const std::filesystem::path file = folder / "summary.json";
  const std::string text = io::read_text(file, most_summary_bytes);
  const Trace trace = io::read_trace_hdf5(folder / "trace.h5");
  std::map<std::string, std::string> provenance = provenance_of(folder / "trace.h5");
  try {
    const Json summary = parse_json(text);
    const std::string scene = scene_named(summary.at("title"), provenance);
    provenance.erase("scene");
    provenance.erase("overrides");
    return {.title = summary.at("title"),
            .command = "palpate run",
            .provenance = std::move(provenance),
            .outcomes = {outcome_of(summary, trace, scene)}};
  } catch (const std::exception& problem) {
    throw json_trouble(file.string(), text, problem, "summary.json as palpate wrote it");
  }
}

void write_results_folder(const std::filesystem::path& folder, const Results& results) {
  const std::filesystem::path traces = folder / "traces";
  std::error_code problem;
  std::filesystem::create_directories(traces, problem);
  if (problem) {
    throw InputError(traces.string() + ": cannot be made; a folder that can be written");
  }
  for (const Outcome& outcome : results.outcomes) { write_figure_data(traces, outcome); }
  io::replace_file(folder / "results.json", to_json(results));
  io::replace_file(folder / "results.xml", to_junit(results));
  io::replace_file(folder / "report.html", to_html(results));
}

Results read_results_folder(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "results.json";
  Results results = results_from_json(io::read_text(file, most_json_bytes), file.string());
  for (Outcome& outcome : results.outcomes) { read_figure_data(folder / "traces", outcome); }
  return results;
}

void write_baseline(const std::filesystem::path& path, const gate::Baseline& baseline) {
  if (path.extension() == ".h5") {
    throw InputError(path.string() + ": the curves go there; a name with another ending, as .json");
  }
  const std::string hash = write_curves(curves_of_baseline(path), baseline);
  io::replace_file(path, json_text(to_json(baseline, hash)));
}

gate::Baseline read_baseline(const std::filesystem::path& path) {
  const std::string text = io::read_text(path, most_json_bytes);
  gate::Baseline baseline;
  std::string hash;
  try {
    const Json json = parse_json(text);
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
