// SPDX-License-Identifier: MIT
// Readers of results, baselines, histories and recordings of any format.

#include "tests/fuzz_readers.hpp"

#include "reports/evidence.hpp"
#include "reports/recording_input.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/results/results_json.hpp"
#include "reports/timing/history.hpp"

namespace {

const std::map<std::string, Reader>& readers() {
  static const std::map<std::string, Reader> all{
      {"results",
       [](std::string_view bytes) { (void)results_from_json(std::string(bytes), "results.json"); }},
      {"baseline", [](std::string_view bytes) { (void)read_baseline(file_with(bytes, "b.json")); }},
      {"history",
       [](std::string_view bytes) { (void)timing::read_history(file_with(bytes, "h.jsonl")); }},
      {"evidence", [](std::string_view bytes) { (void)evidence::from_zip(bytes, "e.zip"); }},
      {"recording",  // CSV and raw link
       [](std::string_view bytes) { (void)read_any_recording(file_with(bytes, "r.csv")); }}};
  return all;
}

}  // namespace
