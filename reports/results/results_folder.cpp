// SPDX-License-Identifier: MIT

#include "reports/results/results_folder.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <functional>
#include <iomanip>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <unistd.h>

#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_file.hpp"
#include "fixtures/io/scene_folder.hpp"
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
using Attributes = std::map<std::string, std::string>;

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

/// Adds the time of something, found at the end of a tick; rounding may move it by one tick more.
void add_time(Outcome& outcome, const std::string& name, double time, double tick,
              std::map<std::string, int>& met) {
  const int count = ++met[name];  // of its own: another event renames none of other kinds
  outcome.quantities.push_back({.name = name + (count > 1 ? " #" + std::to_string(count) : ""),
                                .value = time,
                                .unit = "s",
                                .uncertainty = 2.0 * tick});
}

void add_times(Outcome& outcome, const Json& summary, const Trace& trace) {
  // The tick of the scene, not the distance of rows, which --every sets.
  const double tick =
      number_from_json(summary.at("integrator_step_s")) * number_from_json(summary.at("substeps"));
  const Json& events = summary.at("events");
  std::map<std::string, int> met;
  for (const Json& event : events) {
    const auto detail = event.at("detail").get<std::string>();
    const std::string kind = event.at("kind");
    add_time(outcome, std::string(gate::event_prefix) + kind + (detail.empty() ? "" : " " + detail),
             number_from_json(event.at("time_s")), tick, met);
  }
  const double row = trace.time.size() > 1 ? trace.time[1] - trace.time[0] : 0.0;
  for (const TextColumn& column : trace.text_columns) {
    if (column.name != "tool.layer") { continue; }  // that of events repeats the events
    for (std::size_t n = 0; n < std::min(column.values.size(), trace.time.size()); ++n) {
      if (n > 0 && column.values[n] == column.values[n - 1]) { continue; }
      add_time(outcome, column.name + ": " + column.values[n], trace.time[n], row, met);
    }
  }
}

/// Adds the numbers of an object of a summary, by the names of their keys. Left out are those of
/// the clock of the machine, times of extremes, which rounding moves, and what is compared in
/// another form.
void add_numbers(Outcome& outcome, const Json& object, const std::string& above = {}) {
  static const std::set<std::string, std::less<>> left_out{
      "schema",    "nodes",           "springs",        "ticks",
      "steps",     "substeps",        "wall_s",         "load_s",
      "energy",    "late_ticks",      "slowest_tick_s", "ns_per_spring_step",
      "real_time", "subject",         "peak_force_n",   "peak_force_depth_m",
      "deepest_m", "peak_pressure_pa"};
  for (const auto& [key, value] : object.items()) {
    if (left_out.contains(key) || key.ends_with("_at_s")) { continue; }
    if (value.is_object()) { add_numbers(outcome, value, above + key + "."); }
    if (!value.is_number()) { continue; }
    const std::string_view unit = io::unit_in_name(key);
    add_number(outcome, above + key, value, unit.empty() ? "1" : std::string(unit));
  }
}

/// Replaces every number in a text by '#': rounding may change its digits.
std::string without_numbers(const std::string& text) {
  std::string result;
  bool in_number = false;
  for (const char c : text) {
    const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    in_number = digit || (in_number && std::string_view(".eE+-").find(c) != std::string_view::npos);
    if (!in_number) {
      result += c;
    } else if (!result.ends_with('#')) {
      result += '#';
    }
  }
  return result;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) { lines.push_back(line); }
  return lines;
}

/// Texts of a run that must stay: what ran, its size, its warnings and its scene.
void add_texts(Outcome& outcome, const Json& summary, const Attributes& inputs) {
  Table& table =
      outcome.table(std::string(gate::text_table), "Compared texts", "", {"name", "text"});
  const auto add = [&table](const std::string& name, const std::string& text) {
    table.rows.push_back({name, text});
  };
  for (const char* key : {"nodes", "springs", "ticks", "steps", "substeps"}) {
    add(key, summary.at(key).dump());
  }
  add("integrator", summary.at("integrator"));
  // Instruction sets change rounding, which has a spread, and threads change nothing.
  static const std::regex circumstances("-(avx512|avx2|baseline|[0-9]+-threads)");
  add("kernel", std::regex_replace(summary.at("kernel").get<std::string>(), circumstances, ""));
  for (const std::string warning : summary.at("warnings")) {
    if (warning.starts_with("one thread:") || warning.find(" threads on ") != warning.npos) {
      continue;
    }
    add(std::string(gate::warning_prefix) + without_numbers(warning), "");
  }
  for (const std::string skipped : summary.at("skipped")) {
    add("skipped: " + without_numbers(skipped), "");
  }
  for (const auto& [key, value] :
       io::keys_given(entry(inputs, "scene"), lines_of(entry(inputs, "overrides")))) {
    if (key == "title" || key == "simulation.threads") { continue; }  // the title is the claim
    add(std::string(gate::scene_prefix) + key, value);
  }
  for (const std::string& line : lines_of(entry(inputs, "inputs"))) {
    const std::size_t space = line.rfind(' ');
    add("input: " + line.substr(0, space), line.substr(std::min(space, line.size())));
  }
}

/// Reads palpation.csv as a figure of the compliance of its sites, which is 0 on bone.
Figure palpation_figure(const std::filesystem::path& file) {
  constexpr std::size_t most_map_bytes = 1U << 26U;
  HeatMap map{.label = "compliance (m/N)"};
  std::istringstream lines(io::read_text(file, most_map_bytes));
  std::string line;
  std::getline(lines, line);  // the names
  while (std::getline(lines, line)) {
    std::array<double, 3> number{};  // x, y, stiffness, which may be infinite
    std::istringstream fields(line);
    std::string field;
    for (double& each : number) {
      if (!std::getline(fields, field, ',') || !io::parse_number(field, each)) {
        io::refuse_file(file, "\"" + io::shown(line) + "\" is no row of three numbers");
      }
    }
    if (map.y.empty() || number[1] != map.y.back()) { map.y.push_back(number[1]); }
    if (map.y.size() == 1) { map.x.push_back(number[0]); }
    map.z.push_back(1.0 / number[2]);
  }
  return {.id = "palpation-map",
          .title = "Palpation map",
          .caption = "Compliance of the skin under the probe.",
          .x = {.label = "x (m)"},
          .y = {.label = "y (m)"},
          .heat_map = std::move(map)};
}

Outcome outcome_of(const Json& summary, const Trace& trace, const Attributes& inputs) {
  Outcome outcome{.name = "run", .suite = "run", .claim = summary.at("title")};
  const auto status = summary.at("status").get<std::string>();
  if (status != "ok") {
    outcome.status = Status::error;
    outcome.reasons = {"the run " + status};
  }
  for (const char* key : {"initial_j", "final_j", "max_j"}) {
    add_number(outcome, std::string("energy.") + key, summary.at("energy").at(key), "J");
  }
  add_numbers(outcome, summary);
  add_times(outcome, summary, trace);
  add_texts(outcome, summary, inputs);
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

/// Returns those of the text attributes of the root group that the file has.
Attributes attributes_of(const std::filesystem::path& trace,
                         std::initializer_list<const char*> keys) {
  const io::Hdf5File file = io::Hdf5File::open(trace);
  Attributes attributes;
  for (const char* key : keys) {
    if (file.has_attribute("/", key)) { attributes[key] = file.text_attribute("/", key); }
  }
  return attributes;
}

constexpr int baseline_schema = 2;
constexpr std::size_t most_bytes = 1U << 30U;       // of the curves of a baseline
constexpr std::size_t most_json_bytes = 1U << 26U;  // parsed, a text may take 20 times as much
constexpr const char* seal_key = "seal";

/// Hash of all contents except the hash itself. It detects edits by hand.
std::string seal_of(Json json) {
  json.erase(seal_key);
  return io::sha256(json_text(json));
}

gate::Spread spread_from(const Json& json) {
  gate::Spread spread{.quantities = json.at("quantities"),
                      .curves = json.at("curves"),
                      .runs = whole_from_json<int>(json.at("runs"))};
  if (spread.runs < 0) {
    throw std::runtime_error("has a spread from " + std::to_string(spread.runs) + " runs");
  }
  for (const auto* list : {&spread.quantities, &spread.curves}) {
    for (const auto& [name, value] : *list) {
      if (value >= 0.0 && std::isfinite(value) && spread.runs > 0) { continue; }
      throw std::runtime_error("has the spread " + exact_number(value) + " of " + name + " from " +
                               std::to_string(spread.runs) + " runs");
    }
  }
  return spread;
}

Json approval_json(const gate::Approval& entry) {
  return object("date", entry.date, "commit", entry.commit, "reason", entry.reason, "cases",
                entry.cases);
}

/// True for a date as build_provenance() writes it: 2026-11-30T07:02:31Z.
bool is_date(const std::string& text) {
  std::istringstream stream(text);
  std::tm date{};
  stream >> std::get_time(&date, "%Y-%m-%dT%H:%M:%SZ");
  return !stream.fail() && stream.peek() == std::istringstream::traits_type::eof() &&
         text.size() == std::string_view("2026-11-30T07:02:31Z").size();
}

gate::Approval approval_from(const Json& json) {
  gate::Approval entry{.date = json.at("date"),
                       .commit = json.at("commit"),
                       .reason = json.at("reason"),
                       .cases = json.at("cases")};
  if (!is_date(entry.date)) {
    throw std::runtime_error("has an approval of \"" + entry.date +
                             "\", which is no date as 2026-11-30T07:02:31Z");
  }
  if (entry.reason.find_first_not_of(" \t\n") == std::string::npos || entry.cases.empty()) {
    throw std::runtime_error("has an approval without a reason or a case");
  }
  return entry;
}

/// Throws std::runtime_error if the cases of a baseline are not those of its approvals.
void check_ledger(const gate::Baseline& baseline) {
  const auto require = [](bool holds, const std::string& what) {
    if (!holds) { throw std::runtime_error(what); }
  };
  require(!baseline.ledger.empty(), "has no approval");
  std::set<std::string> approved;
  bool commit_known = false;
  const std::string commit = entry(baseline.provenance, "commit");
  for (const gate::Approval& each : baseline.ledger) {
    approved.insert(each.cases.begin(), each.cases.end());
    commit_known = commit_known || each.commit == commit;
  }
  require(commit_known, "has the commit " + commit + ", which no approval has");
  for (const gate::AcceptedCase& one : baseline.cases) {
    require(approved.contains(one.outcome.name),
            "has the case " + one.outcome.name + ", which no approval names");
  }
  for (const std::string& name : baseline.ledger.back().cases) {
    require(baseline.find(name) != nullptr, "lacks the case " + name + ", the last approved");
  }
}

/// Throws std::runtime_error if a case has two quantities or figures of one name, or was skipped
/// and judged.
void check_names(const Outcome& outcome) {
  std::set<std::string> names;
  for (const Quantity& each : outcome.quantities) {
    if (names.insert(each.name).second) { continue; }
    throw std::runtime_error("has \"" + each.name + "\" of " + outcome.name + " twice");
  }
  for (const Figure& each : outcome.figures) {
    if (names.insert("figure " + each.id).second) { continue; }
    throw std::runtime_error("has the figure " + each.id + " of " + outcome.name + " twice");
  }
  if (outcome.status == Status::skip && !outcome.quantities.empty()) {
    throw std::runtime_error("has quantities of " + outcome.name + ", which was skipped");
  }
}

Json accepted_json(const gate::AcceptedCase& accepted) {
  Json json = case_json(accepted.outcome);
  for (const char* key : {"seconds", "traces", "notes", "timings"}) { json.erase(key); }
  if (accepted.outcome.tables.empty()) { json.erase("tables"); }
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
  for (const char* key : {"notes", "timings"}) { json[key] = Json::array(); }
  if (!json.contains("tables")) { json["tables"] = Json::array(); }
  gate::AcceptedCase accepted{.outcome = case_from_json(json),
                              .spread = spread_from(json.at("spread"))};
  check_names(accepted.outcome);
  // A baseline does not keep quantities of time, by which a case may have been judged.
  if (std::ranges::any_of(accepted.outcome.quantities, &Quantity::judged)) {
    check_verdict(accepted.outcome);
  }
  return accepted;
}

gate::Baseline baseline_from(const Json& json) {
  if (json.value("kind", "") != "palpate baseline") { throw std::runtime_error("is no baseline"); }
  const Json& version = json.at("schema");
  if (version != baseline_schema) {
    throw std::runtime_error("is of schema " + version.dump() + ", this version reads schema " +
                             std::to_string(baseline_schema) +
                             "; remove it and approve the results again");
  }
  if (json.value(seal_key, "") != seal_of(json)) {
    throw std::runtime_error("was changed by something else than palpate approve");
  }
  gate::Baseline baseline{.command = json.at("command")};
  baseline.provenance = json.at("provenance").get<std::map<std::string, std::string>>();
  for (const Json& each : json.at("ledger")) { baseline.ledger.push_back(approval_from(each)); }
  for (const Json& each : json.at("cases")) {
    gate::AcceptedCase accepted = accepted_from(each);
    if (baseline.find(accepted.outcome.name) != nullptr) {
      throw std::runtime_error("case " + accepted.outcome.name + " is twice in it");
    }
    baseline.cases.push_back(std::move(accepted));
  }
  if (baseline.cases.empty()) { throw std::runtime_error("holds no case"); }
  check_ledger(baseline);
  return baseline;
}

std::string group_of(const gate::AcceptedCase& accepted) { return "/" + accepted.outcome.name; }

namespace fs = std::filesystem;

/// Name of the curves of a baseline, b.HASH.h5 for b.json: with 48 bits of their hash, so that it
/// is not that of any other file. Another ending stays in the name: b.txt and b.json differ.
fs::path curves_of_baseline(const fs::path& path, const std::string& hash) {
  constexpr std::size_t digits = 12;
  const fs::path name = path.extension() == ".json" ? path.stem() : path.filename();
  return path.parent_path() / (name.string() + "." + hash.substr(0, digits) + ".h5");
}

/// Writes the content of a file or folder to the disk, so that a later rename is not before it.
void sync(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool kept = descriptor >= 0 && fsync(descriptor) == 0;
  const int problem = errno;
  if (descriptor >= 0) { close(descriptor); }
  if (!kept && problem != EINVAL) {  // a file system without it
    io::refuse_file(path, std::string("cannot be written: ") + std::strerror(problem));
  }
}

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
  return gate::accept({}, {.command = "sample",
                           .date = "2026-01-01T00:00:00Z",
                           .reason = "sample",
                           .outcomes = {sample(height)}});
}

/// File with the curves of b.json.
fs::path curves_in(const io::ScratchFolder& scratch) {
  return read_baseline(scratch / "b.json").curves;
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
  const auto resealed = [](const Folder& s, const std::function<void(Json&)>& change) {
    Json json = parse_json(io::read_text(s / "b.json", 1U << 24U));
    change(json);
    json[seal_key] = seal_of(json);
    io::replace_file(s / "b.json", json_text(json));
  };
  const char* results = "results/results.json";
  return {
      {"the baseline's file is missing", remove("b.json")},
      {"the baseline's file is empty", [](const Folder& s) { fs::resize_file(s / "b.json", 0); }},
      {"the baseline's file is cut short", cut("b.json")},
      {"a line of the baseline is garbled", edit("b.json", "\"ledger\": [", "\"ledger\": ")},
      {"a number of the baseline was edited", edit("b.json", "\"value\": 3.0", "\"value\": 4.0")},
      {"a unit of the baseline was edited", edit("b.json", "\"unit\": \"1\"", "\"unit\": \"m\"")},
      {"a number of the baseline was edited, and sealed by the hash of an older version",
       [](const Folder& s) {
         Json json = parse_json(io::read_text(s / "b.json", 1U << 24U));
         json["cases"][0]["quantities"][0]["value"] = 4.0;
         json.erase(seal_key);
         json[seal_key] = io::content_hash(json_text(json));
         io::replace_file(s / "b.json", json_text(json));
       }},
      {"a case of the baseline is there twice, with a seal",
       [resealed](const Folder& s) {
         resealed(s, [](Json& json) { json["cases"].push_back(json["cases"][0]); });
       }},
      {"a spread of the baseline is negative, with a seal",
       [resealed](const Folder& s) {
         resealed(s, [](Json& json) {
           json["cases"][0]["spread"] =
               object("runs", 1, "quantities", object("height", -1.0), "curves", Json::object());
         });
       }},
      {"the baseline's curves are missing", [](const Folder& s) { fs::remove(curves_in(s)); }},
      {"the baseline's curves have another name",
       [](const Folder& s) { fs::rename(curves_in(s), s / "c.h5"); }},
      {"the baseline's curves are cut short",
       [](const Folder& s) { fs::resize_file(curves_in(s), fs::file_size(curves_in(s)) / 2); }},
      {"the baseline is another one by its name",
       [](const Folder& s) {
         write_baseline(s / "other.json", baseline_of(5.0));
         fs::rename(s / "other.json", s / "b.json");
       }},
      {"the curves belong to another baseline",
       [](const Folder& s) {
         write_baseline(s / "other.json", baseline_of(5.0));
         fs::rename(read_baseline(s / "other.json").curves, curves_in(s));
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

void check_summary(const Json& summary, const Trace& trace) {
  const auto refuse = [](const std::string& key) {
    throw std::runtime_error(key + " is not that of trace.h5 beside it");
  };
  if (summary.at("schema") != 1) {
    throw std::runtime_error("schema = " + summary.at("schema").dump() + "; 1");
  }
  const std::optional<Peaks> peaks = peaks_of(trace);
  const auto check = [&](const char* key, std::optional<double> value) {
    if (!value) { return; }
    const Json found = summary.value(key, Json());
    const bool same = std::isfinite(*value) ? found == *value : !found.is_number();
    if (!same) { refuse(key); }
  };
  const auto of_peaks = [&](double Peaks::*member) {
    return peaks ? std::optional((*peaks).*member) : std::nullopt;
  };
  check("peak_force_n", of_peaks(&Peaks::force));
  check("peak_force_depth_m", of_peaks(&Peaks::force_depth));
  check("deepest_m", of_peaks(&Peaks::deepest));
  check("peak_pressure_pa", peaks ? peaks->pressure : std::nullopt);
  const double smallest = number_from_json(summary.at("smallest_jacobian"));
  const Column* corners = trace.find("tissue.smallest_jacobian");
  if (corners != nullptr && smallest > std::ranges::min(corners->values)) {
    refuse("smallest_jacobian");
  }
  const auto& frames = trace.frames.position;
  if (!frames.empty() && summary.at("nodes") != frames.front().cols()) { refuse("nodes"); }
  const Json events = list_of(trace.events, [](const Event& each) {
    return object("time_s", each.time, "kind", each.kind, "detail", each.detail);
  });
  if (nlohmann::json(summary.at("events")) != nlohmann::json(events)) { refuse("events"); }
  const Json& energy = summary.at("energy");
  for (const char* key : {"initial_j", "final_j"}) {
    if (number_from_json(energy.at(key)) > number_from_json(energy.at("max_j"))) {
      throw std::runtime_error(std::string("energy.") + key + " is more than energy.max_j");
    }
  }
  if (summary.at("status") != "ok") { return; }
  if (!summary.contains("subject") &&
      summary.at("steps") !=
          number_from_json(summary.at("ticks")) * number_from_json(summary.at("substeps"))) {
    throw std::runtime_error("steps are not ticks times substeps");
  }
  if (smallest <= 0.0) {
    throw std::runtime_error(
        "status is ok, but smallest_jacobian says that cells turned inside out");
  }
  for (const char* key : {"diverged_at_s", "unreliable_because"}) {
    if (summary.contains(key) && !summary.at(key).is_null()) {
      throw std::runtime_error(std::string("status is ok, but it has ") + key);
    }
  }
  const Json step = summary.value("integrator_step_s", Json());
  if (!step.is_number() || trace.time.size() < 2) { return; }
  // The last row is that of the last tick, or of one before it where not every tick is kept.
  const double end = number_from_json(summary.at("steps")) * number_from_json(step);
  const double last = trace.time.back();
  const double apart = last - trace.time[trace.time.size() - 2];
  constexpr double rounding = 1e-6;
  if (!(last <= end * (1.0 + rounding) && end - last <= apart + rounding * end)) {
    refuse("the time of its steps");
  }
}

bool is_run_folder(const std::filesystem::path& folder) {
  return std::filesystem::exists(folder / "summary.json") &&
         !std::filesystem::exists(folder / "results.json");
}

std::map<std::string, std::string> inputs_of_run(const std::filesystem::path& folder) {
  return attributes_of(folder / "trace.h5", {"scene", "overrides", "scene_file", "script", "inputs",
                                             "simulator_files", "no_skip", "every"});
}

std::vector<std::pair<fs::path, std::string>> files_of_run(
    const std::map<std::string, std::string>& inputs) {
  const fs::path scene = entry(inputs, "scene_file");
  std::vector<std::pair<fs::path, std::string>> files{{scene, io::sha256(entry(inputs, "scene"))}};
  for (const char* key : {"inputs", "simulator_files"}) {
    for (const std::string& line : lines_of(entry(inputs, key))) {
      const std::size_t space = std::min(line.rfind(' '), line.size());
      const std::string name = line.substr(0, space);
      const fs::path file =
          name == "--script" ? fs::path(entry(inputs, "script")) : scene.parent_path() / name;
      files.emplace_back(file, line.substr(std::min(space + 1, line.size())));
    }
  }
  return files;
}

std::string changed_file(const std::vector<std::pair<fs::path, std::string>>& files) {
  for (const auto& [file, hash] : files) {
    try {
      if (io::sha256_of_file(file) == hash) { continue; }
    } catch (const InputError&) {}
    return file.string();
  }
  return {};
}

std::optional<Peaks> peaks_of(const Trace& trace) {
  const Column* force = trace.find("tool.force_n");
  if (force == nullptr || force->values.empty()) { return {}; }
  const auto peak = std::ranges::max_element(force->values);
  const auto row = static_cast<std::size_t>(peak - force->values.begin());
  const std::vector<double>& place = trace.values("tool.insertion_m");
  Peaks peaks{.force = *peak, .force_depth = place[row], .deepest = std::ranges::max(place)};
  if (const Column* pressure = trace.find("syringe.pressure_pa")) {
    peaks.pressure = std::ranges::max(pressure->values);
  }
  return peaks;
}

Results read_run_folder(const std::filesystem::path& folder) {
  constexpr std::size_t most_summary_bytes = 1U << 24U;
  const std::filesystem::path file = folder / "summary.json";
  const std::string text = io::read_text(file, most_summary_bytes);
  const Trace trace = io::read_trace_hdf5(folder / "trace.h5");
  Attributes provenance = attributes_of(
      folder / "trace.h5", {"version", "commit", "compiler", "flags", "processor", "date"});
  try {
    const Json summary = parse_sealed(text);
    if (summary.at("trace_sha256") != io::sha256_of_file(folder / "trace.h5")) {
      throw std::runtime_error("is not of the same run as trace.h5 beside it");
    }
    check_summary(summary, trace);
    std::optional<Figure> map;
    if (summary.contains("palpation_sha256")) {
      const std::filesystem::path of_map = folder / "palpation.csv";
      if (summary.at("palpation_sha256") != io::sha256_of_file(of_map)) {
        throw std::runtime_error("is not of the same run as palpation.csv beside it");
      }
      map = palpation_figure(of_map);
    }
    if (const Json subject = summary.value("subject", Json()); !subject.is_null()) {
      provenance["subject"] =
          subject.at("name").get<std::string>() + " " + subject.at("version").get<std::string>();
    }
    Outcome outcome = outcome_of(summary, trace, inputs_of_run(folder));
    if (map) { outcome.figures.push_back(std::move(*map)); }
    return {.title = summary.at("title"),
            .command = "palpate run",
            .provenance = std::move(provenance),
            .outcomes = {std::move(outcome)}};
  } catch (const std::exception& problem) {
    throw json_trouble(file.string(), text, problem, "summary.json as palpate wrote it");
  }
}

std::vector<std::string> files_of_results() {
  return {"results.json", "results.xml", "report.html", "traces/"};
}

void write_results_folder(const std::filesystem::path& folder, const Results& results) {
  const io::WholeWrite whole;
  const std::filesystem::path traces = folder / "traces";
  std::error_code problem;
  std::filesystem::create_directories(traces, problem);
  if (problem) {
    throw InputError(traces.string() + ": cannot be created: " + problem.message() +
                     "; a folder that can be written is needed");
  }
  // An interruption leaves no older results.json beside newer traces.
  fs::remove(folder / "results.json", problem);
  for (const Outcome& outcome : results.outcomes) { write_figure_data(traces, outcome); }
  io::replace_file(folder / "results.json", to_json(results));
  io::replace_file(folder / "results.xml", to_junit(results));
  io::replace_file(folder / "report.html", to_html(results));
}

Results read_results_folder(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "results.json";
  if (fs::exists(folder) && !fs::exists(file)) {
    throw InputError(folder.string() +
                     (fs::is_directory(folder) ? ": has no results.json"
                                               : ": is not a folder with results.json") +
                     "; a results folder of validate, bench, merge or subject");
  }
  Results results = results_from_json(io::read_text(file, most_json_bytes), file.string());
  for (Outcome& outcome : results.outcomes) { read_figure_data(folder / "traces", outcome); }
  return results;
}

namespace {

/// Returns the file that a symbolic link names: a baseline and its curves are in one folder.
fs::path target_of(const fs::path& path) {
  return fs::is_symlink(path) ? fs::weakly_canonical(path) : path;
}

}  // namespace

void write_baseline(const fs::path& given, const gate::Baseline& baseline) {
  const fs::path path = target_of(given);
  if (path.extension() == ".h5") {
    throw InputError(path.string() + ": is a name of curves; a name with another ending, as .json");
  }
  for (const gate::AcceptedCase& accepted : baseline.cases) {
    try {
      check_names(accepted.outcome);
    } catch (const std::runtime_error& problem) {
      throw InputError(std::string("results.json: ") + problem.what() +
                       "; results as palpate wrote them");
    }
  }
  const io::WholeWrite whole;
  const fs::path temporary = io::temporary_name(path);
  fs::path curves;
  try {
    io::Hdf5File file = io::Hdf5File::create(temporary);
    for (const gate::AcceptedCase& accepted : baseline.cases) {
      write_figures(file, group_of(accepted), accepted.outcome.figures);
    }
    file.commit();
    sync(temporary);
    const std::string hash = io::sha256(io::read_bytes(temporary, most_bytes));
    curves = curves_of_baseline(path, hash);
    fs::rename(temporary, curves);
    io::replace_file(temporary, json_text(to_json(baseline, hash)));
    sync(temporary);
    sync(path.has_parent_path() ? path.parent_path() : ".");
    fs::rename(temporary, path);
  } catch (...) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    if (!curves.empty() && curves != baseline.curves) { fs::remove(curves, ignored); }
    throw;
  }
  std::error_code ignored;
  sync(path.has_parent_path() ? path.parent_path() : ".");
  // A name of another length is that of another version, and may be of another baseline too.
  const bool own = baseline.curves.filename().string().size() == curves.filename().string().size();
  if (own && baseline.curves != curves) { fs::remove(baseline.curves, ignored); }
}

namespace {

gate::Baseline read_baseline_once(const fs::path& path, const std::string& text) {
  gate::Baseline baseline;
  std::string hash;
  try {
    const Json json = parse_json(text);
    baseline = baseline_from(json);
    hash = json.at("curves");
  } catch (const std::exception& problem) {
    throw json_trouble(path.string(), text, problem, "a baseline as palpate approve wrote it");
  }
  baseline.curves = curves_of_baseline(path, hash);
  if (!fs::exists(baseline.curves)) {  // of a version that replaced any ending
    const fs::path before = curves_of_baseline(fs::path(path).replace_extension(".json"), hash);
    if (fs::exists(before)) { baseline.curves = before; }
  }
  const std::string bytes = io::read_bytes(baseline.curves, most_bytes);
  if (hash != io::sha256(bytes)) {
    throw InputError(baseline.curves.string() + ": does not belong to " + path.string() +
                     ", or is damaged; the curves that palpate approve wrote with it");
  }
  const io::Hdf5File file = io::Hdf5File::open(baseline.curves);
  for (gate::AcceptedCase& accepted : baseline.cases) {
    read_figures(file, baseline.curves, group_of(accepted), accepted.outcome.figures);
  }
  return baseline;
}

}  // namespace

gate::Baseline read_baseline(const fs::path& given) {
  const fs::path path = target_of(given);
  if (!fs::exists(path)) {
    throw InputError(path.string() + ": no such file; `palpate approve RESULTS --baseline " +
                     path.string() + " --reason TEXT` writes one");
  }
  for (;;) {
    const std::string text = io::read_text(path, most_json_bytes);
    try {
      return read_baseline_once(path, text);
    } catch (const InputError&) {  // the curves may have been replaced since
      if (io::read_text(path, most_json_bytes) == text) { throw; }
    }
  }
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
