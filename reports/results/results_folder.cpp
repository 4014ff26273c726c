// SPDX-License-Identifier: MIT

#include "reports/results/results_folder.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

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

/// Numbers events by kind, so that an additional event does not rename events of other kinds.
void add_events(Outcome& outcome, const Json& events) {
  std::map<std::string, int> met;
  for (const Json& event : events) {
    const auto detail = event.at("detail").get<std::string>();
    const std::string kind =
        event.at("kind").get<std::string>() + (detail.empty() ? "" : " " + detail);
    const int count = ++met[kind];
    add_number(outcome, "event: " + kind + (count > 1 ? " #" + std::to_string(count) : ""),
               event.at("time_s"), "s");
  }
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
  add_events(outcome, summary.at("events"));
  for (const Column& column : trace.columns) {
    outcome.figures.push_back(column_figure(trace, column));
  }
  if (trace.frames.position.size() > 1) { outcome.figures.push_back(node_figure(trace)); }
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
  constexpr std::size_t most_bytes = 1U << 30U;
  const std::filesystem::path file = folder / "results.json";
  Results results = results_from_json(io::read_text(file, most_bytes), file.string());
  for (Outcome& outcome : results.outcomes) { read_figure_data(folder / "traces", outcome); }
  return results;
}

}  // namespace palpate
