// SPDX-License-Identifier: MIT
#include "reports/results_json.hpp"

#include <set>
#include <stdexcept>

#include "model/dynamics/scene_check.hpp"
#include "reports/case_json.hpp"
#include "reports/json_trouble.hpp"

namespace palpate {

namespace {

using Json = nlohmann::ordered_json;

constexpr int schema = 1;

/// A pass that its own numbers contradict was not written by this program.
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
      if (!names.insert(outcome.name).second) { throw std::runtime_error("case " + outcome.name + " stands twice"); }
    }
    return results;
  } catch (const std::exception& problem) {
    throw json_trouble(name, text, problem, "results.json as palpate wrote it");
  }
}

}  // namespace palpate
