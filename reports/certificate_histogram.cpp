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

Figure histogram_figure(const CertificateReport& report) {
  Figure figure{.id = "histogram",
                .title = "How often a tick took how long",
                .caption = "Bins of 1 us from the scheduled release; a single late tick is a point at 1.",
                .x = {.label = "time (us)", .logarithmic = true},
                .y = {.label = "ticks", .logarithmic = true, .minimum = 0.8},
                .timing = true};
  const LoadResult* worst = report.result.worst();
  if (worst == nullptr) { return figure; }
  figure.series = {series_of("response of the scene", worst->scene.record.response),
                   series_of("its computation", worst->scene.record.compute),
                   series_of("its wake-up", worst->scene.record.wakeup),
                   series_of("response of the empty loop", worst->control.record.response)};
  figure.marks = {{"deadline", 1e6 * report.result.claim.deadline}};
  return figure;
}

}  // namespace palpate
