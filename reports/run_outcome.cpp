// SPDX-License-Identifier: MIT
#include "reports/run_outcome.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>

#include "fixtures/io/content_hash.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/hdf5_file.hpp"
#include "fixtures/io/trace_file.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/case_json.hpp"
#include "reports/json_trouble.hpp"
#include "validation/number_words.hpp"

namespace palpate {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_frames = 60;
constexpr std::size_t most_numbers = 2'000'000;  ///< of all frames together

void add_fact(Outcome& outcome, const Json& summary, const std::string& key) {
  outcome.quantities.push_back({.name = key, .value = number_from_json(summary.at(key))});
}

void add_energy(Outcome& outcome, const Json& energy, const std::string& key) {
  outcome.quantities.push_back({.name = "energy." + key, .value = number_from_json(energy.at(key)), .unit = "J"});
}

/// Numbered by kind, so that one more of a kind does not rename the others.
void add_events(Outcome& outcome, const Json& events) {
  std::map<std::string, int> met;
  for (const Json& event : events) {
    const auto detail = event.at("detail").get<std::string>();
    const std::string kind = event.at("kind").get<std::string>() + (detail.empty() ? "" : " " + detail);
    const int count = ++met[kind];
    outcome.quantities.push_back({.name = "event: " + kind + (count > 1 ? " #" + std::to_string(count) : ""),
                                  .value = number_from_json(event.at("time_s")),
                                  .unit = "s"});
  }
}

/// "tool.force_n" as "tool-force-n".
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

/// How far the nodes are from where they began, one coordinate after the other, so that no norm hides one of
/// them.
Series moved_by(const Trace& trace, std::size_t frame) {
  const NodeVectors moved = trace.frames[frame] - trace.frames.front();
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
  const auto numbers = static_cast<std::size_t>(trace.frames.front().size());
  const std::size_t kept = std::clamp<std::size_t>(most_numbers / numbers, 1, most_frames);
  const std::size_t stride = (trace.frames.size() - 1 + kept - 1) / kept;
  for (std::size_t n = stride; n < trace.frames.size(); n += stride) { figure.series.push_back(moved_by(trace, n)); }
  return figure;
}

/// What no run that may be accepted holds; empty: nothing.
std::string not_finite(const Outcome& outcome) {
  for (const Figure& figure : outcome.figures) {
    for (const Series& series : figure.series) {
      const auto found = std::ranges::find_if_not(series.y, [](double y) { return std::isfinite(y); });
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
    outcome.reason = "the run " + status;
  }
  for (const char* key : {"nodes", "springs", "ticks", "steps", "substeps"}) { add_fact(outcome, summary, key); }
  for (const char* key : {"initial_j", "final_j", "max_j"}) { add_energy(outcome, summary.at("energy"), key); }
  add_events(outcome, summary.at("events"));
  for (const Column& column : trace.columns) { outcome.figures.push_back(column_figure(trace, column)); }
  if (trace.frames.size() > 1) { outcome.figures.push_back(node_figure(trace)); }
  if (std::string problem = not_finite(outcome); !problem.empty() && outcome.status == Status::pass) {
    outcome.status = Status::error;
    outcome.reason = std::move(problem);
  }
  return outcome;
}

/// Text attributes of the root group.
std::map<std::string, std::string> provenance_of(const std::filesystem::path& trace) {
  const io::Hdf5File file = io::Hdf5File::open(trace);
  std::map<std::string, std::string> provenance;
  for (const char* key : {"version", "commit", "compiler", "flags", "processor", "date", "scene", "overrides"}) {
    if (file.has_attribute("/", key)) { provenance[key] = file.text_attribute("/", key); }
  }
  return provenance;
}

/// What was simulated: another text is another scene, and a baseline of the old one is stale.
std::string scene_named(const std::string& title, std::map<std::string, std::string> provenance) {
  return title + ", scene " + io::content_hash(provenance["scene"] + provenance["overrides"]);
}

}  // namespace

bool is_run_folder(const std::filesystem::path& folder) {
  return std::filesystem::exists(folder / "summary.json") && !std::filesystem::exists(folder / "results.json");
}

Results read_run_folder(const std::filesystem::path& folder) {
  constexpr std::size_t most_bytes = 1U << 24U;
  const std::filesystem::path file = folder / "summary.json";
  const std::string text = io::read_text(file, most_bytes);
  const Trace trace = io::read_trace_hdf5(folder / "trace.h5");
  std::map<std::string, std::string> provenance = provenance_of(folder / "trace.h5");
  try {
    const Json summary = Json::parse(text);
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

}  // namespace palpate
