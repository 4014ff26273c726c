// SPDX-License-Identifier: MIT

#include "reports/timing/history.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <sys/file.h>
#include <unistd.h>

#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "reports/results/results_json.hpp"
#include "validation/gate/baseline.hpp"

namespace palpate::timing {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_history_bytes = 1U << 28U;
constexpr mode_t for_all_to_read = 0644;

HistoryLine line_from(const std::string& text) {
  const Json json = parse_json(text);
  HistoryLine line{
      .date = json.at("date"), .commit = json.at("commit"), .compiler = json.at("compiler")};
  for (const auto& [name, each] : json.at("quantities").items()) {
    line.quantities[name] = {.value = each.at("value"), .unit = each.at("unit")};
  }
  return line;
}

/// Returns the size without the last line, if that has neither an end nor a whole JSON object: a
/// write that a crash or a full disk cut short.
std::size_t whole_lines(const std::string& text) {
  const std::size_t end = text.rfind('\n');
  const std::size_t begin = end == std::string::npos ? 0 : end + 1;
  return Json::accept(text.substr(begin)) ? text.size() : begin;
}

Series curve_of(const Trend& trend) {
  Series series{.label = trend.name, .style = Series::Style::line_and_points};
  for (std::size_t n = 0; n < trend.values.size(); ++n) {
    series.x.push_back(static_cast<double>(n + 1));
    series.y.push_back(trend.unit == "digits"
                           ? trend.values[n] - trend.values.front()
                           : 100.0 * (trend.values[n] / trend.values.front() - 1.0));
  }
  return series;
}

/// Adds a figure of all trends of costs, or of digits if `digits` is true; none without trends.
void add_figure(const std::vector<Trend>& trends, bool digits, Outcome& outcome) {
  Figure figure{.id = digits ? "digits" : "costs",
                .title = digits ? "Digits over the runs" : "Costs over the runs",
                .caption = digits ? "Gained since the first run." : "Grown since the first run.",
                .x = {.label = "run"},
                .y = {.label = digits ? "digits gained" : "growth (%)"},
                .timing = true};
  for (const Trend& trend : trends) {
    if ((trend.unit == "digits") == digits) { figure.series.push_back(curve_of(trend)); }
  }
  if (!figure.series.empty()) { outcome.figures.push_back(std::move(figure)); }
}

Table table_of(const std::vector<Trend>& trends) {
  Table table{
      .id = "trends",
      .title = "Trends",
      .caption =
          "Where the level of a series changes most (Pettitt), and how seldom chance does as much.",
      .columns = {"series", "unit", "runs", "changes at run", "chance", "before", "after", "crept"},
      .timing = true};
  for (const Trend& trend : trends) {
    const bool known = trend.change.has_value();
    table.rows.push_back(
        {trend.name, trend.unit, static_cast<double>(trend.values.size()),
         known ? Cell(static_cast<double>(trend.change->at + 1)) : Cell(std::string("-")),
         known ? Cell(trend.change->chance) : Cell(std::string("-")),
         known ? Cell(trend.change->before) : Cell(std::string("-")),
         known ? Cell(trend.change->after) : Cell(std::string("-")),
         std::string(trend.crept ? "yes" : "no")});
  }
  return table;
}

}  // namespace

HistoryLine history_line_of(const Results& results) {
  HistoryLine line{.date = entry(results.provenance, "date"),
                   .commit = entry(results.provenance, "commit"),
                   .compiler = entry(results.provenance, "compiler")};
  for (const Outcome& outcome : results.outcomes) {
    for (const Quantity& quantity : outcome.quantities) {
      if (!std::isfinite(quantity.value)) { continue; }
      line.quantities[outcome.name + ": " + quantity.name] = {.value = quantity.value,
                                                              .unit = quantity.unit};
    }
  }
  return line;
}

std::string to_text(const HistoryLine& line) {
  Json quantities = Json::object();
  for (const auto& [name, each] : line.quantities) {
    quantities[name] = object("value", each.value, "unit", each.unit);
  }
  return json_text(object("date", line.date, "commit", line.commit, "compiler", line.compiler,
                          "quantities", quantities),
                   -1);
}

void for_each_line(const std::filesystem::path& file,
                   const std::function<void(const std::string&)>& read,
                   const std::string& expected) {
  if (!std::filesystem::exists(file)) { return; }
  const std::string all = io::read_text(file, most_history_bytes);
  std::istringstream lines(all.substr(0, whole_lines(all)));
  std::size_t number = 0;
  for (std::string text; std::getline(lines, text);) {
    ++number;
    try {
      read(text);
    } catch (const std::exception&) {
      throw InputError(file.string() + ":" + std::to_string(number) + ": not " + expected +
                       "; remove the line");
    }
  }
}

std::vector<HistoryLine> read_history(const std::filesystem::path& file) {
  std::vector<HistoryLine> history;
  for_each_line(
      file, [&](const std::string& text) { history.push_back(line_from(text)); },
      "a run of the benchmark as `palpate bench --history` appends them");
  return history;
}

void append_line(const std::filesystem::path& file, const std::string& line) {
  const io::WholeWrite whole;
  const auto fail = [&file](const std::string& reason) {
    throw InputError(file.string() + ": cannot be written: " + reason +
                     "; a file that can be written is needed");
  };
  const int to = open(file.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, for_all_to_read);
  if (to < 0) { fail(std::strerror(errno)); }
  (void)flock(to, LOCK_EX);  // until it is closed: no mixed lines
  const std::string before = io::read_text(file, most_history_bytes);
  const std::size_t kept = whole_lines(before);
  if (kept < before.size()) { (void)!ftruncate(to, static_cast<off_t>(kept)); }
  const bool unended = kept > 0 && before[kept - 1] != '\n';
  const std::string text = (unended ? "\n" : "") + line;
  std::string_view left = text;
  while (!left.empty()) {
    const ssize_t written = write(to, left.data(), left.size());
    if (written < 0 && errno == EINTR) { continue; }
    if (written <= 0) { break; }
    left.remove_prefix(static_cast<std::size_t>(written));
  }
  const std::string problem = std::strerror(errno);
  if (!left.empty()) { (void)!ftruncate(to, static_cast<off_t>(kept)); }
  close(to);
  if (!left.empty()) { fail(problem); }
}

std::vector<Trend> trends_of(const std::vector<HistoryLine>& history) {
  std::vector<Trend> trends;
  if (history.empty()) { return trends; }
  for (const auto& [name, last] : history.back().quantities) {
    if (!gate::is_counted(last.unit)) { continue; }
    Trend trend{.name = name, .unit = last.unit};
    for (const HistoryLine& line : history) {
      const auto found = line.quantities.find(name);
      const bool alike = line.compiler == history.back().compiler &&
                         found != line.quantities.end() && found->second.unit == last.unit;
      if (alike) { trend.values.push_back(found->second.value); }
    }
    trends.push_back(std::move(trend));
  }
  return trends;
}

Outcome history_outcome(const std::vector<HistoryLine>& history) {
  Outcome outcome{.name = "bench/history",
                  .suite = "timing",
                  .claim =
                      "Nothing that is counted has crept up by more than one comparison lets pass, "
                      "nor lost a tenth of a digit."};
  std::vector<Trend> trends = trends_of(history);
  find_creep(trends);
  double crept = 0.0;
  for (const Trend& trend : trends) { crept += trend.crept ? 1.0 : 0.0; }
  outcome.judge(
      {.name = "series_that_crept",
       .value = crept,
       .lower = 0.0,
       .upper = 0.0,
       .bound_from = "a false alarm in any of the series once in a hundred times (Pettitt, Holm)"});
  outcome.tables.push_back(table_of(trends));
  add_figure(trends, false, outcome);
  add_figure(trends, true, outcome);
  conclude(outcome);
  return outcome;
}

}  // namespace palpate::timing
