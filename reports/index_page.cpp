// SPDX-License-Identifier: MIT

#include "reports/index_page.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <map>

#include "html_templates.hpp"

#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "model/problem/recording.hpp"
#include "reports/html/html_page.hpp"
#include "reports/html/html_template.hpp"
#include "reports/results/results_json.hpp"
#include "reports/timing/history.hpp"

namespace palpate {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t most_bytes = std::size_t{1} << 28;

/// Name of a result file, the command that writes it, and the values that the index shows.
struct ResultFile {
  const char* name;
  const char* kind;
  std::vector<IndexValue> (*values)(const Json&);
  bool (*held)(const Json&);
};

/// Appends the value of a key in other units, if the key has a number.
void add(std::vector<IndexValue>& values, const Json& json, const char* key, IndexValue as,
         double factor = 1.0) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number()) { return; }
  as.value = factor * found->get<double>();
  values.push_back(std::move(as));
}

std::vector<IndexValue> run_values(const Json& json) {
  std::vector<IndexValue> values;
  add(values, json, "peak_force_n", {.name = "peak force", .unit = "N"});
  add(values, json, "deepest_m", {.name = "depth", .unit = "mm"}, mm);
  add(values, json, "peak_pressure_pa", {.name = "peak pressure", .unit = "mmHg"},
      1.0 / pascals_per_mmhg);
  add(values, json, "smallest_jacobian", {.name = "smallest cell corner", .unit = "1"});
  add(values, json, "slowest_tick_s", {.name = "worst tick", .unit = "ms", .timing = true}, 1e3);
  return values;
}

std::vector<IndexValue> count_values(const Json& json) {
  std::map<std::string, int> counts;
  for (const Json& one : json.at("cases")) { ++counts[one.at("status").get<std::string>()]; }
  std::vector<IndexValue> values;
  for (const char* status : {"pass", "fail", "error", "inconclusive", "skip"}) {
    if (counts[status] > 0 || std::string_view(status) == "fail") {
      values.push_back({.name = status, .value = static_cast<double>(counts[status]), .unit = "1"});
    }
  }
  return values;
}

std::vector<IndexValue> gate_values(const Json& json) {
  std::vector<IndexValue> values;
  for (const char* key : {"identical", "unchanged", "better", "failed"}) {
    add(values, json, key, {.name = key, .unit = "1"});
  }
  return values;
}

std::vector<IndexValue> certificate_values(const Json& json) {
  std::vector<IndexValue> values;
  add(values, json, "ticks", {.name = "ticks", .unit = "1", .timing = true});
  add(values, json, "misses", {.name = "misses", .unit = "1", .timing = true});
  if (json.contains("response_us")) {
    add(values, json["response_us"], "max",
        {.name = "longest response", .unit = "us", .timing = true});
  }
  return values;
}

std::vector<IndexValue> no_values(const Json&) { return {}; }

std::string text_at(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

bool is_ok(const Json& json) { return text_at(json, "status") == "ok"; }
bool is_pass(const Json& json) { return text_at(json, "verdict") == "pass"; }
bool is_certified(const Json& json) { return text_at(json, "verdict") == "certified"; }
bool is_held(const Json& json) { return json.value("held", json.value("holds", false)); }
bool no_case_failed(const Json& json) {
  return std::ranges::none_of(json.at("cases"), [](const Json& one) {
    const std::string status = one.at("status");
    return status != "pass" && status != "skip";
  });
}

constexpr std::array<ResultFile, 6> result_files{{
    {.name = "summary.json", .kind = "run", .values = run_values, .held = is_ok},
    {.name = "results.json", .kind = "validate", .values = count_values, .held = no_case_failed},
    {.name = "gate.json", .kind = "gate", .values = gate_values, .held = is_pass},
    {.name = "certificate.json",
     .kind = "certify",
     .values = certificate_values,
     .held = is_certified},
    {.name = "comparison.json", .kind = "compare", .values = no_values, .held = is_held},
    {.name = "calibration.json", .kind = "calibrate", .values = no_values, .held = is_held},
}};

std::string date_of(fs::file_time_type time) {
  const auto system = std::chrono::time_point_cast<std::chrono::system_clock::duration>(
      std::chrono::file_clock::to_sys(time));
  return utc_text(std::chrono::system_clock::to_time_t(system));
}

Json value_json(const IndexValue& value) {
  return object("name", value.name, "value", value.value, "unit", value.unit, "timing",
                value.timing);
}

IndexLine line_from(const std::string& text) {
  const Json json = parse_json(text);
  IndexLine line{.folder = json.at("folder"),
                 .kind = json.at("kind"),
                 .title = json.at("title"),
                 .verdict = json.at("verdict"),
                 .date = json.at("date"),
                 .command = json.at("command"),
                 .exit_code = whole_from_json<int>(json.at("exit_code"))};
  for (const Json& each : json.at("values")) {
    line.values.push_back(
        {.name = each.at("name"),
         .value = each.at("value").is_number() ? each["value"].get<double>() : std::nan(""),
         .unit = each.at("unit"),
         .timing = each.at("timing")});
  }
  return line;
}

std::string shown(const IndexValue& value, int digits) {
  return plain_number(value.value, digits) + (value.unit == "1" ? "" : " " + value.unit);
}

const IndexValue* value_named(const IndexLine& line, const std::string& name) {
  const auto found = std::ranges::find(line.values, name, &IndexValue::name);
  return found == line.values.end() ? nullptr : &*found;
}

/// Polyline of the last 30 values under the same title; empty if there are fewer than three or they
/// are all equal.
std::string sparkline(const std::vector<IndexLine>& lines, const std::string& name) {
  std::vector<double> values;
  for (const IndexLine& line : lines) {
    const IndexValue* value = line.title == lines.back().title ? value_named(line, name) : nullptr;
    if (value != nullptr && std::isfinite(value->value)) { values.push_back(value->value); }
  }
  constexpr std::size_t most = 30;
  if (values.size() > most) { values.erase(values.begin(), values.end() - most); }
  if (values.size() < 3) { return {}; }
  const auto [least, greatest] = std::ranges::minmax(values);
  if (!(greatest > least)) { return {}; }
  std::string points;
  for (std::size_t n = 0; n < values.size(); ++n) {
    const double x = 2.0 + 76.0 * static_cast<double>(n) / static_cast<double>(values.size() - 1);
    const double y = 14.0 - 12.0 * (values[n] - least) / (greatest - least);
    points += plain_number(x, 4) + "," + plain_number(y, 4) + " ";
  }
  return " <svg class=\"spark\" viewBox=\"0 0 80 16\" width=\"80\" height=\"16\" role=\"img\" "
         "aria-label=\"the last " +
         std::to_string(values.size()) + " runs\"><polyline points=\"" + points +
         "\" fill=\"none\" stroke=\"currentColor\"/></svg>";
}

Status status_of(const IndexLine& line) {
  return line.exit_code == 0 ? Status::pass : line.exit_code == 1 ? Status::fail : Status::skip;
}

/// Lines of one folder, oldest first.
using History = std::vector<IndexLine>;

/// Changes between the last two lines, after the name of the folder; empty without any.
std::string changes_in(const History& history) {
  if (history.size() < 2) { return {}; }
  std::string text;
  for (const std::string& change : changes_between(history[history.size() - 2], history.back())) {
    text += (text.empty() ? history.back().folder + ": " : ", ") + change;
  }
  return text;
}

Data index_row(const History& history) {
  const IndexLine& now = history.back();
  const IndexLine* before = history.size() > 1 ? &history[history.size() - 2] : nullptr;
  const auto value = [&](const IndexValue& each) {
    const IndexValue* was =
        before != nullptr && before->title == now.title ? value_named(*before, each.name) : nullptr;
    const bool changed = was != nullptr && was->value != each.value;
    const int digits = changed ? std::max(4, digits_apart(was->value, each.value)) : 4;
    return record("name", each.name, "value", shown(each, digits), "before",
                  text_or_nothing(changed ? shown(*was, digits) : ""), "spark",
                  sparkline(history, each.name));
  };
  return record("folder", now.folder, "page", now.folder + "/report.html", "colour",
                std::string(name_of(status_of(now))), "badge", now.kind, "title",
                now.title + (now.title.empty() || now.verdict.empty() ? "" : ":"), "verdict",
                text_or_nothing(now.verdict), "has_values", !now.values.empty(), "values",
                data_of(now.values, value), "date", now.date, "runs",
                counted(history.size(), "run", "runs"), "command", text_or_nothing(now.command));
}

}  // namespace

std::vector<std::string> changes_between(const IndexLine& before, const IndexLine& now) {
  std::vector<std::string> changes;
  if (now.verdict != before.verdict) {
    changes.push_back(now.verdict + ", before: " + before.verdict);
  }
  if (now.title != before.title) {
    changes.push_back("another scene or other cases, before: " + before.title);
    return changes;
  }
  for (const IndexValue& value : now.values) {
    const IndexValue* was = value_named(before, value.name);
    if (was == nullptr || value.timing || was->value == value.value) { continue; }
    const int digits = std::max(3, digits_apart(was->value, value.value));
    changes.push_back(value.name + " " + shown(value, digits) + ", before: " + shown(*was, digits));
  }
  return changes;
}

IndexLine index_line_of_run(const std::string& summary) {
  const Json json = parse_json(summary);
  return {.kind = "run",
          .title = text_at(json, "title"),
          .verdict = text_at(json, "status"),
          .exit_code = is_ok(json) ? 0 : 1,
          .values = run_values(json)};
}

IndexLine index_line_of(const fs::path& folder) {
  const ResultFile* newest = nullptr;
  fs::file_time_type time{};
  for (const ResultFile& file : result_files) {
    std::error_code absent;
    const fs::file_time_type written = fs::last_write_time(folder / file.name, absent);
    if (absent || (newest != nullptr && written <= time)) { continue; }
    newest = &file;
    time = written;
  }
  if (newest == nullptr) { return {}; }
  const fs::path file = folder / newest->name;
  const std::string text = io::read_text(file, most_bytes);
  try {
    Json json = parse_json(text);
    if (json.contains("seal")) { json = parse_sealed(text); }
    IndexLine line{.folder = folder.filename().string(),
                   .kind = newest->kind,
                   .title = text_at(json, "title"),
                   .verdict = text_at(json, "verdict"),
                   .date = date_of(time),
                   .command = text_at(json, "command"),
                   .exit_code = newest->held(json) ? 0 : 1,
                   .values = newest->values(json)};
    if (line.verdict.empty()) { line.verdict = text_at(json, "status"); }
    return line;
  } catch (const std::exception& problem) {
    throw json_trouble(file.string(), text, problem, "a file as palpate wrote it");
  }
}

std::vector<IndexLine> read_index(const fs::path& ledger) {
  std::vector<IndexLine> lines;
  timing::for_each_line(
      ledger, [&](const std::string& text) { lines.push_back(line_from(text)); },
      "one result as this program appends them");
  return lines;
}

std::string to_text(const IndexLine& line) {
  return json_text(object("folder", line.folder, "kind", line.kind, "title", line.title, "verdict",
                          line.verdict, "date", line.date, "command", line.command, "exit_code",
                          line.exit_code, "values", list_of(line.values, value_json)),
                   -1);
}

std::string index_html(const std::vector<IndexLine>& lines, const fs::path& parent) {
  std::map<std::string, History> by_folder;
  for (const IndexLine& line : lines) { by_folder[line.folder].push_back(line); }
  std::vector<const History*> folders;
  for (const auto& [folder, history] : by_folder) {
    if (fs::is_directory(parent / folder)) { folders.push_back(&history); }
  }
  std::ranges::stable_sort(folders, std::ranges::greater{},
                           [](const History* history) { return history->back().date; });
  Data rows(Data::type::list);
  Notes changes;
  Status worst = Status::pass;
  for (const History* history : folders) {
    rows.push_back(index_row(*history));
    if (std::string change = changes_in(*history); !change.empty()) {
      changes.items.push_back(std::move(change));
    }
    if (status_of(history->back()) == Status::fail) { worst = Status::fail; }
  }
  const auto failed = std::ranges::count_if(
      folders, [](const History* history) { return status_of(history->back()) == Status::fail; });
  Page page{.banner = {.title = std::string(index_title),
                       .small_print = {parent.string()},
                       .status = worst,
                       .verdict = counted(folders.size(), "result", "results"),
                       .detail = failed == 0 ? "None failed."
                                             : (failed == 1 ? "One" : std::to_string(failed)) +
                                                   " of them failed."}};
  page.parts.emplace_back(Section{
      .heading = "What changed since the run before",
      .parts = {changes.items.empty()
                    ? PagePart(Paragraph{"Nothing, or every result is the first of its folder."})
                    : PagePart(changes)}});
  page.parts.emplace_back(Section{.heading = "Results, newest first",
                                  .parts = {Markup{fill(templates::index, record("rows", rows))}}});
  return render(page);
}

namespace {

void add_line(const IndexLine& line, const fs::path& parent) {
  timing::append_line(parent / "index.jsonl", to_text(line));
}

void write_page(const fs::path& parent) {
  io::replace_file(parent / "index.html", index_html(read_index(parent / "index.jsonl"), parent));
}

}  // namespace

void add_to_index(const fs::path& folder, const std::string& command, int exit_code) {
  IndexLine line = index_line_of(folder);
  if (line.kind.empty()) { return; }
  line.command = command;
  line.exit_code = exit_code;
  const fs::path parent = folder.parent_path().empty() ? fs::path(".") : folder.parent_path();
  add_line(line, parent);
  write_page(parent);
}

std::size_t index_folders_in(const fs::path& parent) {
  const std::vector<IndexLine> known = read_index(parent / "index.jsonl");
  std::vector<IndexLine> found;
  for (const auto& entry : fs::directory_iterator(parent)) {
    if (!entry.is_directory()) { continue; }
    IndexLine line = index_line_of(entry.path());
    if (!line.kind.empty()) { found.push_back(std::move(line)); }
  }
  std::ranges::sort(found, {}, &IndexLine::date);
  for (const IndexLine& line : found) {
    const bool listed = std::ranges::any_of(known, [&](const IndexLine& each) {
      return each.folder == line.folder && each.date == line.date;
    });
    if (!listed) { add_line(line, parent); }
  }
  write_page(parent);
  return found.size();
}

}  // namespace palpate
