// SPDX-License-Identifier: MIT
#include <algorithm>

#include "reports/certificate_report.hpp"

namespace palpate {
namespace {

using namespace certificate;

struct NamedHistogram {
  std::string name{};
  const LatencyHistogram* times = nullptr;
};

std::vector<NamedHistogram> histograms_of(const LoadResult& load, const std::string& suffix) {
  return {{"wakeup" + suffix, &load.scene.record.wakeup},
          {"compute" + suffix, &load.scene.record.compute},
          {"response" + suffix, &load.scene.record.response},
          {"control" + suffix, &load.control.record.response}};
}

/// Counts over the middles of bins that hold any.
Series series_of(const std::string& label, const LatencyHistogram& times) {
  Series series{.label = label, .style = Series::Style::points};
  for (std::size_t bin = 0; bin < times.used_bins(); ++bin) {
    if (times.counts()[bin] == 0) { continue; }
    series.x.push_back(static_cast<double>(bin) + 0.5);
    series.y.push_back(times.counts()[bin]);
  }
  return series;
}

}  // namespace

std::string to_csv(const CertificateReport& report) {
  std::vector<NamedHistogram> columns;
  const LoadResult nothing("", report.result.claim.deadline);
  const LoadResult& worst = report.result.worst() != nullptr ? *report.result.worst() : nothing;
  std::ranges::move(histograms_of(worst, ""), std::back_inserter(columns));
  if (report.result.loads.size() > 1) {
    for (const LoadResult& load : report.result.loads) {
      std::ranges::move(histograms_of(load, "_" + load.load), std::back_inserter(columns));
    }
  }
  std::string csv = "bin_start_us";
  std::size_t bins = 0;
  for (const NamedHistogram& column : columns) {
    csv += "," + column.name;
    bins = std::max(bins, column.times->used_bins());
  }
  csv += "\n";
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const auto holds = [bin](const NamedHistogram& column) { return column.times->counts()[bin] > 0; };
    if (std::ranges::none_of(columns, holds)) { continue; }
    csv += std::to_string(bin);
    for (const NamedHistogram& column : columns) { csv += "," + std::to_string(column.times->counts()[bin]); }
    csv += "\n";
  }
  return csv;
}

std::vector<Figure> histogram_figures(const CertificateReport& report) {
  const LoadResult* worst = report.result.worst();
  if (worst == nullptr || worst->control.record.ticks() == 0) { return {}; }
  Figure figure{.id = "responses",
                .title = "Response: scene and empty loop",
                .caption = "Ticks in each us from the scheduled release; a single late one is a point at 1.",
                .x = {.label = "time (us)", .logarithmic = true},
                .y = {.label = "ticks", .logarithmic = true, .minimum = 0.8},
                .series = {series_of("scene", worst->scene.record.response),
                           series_of("empty loop", worst->control.record.response)},
                .marks = {{"deadline", 1e6 * report.result.claim.deadline}},
                .timing = true};
  Figure parts = figure;
  parts.id = "parts";
  parts.title = "What the response of the scene is made of";
  parts.caption = "Waking up late and computing, in bins of 1 us.";
  parts.series = {series_of("computation", worst->scene.record.compute),
                  series_of("wake-up", worst->scene.record.wakeup)};
  return {std::move(figure), std::move(parts)};
}

}  // namespace palpate
