// SPDX-License-Identifier: MIT
#include "reports/baseline_file.hpp"

#include <cmath>
#include <stdexcept>

#include "fixtures/io/content_hash.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/hdf5_file.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/case_json.hpp"
#include "reports/json_trouble.hpp"
#include "reports/figure_data.hpp"

namespace palpate {

namespace {

using Json = nlohmann::ordered_json;

constexpr int schema = 1;
constexpr std::size_t most_bytes = 1U << 30U;
constexpr const char* seal_key = "seal";

std::string text_of(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

/// Of everything but itself: tells an edit by hand from what approve wrote.
std::string seal_of(Json json) {
  json.erase(seal_key);
  return io::content_hash(text_of(json));
}

Json spread_json(const gate::Spread& spread) {
  return {{"runs", spread.runs}, {"quantities", spread.quantities}, {"curves", spread.curves}};
}

gate::Spread spread_from(const Json& json) {
  return {.quantities = json.at("quantities").get<std::map<std::string, double>>(),
          .curves = json.at("curves").get<std::map<std::string, double>>(),
          .runs = json.at("runs")};
}

Json ledger_json(const std::vector<gate::Approval>& ledger) {
  Json list = Json::array();
  for (const gate::Approval& entry : ledger) {
    list.push_back(
        {{"date", entry.date}, {"commit", entry.commit}, {"reason", entry.reason}, {"cases", entry.cases}});
  }
  return list;
}

std::vector<gate::Approval> ledger_from(const Json& json) {
  std::vector<gate::Approval> ledger;
  for (const Json& each : json) {
    ledger.push_back({each.at("date"), each.at("commit"), each.at("reason"),
                      each.at("cases").get<std::vector<std::string>>()});
  }
  return ledger;
}

Json to_json(const gate::Baseline& baseline, const std::string& hash_of_curves) {
  Json cases = Json::array();
  for (const gate::AcceptedCase& accepted : baseline.cases) {
    Json json = case_json(accepted.outcome);
    for (const char* key : {"seconds", "tables", "traces", "notes", "timings"}) { json.erase(key); }
    json["spread"] = spread_json(accepted.spread);
    cases.push_back(std::move(json));
  }
  Json json{{"kind", "palpate baseline"},
            {"schema", schema},
            {"command", baseline.command},
            {"ledger", ledger_json(baseline.ledger)},
            {"provenance", baseline.provenance},
            {"curves", hash_of_curves},
            {"cases", cases}};
  json[seal_key] = seal_of(json);
  return json;
}

gate::AcceptedCase accepted_from(Json json) {
  json["seconds"] = 0.0;
  for (const char* key : {"tables", "notes", "timings"}) { json[key] = Json::array(); }
  return {.outcome = case_from_json(json), .spread = spread_from(json.at("spread"))};
}

gate::Baseline baseline_from(const Json& json) {
  if (json.value("kind", "") != "palpate baseline") { throw std::runtime_error("is no baseline"); }
  if (json.at("schema") != schema) {
    throw std::runtime_error("schema " + json.at("schema").dump() + "; this version reads " +
                             std::to_string(schema));
  }
  if (json.value(seal_key, "") != seal_of(json)) {
    throw std::runtime_error("was changed by something else than palpate approve");
  }
  gate::Baseline baseline{.command = json.at("command"), .ledger = ledger_from(json.at("ledger"))};
  baseline.provenance = json.at("provenance").get<std::map<std::string, std::string>>();
  for (const Json& each : json.at("cases")) { baseline.cases.push_back(accepted_from(each)); }
  if (baseline.cases.empty()) { throw std::runtime_error("holds no case"); }
  return baseline;
}

std::string group_of(const gate::AcceptedCase& accepted) { return "/" + accepted.outcome.name; }

/// Returns what the file holds now, as a hash.
std::string write_curves(const std::filesystem::path& path, const gate::Baseline& baseline) {
  io::Hdf5File file = io::Hdf5File::create(path);
  for (const gate::AcceptedCase& accepted : baseline.cases) {
    write_figures(file, group_of(accepted), accepted.outcome.figures);
  }
  file.commit();
  return io::content_hash(io::read_bytes(path, most_bytes));
}

}  // namespace

std::filesystem::path curves_of_baseline(const std::filesystem::path& path) {
  return std::filesystem::path(path).replace_extension(".h5");
}

void write_baseline(const std::filesystem::path& path, const gate::Baseline& baseline) {
  if (path.extension() == ".h5") {
    throw InputError(path.string() + ": the curves go there; a name with another ending, as .json");
  }
  const std::string hash = write_curves(curves_of_baseline(path), baseline);
  io::replace_file(path, text_of(to_json(baseline, hash)));
}

gate::Baseline read_baseline(const std::filesystem::path& path) {
  const std::string text = io::read_text(path, most_bytes);
  gate::Baseline baseline;
  std::string hash;
  try {
    const Json json = Json::parse(text);
    baseline = baseline_from(json);
    hash = json.at("curves");
  } catch (const std::exception& problem) {
    throw json_trouble(path.string(), text, problem, "a baseline as palpate approve wrote it");
  }
  const std::filesystem::path curves = curves_of_baseline(path);
  if (io::content_hash(io::read_bytes(curves, most_bytes)) != hash) {
    throw InputError(curves.string() + ": does not belong to " + path.string() +
                     ", or is damaged; the curves that palpate approve wrote with it");
  }
  const io::Hdf5File file = io::Hdf5File::open(curves);
  for (gate::AcceptedCase& accepted : baseline.cases) {
    read_figures(file, curves, group_of(accepted), accepted.outcome.figures);
  }
  return baseline;
}

}  // namespace palpate
