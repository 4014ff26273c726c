// SPDX-License-Identifier: MIT

#include "reports/results/results_json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>

#include "model/problem/input_error.hpp"
#include "reports/results/results_folder.hpp"

namespace palpate {

InputError json_trouble(const std::string& file, const std::string& text,
                        const std::exception& problem, const std::string& allowed) {
  if (const auto* broken = dynamic_cast<const nlohmann::json::parse_error*>(&problem)) {
    const auto end =
        text.begin() + static_cast<std::ptrdiff_t>(std::min(broken->byte, text.size()));
    const auto line = 1 + std::count(text.begin(), end, '\n');
    const char* found = broken->byte > text.size() ? ": ends in the middle of its JSON; "
                                                   : ": not JSON from here on; ";
    return InputError(file + ":" + std::to_string(line) + found + allowed);
  }
  std::string what = problem.what();
  // Removes the name of the library and its error number from the message.
  if (dynamic_cast<const nlohmann::json::exception*>(&problem) != nullptr) {
    what.erase(0, what.find("] ") + 2);
  }
  return InputError(file + ": " + what + "; " + allowed);
}

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 6> style_names{"line",   "points", "line-and-points",
                                                      "dashed", "band",   "area"};

/// Writes a bound; an open bound is null.
Json bound(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

double bound_from(const Json& json, double open) {
  return json.is_null() ? open : number_from_json(json);
}

/// Writes a quantity. The uncertainty is omitted if it is zero.
Json to_json(const Quantity& q) {
  Json json{{"name", q.name},          {"value", json_number(q.value)},
            {"unit", q.unit},          {"lower", bound(q.lower)},
            {"upper", bound(q.upper)}, {"bound_from", q.bound_from}};
  if (q.uncertainty > 0.0) { json["uncertainty"] = json_number(q.uncertainty); }
  json["status"] = q.judged() ? name_of(q.status()) : "info";
  return json;
}

Quantity quantity_from(const Json& json) {
  return {
      .name = json.at("name"),
      .value = number_from_json(json.at("value")),
      .unit = json.at("unit"),
      .lower = bound_from(json.at("lower"), -unbounded),
      .upper = bound_from(json.at("upper"), unbounded),
      .bound_from = json.at("bound_from"),
      .uncertainty = json.contains("uncertainty") ? number_from_json(json.at("uncertainty")) : 0.0};
}

/// Splits the JSON text of all reasons, which has one reason per line.
std::vector<std::string> reasons_from(const std::string& text) {
  std::vector<std::string> reasons;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) { reasons.push_back(line); }
  return reasons;
}

Json to_json(const Axis& axis) {
  Json json{{"label", axis.label}, {"logarithmic", axis.logarithmic}};
  json["minimum"] = axis.minimum ? Json(*axis.minimum) : Json(nullptr);
  json["maximum"] = axis.maximum ? Json(*axis.maximum) : Json(nullptr);
  return json;
}

Axis axis_from(const Json& json) {
  Axis axis{.label = json.at("label"), .logarithmic = json.at("logarithmic")};
  if (!json.at("minimum").is_null()) { axis.minimum = json.at("minimum").get<double>(); }
  if (!json.at("maximum").is_null()) { axis.maximum = json.at("maximum").get<double>(); }
  return axis;
}

Json zones_of(const Figure& figure) {
  Json list = Json::array();
  for (const Zone& zone : figure.zones) {
    list.push_back({{"label", zone.label},
                    {"begin", json_number(zone.begin)},
                    {"end", json_number(zone.end)}});
  }
  return list;
}

Json marks_of(const Figure& figure) {
  Json list = Json::array();
  for (const Mark& mark : figure.marks) {
    list.push_back({{"label", mark.label}, {"x", json_number(mark.x)}});
  }
  return list;
}

/// Reads optional zones and marks, which old files do not contain.
void read_annotations(const Json& json, Figure& figure) {
  const Json none = Json::array();
  for (const Json& each : json.value("zones", none)) {
    figure.zones.push_back(
        {each.at("label"), number_from_json(each.at("begin")), number_from_json(each.at("end"))});
  }
  for (const Json& each : json.value("marks", none)) {
    figure.marks.push_back({each.at("label"), number_from_json(each.at("x"))});
  }
}

Json to_json(const Figure& figure) {
  Json series = Json::array();
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    const Series& each = figure.series[n];
    series.push_back({{"label", each.label},
                      {"style", style_names.at(static_cast<std::size_t>(each.style))},
                      {"group", series_group(figure, n)}});
  }
  Json json{{"id", figure.id},         {"title", figure.title},  {"caption", figure.caption},
            {"x", to_json(figure.x)},  {"y", to_json(figure.y)}, {"square", figure.square},
            {"timing", figure.timing}, {"series", series}};
  if (!figure.zones.empty()) { json["zones"] = zones_of(figure); }
  if (!figure.marks.empty()) { json["marks"] = marks_of(figure); }
  json["heat_map"] = Json(nullptr);
  if (figure.heat_map) {
    json["heat_map"] = {{"label", figure.heat_map->label}, {"group", heat_map_group(figure)}};
  }
  return json;
}

Figure figure_from(const Json& json) {
  Figure figure{.id = json.at("id"),
                .title = json.at("title"),
                .caption = json.at("caption"),
                .x = axis_from(json.at("x")),
                .y = axis_from(json.at("y"))};
  figure.square = json.at("square");
  figure.timing = json.at("timing");
  for (const Json& each : json.at("series")) {
    Series series{.label = each.at("label")};
    const auto style = each.at("style").get<std::string>();
    const auto* found = std::find(style_names.begin(), style_names.end(), style);
    if (found == style_names.end()) { throw std::runtime_error("unknown series style " + style); }
    series.style = static_cast<Series::Style>(found - style_names.begin());
    figure.series.push_back(std::move(series));
  }
  read_annotations(json, figure);
  if (!json.at("heat_map").is_null()) {
    figure.heat_map = HeatMap{.label = json.at("heat_map").at("label").get<std::string>()};
  }
  return figure;
}

Json to_json(const Table& table) {
  Json rows = Json::array();
  for (const auto& row : table.rows) {
    Json cells = Json::array();
    for (const Cell& cell : row) {
      const auto* text = std::get_if<std::string>(&cell);
      cells.push_back(text != nullptr ? Json(*text)
                                      : Json{{"value", json_number(std::get<double>(cell))}});
    }
    rows.push_back(std::move(cells));
  }
  return {{"id", table.id},           {"title", table.title},   {"caption", table.caption},
          {"columns", table.columns}, {"timing", table.timing}, {"rows", rows}};
}

Table table_from(const Json& json) {
  Table table{.id = json.at("id"),
              .title = json.at("title"),
              .caption = json.at("caption"),
              .columns = json.at("columns").get<std::vector<std::string>>()};
  table.timing = json.at("timing");
  for (const Json& row : json.at("rows")) {
    std::vector<Cell> cells;
    for (const Json& cell : row) {
      cells.push_back(cell.is_string() ? Cell(cell.get<std::string>())
                                       : Cell(number_from_json(cell.at("value"))));
    }
    table.rows.push_back(std::move(cells));
  }
  return table;
}

template <class Item> Json list_of(const std::vector<Item>& items) {
  Json list = Json::array();
  for (const Item& item : items) { list.push_back(to_json(item)); }
  return list;
}

Status status_from(const std::string& name) {
  for (const Status status :
       {Status::pass, Status::fail, Status::inconclusive, Status::skip, Status::error}) {
    if (name_of(status) == name) { return status; }
  }
  throw std::runtime_error("unknown status " + name);
}

}  // namespace

double number_from_json(const Json& json) {
  if (json.is_number()) { return json.get<double>(); }
  const auto text = json.get<std::string>();
  if (text == "nan") { return std::nan(""); }
  if (text == "inf") { return unbounded; }
  if (text == "-inf") { return -unbounded; }
  throw std::runtime_error("\"" + text + "\" is no number");
}

nlohmann::ordered_json case_json(const Outcome& outcome) {
  Json timings = Json::array();
  for (const Timing& timing : outcome.timings) {
    timings.push_back(
        {{"name", timing.name}, {"value", json_number(timing.value)}, {"unit", timing.unit}});
  }
  const bool skipped = outcome.status == Status::skip;
  Json json{{"name", outcome.name},
            {"suite", outcome.suite},
            {"claim", outcome.claim},
            {"status", name_of(outcome.status)}};
  json["skipped"] = skipped ? Json(outcome.reason()) : Json(nullptr);
  json["message"] = skipped ? "" : outcome.reason();
  json["seconds"] = outcome.seconds;
  json["quantities"] = list_of(outcome.quantities);
  json["tables"] = list_of(outcome.tables);
  json["traces"] =
      outcome.figures.empty() ? Json(nullptr) : Json("traces/" + trace_file_name(outcome.name));
  json["figures"] = list_of(outcome.figures);
  json["notes"] = outcome.notes;
  json["timings"] = timings;
  return json;
}

nlohmann::ordered_json cases_json(const std::vector<Outcome>& outcomes) {
  Json list = Json::array();
  for (const Outcome& outcome : outcomes) { list.push_back(case_json(outcome)); }
  return list;
}

Outcome case_from_json(const Json& json) {
  Outcome outcome{
      .name = json.at("name"),
      .suite = json.at("suite"),
      .claim = json.at("claim"),
      .status = status_from(json.at("status")),
      .reasons = reasons_from(json.at(json.at("skipped").is_null() ? "message" : "skipped")),
      .seconds = json.at("seconds")};
  for (const Json& each : json.at("quantities")) {
    outcome.quantities.push_back(quantity_from(each));
  }
  for (const Json& each : json.at("tables")) { outcome.tables.push_back(table_from(each)); }
  for (const Json& each : json.at("figures")) { outcome.figures.push_back(figure_from(each)); }
  outcome.notes = json.at("notes").get<std::vector<std::string>>();
  for (const Json& each : json.at("timings")) {
    outcome.timings.push_back(
        {each.at("name"), number_from_json(each.at("value")), each.at("unit")});
  }
  return outcome;
}

namespace {

using Json = nlohmann::ordered_json;

constexpr int schema = 1;

/// Rejects a pass that contradicts its own numbers; this program does not write such a case.
void check_verdict(const Outcome& outcome) {
  Outcome again = outcome;
  conclude(again);
  if (again.status == outcome.status || outcome.status != Status::pass) { return; }
  throw std::runtime_error("case " + outcome.name + " says pass, but its quantities do not");
}

}  // namespace

std::string to_json(const Results& results) {
  Json json{{"schema", schema},
            {"title", results.title},
            {"command", results.command},
            {"provenance", results.provenance},
            {"cases", cases_json(results.outcomes)}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Results results_from_json(const std::string& text, const std::string& name) {
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != schema) {
      throw std::runtime_error("schema " + json.at("schema").dump() + "; this version reads 1");
    }
    Results results{.title = json.at("title"), .command = json.at("command")};
    results.provenance = json.at("provenance").get<std::map<std::string, std::string>>();
    std::set<std::string> names;
    for (const Json& each : json.at("cases")) {
      results.outcomes.push_back(case_from_json(each));
      const Outcome& outcome = results.outcomes.back();
      check_verdict(outcome);
      if (!names.insert(outcome.name).second) {
        throw std::runtime_error("case " + outcome.name + " is twice in it");
      }
    }
    return results;
  } catch (const std::exception& problem) {
    throw json_trouble(name, text, problem, "results.json as palpate wrote it");
  }
}

}  // namespace palpate
