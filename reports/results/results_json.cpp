// SPDX-License-Identifier: MIT

#include "reports/results/results_json.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "html_templates.hpp"

#include "fixtures/io/file_bytes.hpp"
#include "reports/html/html_template.hpp"
#include "reports/results/results_folder.hpp"
#include "validation/number_text.hpp"

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

constexpr int deepest = 32;  // results have seven levels

/// An exception of the library, so that a handler of its exceptions handles this one too.
class RefusedJson : public nlohmann::json::exception {
 public:
  explicit RefusedJson(const std::string& why) : exception(0, ("[refused] " + why).c_str()) {}
};

}  // namespace

nlohmann::ordered_json parse_json(std::string_view text) {
  using Json = nlohmann::ordered_json;
  int depth = 0;
  bool in_text = false;
  for (std::size_t n = 0; n < text.size(); ++n) {
    const char c = text[n];
    if (in_text && c == '\\') { ++n; }
    if (c == '"') { in_text = !in_text; }
    if (in_text) { continue; }
    if (c == '[' || c == '{') { ++depth; }
    if (c == ']' || c == '}') { --depth; }
    if (depth > deepest) {
      throw RefusedJson("more than " + std::to_string(deepest) + " brackets within each other");
    }
  }
  std::vector<std::set<std::string>> keys;  // of the open objects
  const auto refuse_twins = [&keys](int, Json::parse_event_t event, const Json& parsed) {
    if (event == Json::parse_event_t::object_start) { keys.emplace_back(); }
    if (event == Json::parse_event_t::object_end) { keys.pop_back(); }
    if (event == Json::parse_event_t::key &&
        !keys.back().insert(parsed.get<std::string>()).second) {
      throw RefusedJson("key " + parsed.dump() + " is twice in one object");
    }
    return true;
  };
  return nlohmann::ordered_json::parse(text, refuse_twins);
}

Results without_what_varies(Results results) {
  results.provenance.clear();
  for (Outcome& outcome : results.outcomes) {
    outcome.seconds = 0.0;
    outcome.timings.clear();
    std::erase_if(outcome.tables, [](const Table& table) { return table.timing; });
    std::erase_if(outcome.figures, [](const Figure& figure) { return figure.timing; });
  }
  return results;
}

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 7> style_names{
    "line", "points", "line-and-points", "dashed", "band", "area", "thin"};

double limit_from(const Json& json, double open) {
  return json.is_null() ? open : number_from_json(json);
}

std::string status_of(const Quantity& q) {
  return std::string(q.judged() ? name_of(q.status()) : "info");
}

/// Writes a quantity. The uncertainty is omitted if it is zero.
Json quantity_json(const Quantity& q) {
  Json json =
      object("name", q.name, "value", q.value, "unit", q.unit, "lower", finite_or_null(q.lower),
             "upper", finite_or_null(q.upper), "bound_from", q.bound_from);
  if (q.uncertainty > 0.0) { json["uncertainty"] = json_number(q.uncertainty); }
  json["status"] = status_of(q);
  return json;
}

Quantity quantity_from(const Json& json) {
  Quantity q{.name = json.at("name"),
             .value = number_from_json(json.at("value")),
             .unit = json.at("unit"),
             .lower = limit_from(json.at("lower"), -unbounded),
             .upper = limit_from(json.at("upper"), unbounded),
             .bound_from = json.at("bound_from"),
             .uncertainty = number_from_json(json.value("uncertainty", Json(0.0)))};
  if (!(q.uncertainty >= 0.0)) {
    throw std::runtime_error("quantity " + q.name + " has an uncertainty that is no number >= 0");
  }
  const std::string status = json.value("status", status_of(q));
  if (status != status_of(q)) {
    throw std::runtime_error("quantity " + q.name + " has the status \"" + status +
                             "\", and by its value and bounds \"" + status_of(q) + "\"");
  }
  return q;
}

/// Splits the JSON text of all reasons, which has one reason per line.
std::vector<std::string> reasons_from(const std::string& text) {
  std::vector<std::string> reasons;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) { reasons.push_back(line); }
  return reasons;
}

Json axis_json(const Axis& axis) {
  return object("label", axis.label, "logarithmic", axis.logarithmic, "minimum", axis.minimum,
                "maximum", axis.maximum);
}

Axis axis_from(const Json& json) {
  Axis axis{.label = json.at("label"), .logarithmic = json.at("logarithmic")};
  if (!json.at("minimum").is_null()) { axis.minimum = json.at("minimum").get<double>(); }
  if (!json.at("maximum").is_null()) { axis.maximum = json.at("maximum").get<double>(); }
  return axis;
}

Json figure_json(const Figure& figure) {
  Json series = Json::array();
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    const Series& each = figure.series[n];
    series.push_back(object("label", each.label, "style",
                            style_names.at(static_cast<std::size_t>(each.style)), "group",
                            series_group(figure, n)));
  }
  const auto zone = [](const Zone& each) {
    return object("label", each.label, "begin", each.begin, "end", each.end);
  };
  const auto mark = [](const Mark& each) { return object("label", each.label, "x", each.x); };
  Json json = object("id", figure.id, "title", figure.title, "caption", figure.caption, "x",
                     axis_json(figure.x), "y", axis_json(figure.y), "square", figure.square,
                     "timing", figure.timing, "series", series);
  if (!figure.zones.empty()) { json["zones"] = list_of(figure.zones, zone); }
  if (!figure.marks.empty()) { json["marks"] = list_of(figure.marks, mark); }
  json["heat_map"] = nullptr;
  if (figure.heat_map) {
    json["heat_map"] = object("label", figure.heat_map->label, "group", heat_map_group(figure));
  }
  return json;
}

Figure figure_from(const Json& json) {
  Figure figure{.id = json.at("id"),
                .title = json.at("title"),
                .caption = json.at("caption"),
                .x = axis_from(json.at("x")),
                .y = axis_from(json.at("y")),
                .square = json.at("square"),
                .timing = json.at("timing")};
  for (const Json& each : json.at("series")) {
    const auto style = each.at("style").get<std::string>();
    const auto* found = std::find(style_names.begin(), style_names.end(), style);
    if (found == style_names.end()) { throw std::runtime_error("unknown series style " + style); }
    figure.series.push_back({.label = each.at("label"),
                             .style = static_cast<Series::Style>(found - style_names.begin())});
  }
  const Json none = Json::array();  // old files have neither zones nor marks
  for (const Json& each : json.value("zones", none)) {
    figure.zones.push_back(
        {each.at("label"), number_from_json(each.at("begin")), number_from_json(each.at("end"))});
  }
  for (const Json& each : json.value("marks", none)) {
    figure.marks.push_back({each.at("label"), number_from_json(each.at("x"))});
  }
  if (!json.at("heat_map").is_null()) {
    figure.heat_map = HeatMap{.label = json.at("heat_map").at("label").get<std::string>()};
  }
  return figure;
}

Json cell_json(const Cell& cell) {
  const auto* text = std::get_if<std::string>(&cell);
  return text != nullptr ? Json(*text) : object("value", std::get<double>(cell));
}

Json table_json(const Table& table) {
  const auto row = [](const std::vector<Cell>& cells) { return list_of(cells, cell_json); };
  return object("id", table.id, "title", table.title, "caption", table.caption, "columns",
                table.columns, "timing", table.timing, "rows", list_of(table.rows, row));
}

Table table_from(const Json& json) {
  Table table{.id = json.at("id"),
              .title = json.at("title"),
              .caption = json.at("caption"),
              .columns = json.at("columns"),
              .timing = json.at("timing")};
  for (const Json& row : json.at("rows")) {
    std::vector<Cell>& cells = table.rows.emplace_back();
    for (const Json& cell : row) {
      cells.push_back(cell.is_string() ? Cell(cell.get<std::string>())
                                       : Cell(number_from_json(cell.at("value"))));
    }
  }
  return table;
}

Timing timing_from(const Json& json) {
  return {json.at("name"), number_from_json(json.at("value")), json.at("unit")};
}

template <class Items, class Convert>
void read_list(const Json& list, Items& items, const Convert& convert) {
  for (const Json& each : list) { items.push_back(convert(each)); }
}

Status status_from(const std::string& name) {
  for (const Status status :
       {Status::pass, Status::fail, Status::inconclusive, Status::skip, Status::error}) {
    if (name_of(status) == name) { return status; }
  }
  throw std::runtime_error("unknown status " + name);
}

constexpr int schema = 1;

}  // namespace

void check_verdict(const Outcome& outcome) {
  Outcome again = outcome;
  conclude(again);
  if (again.status == outcome.status || outcome.status != Status::pass) { return; }
  throw std::runtime_error("case " + outcome.name + " says pass, but its quantities do not");
}

namespace {

/// Adds the keys that an object lacks to the text of all that are missing.
void add_missing(const Json& json, const std::string& where,
                 std::initializer_list<const char*> keys, std::string& missing) {
  std::string lacking;
  for (const char* key : keys) {
    if (json.is_object() && json.contains(key)) { continue; }
    lacking += (lacking.empty() ? "" : ", ") + std::string(key);
  }
  if (!lacking.empty()) { missing += (missing.empty() ? "" : "; ") + where + " lacks " + lacking; }
}

/// Returns every key that the text of results.json lacks; empty if there is none.
std::string missing_keys(const Json& json) {
  std::string missing;
  add_missing(json, "it", {"schema", "title", "command", "provenance", "cases"}, missing);
  if (!missing.empty()) { return missing; }
  for (std::size_t n = 0; n < json.at("cases").size(); ++n) {
    const Json& one = json.at("cases").at(n);
    const std::string where = "cases[" + std::to_string(n) + "]";
    add_missing(one, where,
                {"name", "suite", "claim", "status", "skipped", "message", "seconds", "quantities",
                 "tables", "figures", "notes", "timings"},
                missing);
    const auto add_items = [&](const char* list, std::initializer_list<const char*> keys) {
      if (!one.is_object() || !one.contains(list)) { return; }
      for (std::size_t k = 0; k < one.at(list).size(); ++k) {
        const Json& item = one.at(list).at(k);
        const std::string place = where + "." + list + "[" + std::to_string(k) + "]";
        add_missing(item, place, keys, missing);
        for (const char* axis : {"x", "y"}) {
          if (!item.is_object() || !item.contains(axis)) { continue; }
          add_missing(item.at(axis), place + "." + axis,
                      {"label", "logarithmic", "minimum", "maximum"}, missing);
        }
      }
    };
    add_items("quantities", {"name", "value", "unit", "lower", "upper", "bound_from"});
    add_items("tables", {"id", "title", "caption", "columns", "timing", "rows"});
    add_items("figures",
              {"id", "title", "caption", "x", "y", "square", "timing", "series", "heat_map"});
    add_items("timings", {"name", "value", "unit"});
  }
  return missing;
}

std::string seconds_attribute(double seconds) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.3f", seconds);
  return buffer.data();
}

std::string counts(const std::vector<const Outcome*>& outcomes) {
  Tally sum;
  double seconds = 0.0;
  for (const Outcome* outcome : outcomes) {
    sum.add(outcome->status);
    seconds += outcome->seconds;
  }
  return " tests=\"" + std::to_string(sum.all()) + "\" failures=\"" +
         std::to_string(sum.failed + sum.inconclusive) + "\" errors=\"" +
         std::to_string(sum.errors) + "\" skipped=\"" + std::to_string(sum.skipped) + "\" time=\"" +
         seconds_attribute(seconds) + "\"";
}

Data properties_of(const Outcome& outcome) {
  Data list(Data::type::list);
  const auto property = [&list](const std::string& name, const std::string& value) {
    list.push_back(record("name", name, "value", value));
  };
  for (const Quantity& q : outcome.quantities) {
    property(q.name, exact_number(q.value));
    property(q.name + ".unit", q.unit);
    if (!q.judged()) { continue; }
    property(q.name + ".lower", exact_number(q.lower));
    property(q.name + ".upper", exact_number(q.upper));
    property(q.name + ".bound_from", q.bound_from);
    if (q.uncertainty > 0.0) { property(q.name + ".uncertainty", exact_number(q.uncertainty)); }
  }
  return list;
}

Data case_of(const Outcome* of_case) {
  const Outcome& outcome = *of_case;
  std::string message = outcome.reason();
  for (const Quantity& q : outcome.quantities) {
    if (!q.judged() || q.holds()) { continue; }
    message += (message.empty() ? "" : "\n") + q.name + " = " + exact_number(q.value) + " " +
               q.unit + "; allowed " + exact_number(q.lower) + " to " + exact_number(q.upper) +
               " (" + q.bound_from + ")";
  }
  const bool inconclusive = outcome.status == Status::inconclusive;
  return record(
      "suite", outcome.suite, "name", outcome.name, "time", seconds_attribute(outcome.seconds),
      "judged", !outcome.quantities.empty(), "properties", properties_of(outcome), "skip",
      outcome.status == Status::skip, "failure", outcome.status == Status::fail || inconclusive,
      "error", outcome.status == Status::error, "type", inconclusive ? "inconclusive" : "bound",
      "claim", outcome.claim, "first", message.substr(0, message.find('\n')), "message", message);
}

}  // namespace

std::string script_text(const Json& json) {
  std::string text = json.dump(-1, ' ', true, Json::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    text.replace(at, 1, "\\u003c");
  }
  return text;
}

double number_from_json(const Json& json) {
  if (json.is_number()) { return json.get<double>(); }
  const auto text = json.get<std::string>();
  if (text == "nan") { return std::nan(""); }
  if (text == "inf") { return unbounded; }
  if (text == "-inf") { return -unbounded; }
  throw std::runtime_error("\"" + text + "\" is no number");
}

nlohmann::ordered_json case_json(const Outcome& outcome) {
  const bool skipped = outcome.status == Status::skip;
  const auto timing = [](const Timing& each) {
    return object("name", each.name, "value", each.value, "unit", each.unit);
  };
  return object(
      "name", outcome.name, "suite", outcome.suite, "claim", outcome.claim, "status",
      name_of(outcome.status), "skipped", skipped ? Json(outcome.reason()) : Json(nullptr),
      "message", skipped ? "" : outcome.reason(), "seconds", outcome.seconds, "quantities",
      list_of(outcome.quantities, quantity_json), "tables", list_of(outcome.tables, table_json),
      "traces",
      outcome.figures.empty() ? Json(nullptr) : Json("traces/" + trace_file_name(outcome.name)),
      "figures", list_of(outcome.figures, figure_json), "notes", outcome.notes, "timings",
      list_of(outcome.timings, timing));
}

Outcome case_from_json(const Json& json) {
  Outcome outcome{
      .name = json.at("name"),
      .suite = json.at("suite"),
      .claim = json.at("claim"),
      .status = status_from(json.at("status")),
      .reasons = reasons_from(json.at(json.at("skipped").is_null() ? "message" : "skipped")),
      .seconds = json.at("seconds"),
      .notes = json.at("notes")};
  if (json.at("skipped").is_null() == (outcome.status == Status::skip)) {
    throw std::runtime_error(
        "case " + outcome.name + " has the status \"" + std::string(name_of(outcome.status)) +
        "\", and " + (json.at("skipped").is_null() ? "no" : "a") + " reason why it was skipped");
  }
  read_list(json.at("quantities"), outcome.quantities, quantity_from);
  read_list(json.at("tables"), outcome.tables, table_from);
  read_list(json.at("figures"), outcome.figures, figure_from);
  read_list(json.at("timings"), outcome.timings, timing_from);
  return outcome;
}

std::string to_json(const Results& results) {
  return json_text(object("schema", schema, "title", results.title, "command", results.command,
                          "provenance", results.provenance, "cases",
                          list_of(results.outcomes, case_json)));
}

Results results_from_json(const std::string& text, const std::string& name) {
  try {
    const Json json = parse_json(text);
    if (json.contains("schema") && json.at("schema") != schema) {
      throw std::runtime_error("schema " + json.at("schema").dump() + "; this version reads 1");
    }
    if (const std::string missing = missing_keys(json); !missing.empty()) {
      throw std::runtime_error(missing);
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

namespace {

const std::string no_seal(64, '0');

}  // namespace

std::string sealed_text(Json json, int indent) {
  json["seal"] = no_seal;
  std::string text = json_text(json, indent);
  const std::string seal = io::sha256(text);
  return text.replace(text.rfind(no_seal), seal.size(), seal);
}

Json parse_sealed(const std::string& text) {
  Json json = parse_json(text);
  if (!json.contains("seal")) { throw std::runtime_error("has no seal"); }
  const auto seal = json.at("seal").get<std::string>();
  std::string zeroed = text;
  const std::size_t place = seal.size() == no_seal.size() ? text.rfind(seal) : text.npos;
  if (place != text.npos) { zeroed.replace(place, seal.size(), no_seal); }
  if (place == text.npos || io::sha256(zeroed) != seal) {
    throw std::runtime_error("was changed since it was written");
  }
  return json;
}

std::string to_junit(const Results& results) {
  std::vector<std::pair<std::string, std::vector<const Outcome*>>> suites;
  std::vector<const Outcome*> all;
  for (const Outcome& outcome : results.outcomes) {
    auto suite =
        std::ranges::find(suites, outcome.suite, [](const auto& each) { return each.first; });
    if (suite == suites.end()) { suite = suites.insert(suite, {outcome.suite, {}}); }
    suite->second.push_back(&outcome);
    all.push_back(&outcome);
  }
  const auto values = [](const auto& suite) {
    return record("name", suite.first, "counts", counts(suite.second), "cases",
                  data_of(suite.second, case_of));
  };
  return fill(templates::junit, record("title", results.title, "counts", counts(all), "suites",
                                       data_of(suites, values)));
}

}  // namespace palpate
