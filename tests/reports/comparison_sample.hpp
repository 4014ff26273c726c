// SPDX-License-Identifier: MIT
#pragma once
/// Made-up insertions compared with each other, as the command would hand them to its reports.

#include "reports/comparison_report.hpp"
#include "validation/cases/clinical_traces.hpp"

namespace sample {

using namespace palpate;

/// A recording at 120 Hz of the law times a factor, with a depth that rises at 5 mm/s.
inline ComparedRecording compared_recording(const std::string& name, double factor,
                                            Recording::Kind kind = Recording::Kind::reconstructed) {
  const std::vector<double> time = clinical::instants(14.0, 120.0);
  std::vector<double> pressure = clinical::pressures({}, time);
  for (double& p : pressure) { p *= factor; }
  ComparedRecording one{.file = name + ".h5", .hash = "0123"};
  one.input.recording = clinical::recording_of(time, pressure);
  one.input.recording.name = name;
  one.input.recording.kind = kind;
  one.input.recording.group = "BMI <18>";
  for (const double t : time) { one.input.recording.depth.push_back(5e-3 * t); }
  return one;
}

inline Trace compared_trace() {
  const std::vector<double> time = clinical::instants(14.0, 1000.0);
  Trace trace = clinical::trace_of(time, clinical::pressures({}, time));
  Column depth{"tool.depth_m", "m", {}};
  Column force{"tool.force_n", "N", {}};
  TextColumn layer{"tool.layer", {}};
  for (const double t : time) {
    depth.values.push_back(5e-3 * t);
    force.values.push_back(t < 6.0 ? t : 1.0);
    layer.values.push_back(t < 6.0 ? "flavum" : "epidural <space>");
  }
  trace.columns.push_back(depth);
  trace.columns.push_back(force);
  trace.text_columns = {layer};
  trace.events = {{6.0, "loss-of-resistance", "epidural <space>"}};
  return trace;
}

inline ComparisonReport compared(std::vector<ComparedRecording> recordings, Trace trace = compared_trace()) {
  ComparisonReport report{.recordings = std::move(recordings),
                          .simulation = {.file = "trace.h5", .hash = "4567", .trace = std::move(trace)},
                          .provenance = {{"version", "0.1.0"}},
                          .command = "palpate compare <x> --trace trace.h5"};
  std::vector<Recording> all;
  for (const ComparedRecording& one : report.recordings) { all.push_back(one.input.recording); }
  report.found = comparison::compare_all(all, report.simulation.trace, report.options);
  report.credibility = comparison::credibility({}, &report.found);
  return report;
}

}  // namespace sample
