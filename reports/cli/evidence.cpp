// SPDX-License-Identifier: MIT
/// The commands `evidence`, which packs results with their context into one signed archive, and
/// `verify`, which recomputes what the archive says (docs/evidence.md).

#include "reports/evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <link.h>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_file.hpp"
#include "fixtures/io/toml_file.hpp"
#include "fixtures/io/trace_file.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/results/results_json.hpp"
#include "reports/timing/child_process.hpp"
#include "validation/campaign/findings.hpp"
#include "validation/case.hpp"
#include "validation/comparison/comparison.hpp"
#include "validation/comparison/iso_rating.hpp"
#include "validation/number_text.hpp"
#include "validation/planted_faults.hpp"

namespace palpate::cli {

struct EvidenceRequirement {
  std::string id{};
  std::string text{};
  std::vector<std::string> cases{};  ///< names or groups
};

/// Factor of credibility that the user gives evidence for, outside this program.
struct EvidenceFactor {
  std::string name{};
  std::string evidence{};
};

/// Ranges in which the simulator will be used; empty: not stated.
struct UseDomain {
  std::vector<double> speed{};    ///< [m/s]
  std::vector<double> depth{};    ///< [m]
  std::vector<int> gauge{};       ///< Stubs gauges
  std::vector<double> modulus{};  ///< [Pa]
};

enum class Level { low, medium, high };
constexpr auto words(Level e) { return in_order(e, "low", "medium", "high"); }

/// Content of context.toml.
struct EvidenceContext {
  std::string title{};
  std::string question{};              ///< of interest
  std::string use{};                   ///< context of use
  std::optional<Level> influence{};    ///< of the model on the decision
  std::optional<Level> consequence{};  ///< of a wrong decision
  UseDomain domain{};
  std::vector<EvidenceRequirement> requirements{};
  std::vector<EvidenceFactor> factors{};
  std::vector<std::string> anomalies{};
};

}  // namespace palpate::cli

namespace palpate::io {

template <class Visitor> void fields(Visitor& v, cli::EvidenceRequirement& r) {
  v.value("id", r.id, required({}));
  v.value("text", r.text, required({}));
  v.value("cases", r.cases, required({}));
}
template <class Visitor> void fields(Visitor& v, cli::EvidenceFactor& f) {
  v.value("name", f.name, required({}));
  v.value("evidence", f.evidence, required({}));
}
template <class Visitor> void fields(Visitor& v, cli::UseDomain& d) {
  v.value("speed", d.speed, {"m/s", range::positive});
  v.value("depth", d.depth, {"m", range::non_negative});
  v.value("gauge", d.gauge, {});
  v.value("modulus", d.modulus, {"Pa", range::positive});
}
template <class Visitor> void fields(Visitor& v, cli::EvidenceContext& c) {
  v.value("title", c.title, required({}));
  v.value("question", c.question, required({}));
  v.value("use", c.use, required({}));
  v.value("influence", c.influence, required({}));
  v.value("consequence", c.consequence, required({}));
  v.table("domain", c.domain);
  v.list("requirement", c.requirements);
  v.list("factor", c.factors);
  v.value("anomalies", c.anomalies, {});
}

}  // namespace palpate::io

namespace palpate::cli {
namespace {

using campaign::Domain;
namespace fs = std::filesystem;
using evidence::Files;
using Json = nlohmann::ordered_json;

constexpr std::size_t most_file_bytes = std::size_t{1} << 29U;
constexpr const char* statement_name = "statement.intoto.json";

/// Item of a credibility table, with the cases that are evidence for it.
struct Credibility {
  const char* scheme;
  const char* name;
  std::vector<std::string> cases;
  const char* remark;
};

/// The evidence categories of FDA, "Assessing the Credibility of Computational Modeling and
/// Simulation in Medical Device Submissions" (November 2023), and the factors of ASME V&V 40-2018.
const std::vector<Credibility>& credibility_items() {
  constexpr const char* fda = "FDA 2023 category";
  constexpr const char* asme = "ASME V&V 40 factor";
  const std::vector<std::string> code{"oscillator", "network", "tissue", "needle/reference",
                                      "probe/half-space"};
  const std::vector<std::string> calculation{"network/order", "oscillator/order", "needle/spacing",
                                             "needle/order", "oscillator/stability-limit"};
  const std::vector<std::string> plausible{"needle", "probe", "stability", "haptics"};
  const std::vector<std::string> measured{"comparison/measured", "comparison/measured-phantom"};
  static const std::vector<Credibility> items{
      {fda, "1 code verification", code, ""},
      {fda, "2 model calibration", {"calibration", "clinical/calibration"}, ""},
      {fda, "3 bench test validation", {"comparison/measured-phantom"}, "recordings of phantoms"},
      {fda,
       "4 in vivo validation",
       {"comparison/measured"},
       "recordings of patients; reconstructed ones are no evidence"},
      {fda, "5 population-based validation", {}, "no population data"},
      {fda, "6 emergent model behaviour", {"needle/loss-of-resistance", "needle/bone"}, ""},
      {fda, "7 model plausibility", plausible, ""},
      {fda, "8 calculation verification in the context of use", {"campaign"}, ""},
      {asme, "software quality assurance", {"qualification", "gate"}, ""},
      {asme, "numerical code verification", code, ""},
      {asme, "discretisation error", calculation, ""},
      {asme,
       "numerical solver error",
       {"oscillator/order", "network/order", "network/reference"},
       ""},
      {asme, "use error", {}, "review of inputs by a second person"},
      {asme,
       "model form",
       {"needle", "probe", "tissue", "comparison/measured", "comparison/measured-phantom"},
       ""},
      {asme, "model inputs", {"patient", "campaign/sensitivity"}, ""},
      {asme, "test samples", measured, ""},
      {asme, "test conditions", measured, ""},
      {asme, "equivalency of input parameters", measured, ""},
      {asme, "output comparison", measured, ""},
      {asme, "relevance of the quantities of interest", {}, "argued by the user"},
      {asme, "relevance of the validation activities", {}, "argued by the user"}};
  return items;
}

/// Ranges of the context as in Domain; a gauge by its diameter. Throws InputError.
Domain use_domain(const UseDomain& use, const io::Places& places, io::Problems& problems) {
  Domain domain;
  const auto add = [&](const char* key, const char* name, const std::vector<double>& range) {
    if (range.empty()) { return; }
    if (range.size() != 2 || range[0] > range[1]) {
      problems.add(places, std::string("domain.") + key,
                   std::string("domain.") + key + " must be [lowest, highest]");
      return;
    }
    domain[name] = {range[0], range[1]};
  };
  add("speed", "speed_m_per_s", use.speed);
  add("depth", "depth_m", use.depth);
  add("modulus", "youngs_modulus_pa", use.modulus);
  std::vector<double> diameters;
  for (const int gauge : use.gauge) {
    const std::optional<double> diameter = diameter_of_gauge(gauge);
    if (!diameter) {
      problems.add(places, "domain.gauge",
                   "domain.gauge has " + std::to_string(gauge) + "; a Stubs gauge");
      return domain;
    }
    diameters.push_back(*diameter);
  }
  if (!diameters.empty()) {
    const auto [low, high] = std::ranges::minmax(diameters);
    domain["needle_diameter_m"] = {low, high};
  }
  return domain;
}

const char* key_in_context(const std::string& key) {
  return key == "speed_m_per_s"       ? "speed"
         : key == "depth_m"           ? "depth"
         : key == "needle_diameter_m" ? "gauge"
                                      : "modulus";
}

std::string range_text(const std::array<double, 2>& range) {
  return exact_number(range[0]) + " to " + exact_number(range[1]);
}

/// Context with the domain of use. Refuses a domain that goes beyond the tested one.
struct ReadContext {
  EvidenceContext of{};
  Domain use{};
};

ReadContext read_context(const fs::path& file, const Domain& tested) {
  io::Problems problems;
  const io::TomlDocument document = io::read_toml(file, "a context of use", {}, problems);
  ReadContext context;
  io::TomlReader reader(document.root, "", document.places, problems,
                        [](std::string_view) { return std::string(); });
  fields(reader, context.of);
  reader.refuse_unknown_keys();
  context.use = use_domain(context.of.domain, document.places, problems);
  if (problems.none() && context.use.empty()) {
    problems.add(document.places, "domain",
                 "domain is missing or empty; at least one of speed, depth, gauge and modulus");
  }
  for (const auto& [key, range] : context.use) {
    const auto found = tested.find(key);
    const bool covered =
        found != tested.end() && found->second[0] <= range[0] && range[1] <= found->second[1];
    if (covered) { continue; }
    const std::string name = std::string("domain.") + key_in_context(key);
    problems.add(document.places, name,
                 name + ": " + key + " from " + range_text(range) +
                     " is outside the domain; tested: " +
                     (found == tested.end() ? "none" : range_text(found->second)) +
                     "; runs or campaigns there, or a narrower context");
  }
  problems.throw_if_any();
  return context;
}

/// Everything that the tables of an archive are computed from.
struct Sources {
  std::vector<std::pair<std::string, Outcome>> outcomes{};  ///< with the folder in the archive
  Domain tested{};
  std::set<std::string> known{};  ///< names of all cases of the program that made the archive
};

/// Folder of a file in the archive; empty at the top.
std::string folder_of(const std::string& file) {
  const std::size_t slash = file.rfind('/');
  return slash == std::string::npos ? std::string() : file.substr(0, slash);
}

Outcome qualification_outcome(const Json& json) {
  Outcome outcome{.name = "qualification/planted-faults",
                  .suite = "qualification",
                  .claim = "Every planted fault fails a case that passes without it"};
  std::size_t missed = 0;
  for (const Json& each : json.at("faults")) {
    missed += each.at("without") == "pass" && each.at("with") == "fail" ? 0 : 1;
  }
  outcome.judge_equal("missed_faults", missed, 0, "every fault must be found");
  outcome.judge_at_least("planted_faults", json.at("faults").size(), 1, "at least one fault");
  conclude(outcome);
  return outcome;
}

/// Throws std::runtime_error if the verdict on a feature does not follow from its numbers.
void check_feature(const Json& feature, bool is_time) {
  if (feature.at("recorded").is_null() || feature.at("simulated").is_null()) { return; }
  const std::string name = feature.at("name");
  const auto number = [&feature](const char* key) { return number_from_json(feature.at(key)); };
  const double recorded = number("recorded");
  const double error = number("simulated") - recorded;
  require_consistent(number("error") == error || std::isnan(error), "the error of " + name);
  if (feature.at("verdict") == "not judged") {
    return require_consistent(is_time, name + " has both values and is not judged");
  }
  const Json& given = feature.at("tolerance");
  const comparison::Tolerance tolerance{.absolute = number_from_json(given.at("absolute")),
                                        .relative = number_from_json(given.at("relative")),
                                        .factor = number_from_json(given.at("factor"))};
  const Quantity judged{.value = number("simulated"),
                        .lower = tolerance.lower(recorded),
                        .upper = tolerance.upper(recorded),
                        .uncertainty = number("expanded_uncertainty")};
  require_consistent(number("lower") == judged.lower && number("upper") == judged.upper,
                     "the limits of " + name + " are not those of its tolerance");
  require_consistent(judged.uncertainty >= number("u_val") && number("u_val") >= 0.0,
                     "the uncertainty of " + name);
  const bool finite = std::isfinite(judged.value) && std::isfinite(judged.lower) &&
                      std::isfinite(judged.upper) && std::isfinite(judged.uncertainty);
  require_consistent(
      feature.at("verdict") == comparison::verdict_word(finite ? judged.status() : Status::error),
      "the verdict on " + name);
}

/// Throws std::runtime_error if a comparison.json lacks features, or if its verdicts, ratings and
/// counts do not agree.
void check_comparison(const Json& json) {
  using enum comparison::QuantityKind;
  constexpr std::array kinds{pressure, force, insertion};
  const std::string quantity = json.at("quantity");
  const auto* kind =
      std::ranges::find(kinds, quantity, [](auto each) { return comparison::name_of(each); });
  require_consistent(kind != kinds.end(), "quantity \"" + quantity + "\"");
  std::map<std::string, std::map<std::string, int>> counts;
  std::map<std::string, int> of_kind;
  const Json none = Json::array();
  for (const Json& recording : json.at("recordings")) {
    std::map<std::string, int>& count = counts[recording.at("group")];
    ++count[recording.at("verdict")];
    ++count[recording.at("kind")];
    ++of_kind[recording.at("kind")];
    const Json& features = recording.contains("features") ? recording.at("features") : none;
    if (features.empty()) { continue; }
    for (const comparison::Feature each : comparison::features_of(*kind)) {
      const std::string name(comparison::name_of(each));
      const auto found = std::ranges::find_if(
          features, [&name](const Json& feature) { return feature.at("name") == name; });
      require_consistent(found != features.end(), "it lacks the feature " + name);
      check_feature(*found, comparison::is_time(each));
    }
    const Json& rating = recording.at("rating");
    if (rating.is_null()) { continue; }
    const std::string_view grade = comparison::grade_of(number_from_json(rating.at("overall")));
    require_consistent(rating.at("grade") == grade, "the grade of a rating");
    require_consistent(recording.at("verdict") != "agrees" || grade != "poor",
                       "it agrees, and its curve is rated poor");
  }
  bool all_agree = true;  // groups that can be compared
  bool all_comparable = true;
  for (const Json& group : json.at("groups")) {
    std::map<std::string, int>& count = counts[group.at("group")];
    all_agree =
        all_agree && (group.at("verdict") == "agrees" || group.at("verdict") == "not comparable");
    all_comparable = all_comparable && count["not comparable"] == 0;
    require_consistent(
        group.at("agree") == count["agrees"] &&
            group.at("differ") == count["differs"] + count["features agree, curve does not"] &&
            group.at("not_distinguishable") == count["not distinguishable"] &&
            group.at("not_comparable") == count["not comparable"],
        "the counts of group " + group.at("group").get<std::string>());
    const int recordings = count["measured"] + count["measured-phantom"] + count["reconstructed"];
    require_consistent(group.at("measured") == count["measured"] &&
                           group.at("measured_phantom") == count["measured-phantom"] &&
                           group.at("reconstructed") == count["reconstructed"] &&
                           group.at("recordings") == recordings &&
                           group.at("subjects") <= recordings &&
                           group.at("subjects_agree") <= group.at("subjects"),
                       "the recordings of group " + group.at("group").get<std::string>());
  }
  require_consistent(json.at("schema") == 1, "its schema");
  const bool agrees = json.at("verdict") == "agrees";
  require_consistent(!agrees || all_agree, "it agrees, and a group does not");
  require_consistent(json.at("holds") == (agrees && all_comparable),
                     "whether it holds, and its verdict");
  const std::string sentence = json.at("sentence");
  const auto says = [&sentence](const char* part) { return sentence.find(part) != sentence.npos; };
  const bool simulated = json.at("simulation").at("failure") == "";
  require_consistent(
      !simulated ||
          (says("What was reconstructed is no evidence") == (of_kind["reconstructed"] > 0) &&
           says("A phantom is no evidence") == (of_kind["measured-phantom"] > 0)),
      "its sentence, and the kinds of its recordings");
}

/// Outcomes of comparison.json, one for each recording: comparison/KIND/NAME.
std::vector<Outcome> comparison_outcomes(const Json& json) {
  static const std::map<std::string, Status> statuses{
      {"agrees", Status::pass},
      {"differs", Status::fail},
      {"features agree, curve does not", Status::fail},
      {"not distinguishable", Status::inconclusive},
      {"not comparable", Status::error}};
  std::vector<Outcome> outcomes;
  for (const Json& recording : json.at("recordings")) {
    Outcome outcome{.name = "comparison/" + recording.at("kind").get<std::string>() + "/" +
                            recording.at("name").get<std::string>(),
                    .suite = "comparison",
                    .claim = "The simulation agrees with the recording",
                    .status = statuses.at(recording.at("verdict")),
                    .reasons = recording.at("reasons")};
    const Json none = Json::array();
    for (const Json& feature : recording.value("features", none)) {
      const bool judged = feature.at("verdict") != "not judged";
      if (!judged || feature.at("simulated").is_null() || feature.at("lower").is_null()) {
        continue;
      }
      outcome.judge({.name = feature.at("name"),
                     .value = number_from_json(feature.at("simulated")),
                     .unit = feature.at("unit"),
                     .lower = number_from_json(feature.at("lower")),
                     .upper = number_from_json(feature.at("upper")),
                     .bound_from = feature.at("tolerance").at("origin"),
                     .uncertainty = number_from_json(feature.at("expanded_uncertainty"))});
    }
    outcomes.push_back(std::move(outcome));
  }
  return outcomes;
}

/// Outcomes of a comparison.json. Throws InputError with its name.
std::vector<Outcome> compared_in(const std::string& text, const std::string& name) {
  try {
    const Json json = parse_sealed(text);
    check_comparison(json);
    return comparison_outcomes(json);
  } catch (const std::exception& problem) {
    throw json_trouble(name, text, problem, "comparison.json as palpate compare wrote it");
  }
}

/// Reads what the archive has in results/N/. Recomputes every verdict; throws InputError for a
/// verdict that its own numbers do not support.
Sources sources_in(const Files& files) {
  Sources sources;
  for (const auto& [name, bytes] : files) {
    std::vector<Outcome> outcomes;
    if (name.ends_with("/results.json")) {
      outcomes = results_from_json(bytes, name).outcomes;
    } else if (name.ends_with("/campaign.jsonl")) {
      outcomes = campaign_findings(bytes, name, sources.tested).outcomes;
    } else if (name.ends_with("/run.json")) {
      try {
        const Json domain = parse_json(bytes).at("domain");
        for (const auto& [key, range] : domain.items()) {
          campaign::widen(sources.tested, {{key, {range.at(0), range.at(1)}}});
        }
      } catch (const std::exception& problem) {
        throw json_trouble(name, bytes, problem, "a run.json as palpate evidence wrote it");
      }
    } else if (name.ends_with("/comparison.json")) {
      outcomes = compared_in(bytes, name);
    } else if (name.ends_with("/summary.json")) {
      try {
        const auto trace = files.find(folder_of(name) + "/trace.h5");
        if (trace == files.end() ||
            parse_sealed(bytes).at("trace_sha256") != io::sha256(trace->second)) {
          throw std::runtime_error("is not of the same run as trace.h5 beside it");
        }
      } catch (const std::exception& problem) {
        throw json_trouble(name, bytes, problem, "summary.json as palpate run wrote it");
      }
    } else if (name == "cases.json") {
      try {
        sources.known = parse_json(bytes);
      } catch (const std::exception& problem) {
        throw json_trouble(name, bytes, problem, "as palpate evidence wrote it");
      }
    } else if (name == "qualification.json") {
      try {
        outcomes.push_back(qualification_outcome(parse_json(bytes)));
      } catch (const std::exception& problem) {
        throw json_trouble(name, bytes, problem, "as palpate evidence wrote it");
      }
    }
    for (Outcome& outcome : outcomes) {
      Outcome again = outcome;
      again.status = Status::pass;
      conclude(again);
      const bool decided = outcome.status == Status::pass;
      if (decided && again.status != Status::pass) {
        throw InputError(name + ": case " + outcome.name + " says " +
                         std::string(name_of(outcome.status)) + ", but its quantities say " +
                         std::string(name_of(again.status)) + "; results as palpate wrote them");
      }
      sources.outcomes.emplace_back(folder_of(name), std::move(outcome));
    }
  }
  return sources;
}

bool matches(const std::string& name, const std::string& pattern) {
  return name == pattern || name.starts_with(pattern + "/");
}

/// Outcomes whose names match a pattern.
std::vector<const std::pair<std::string, Outcome>*> matching(
    const Sources& sources, const std::vector<std::string>& patterns) {
  std::vector<const std::pair<std::string, Outcome>*> found;
  for (const auto& each : sources.outcomes) {
    const bool is = std::ranges::any_of(
        patterns, [&](const std::string& pattern) { return matches(each.second.name, pattern); });
    if (is) { found.push_back(&each); }
  }
  return found;
}

/// Names of the cases that the patterns select and that no result judges: they did not run, or only
/// as skipped.
std::set<std::string> not_judged(const Sources& sources, const std::vector<std::string>& patterns) {
  std::set<std::string> names;
  for (const std::string& known : sources.known) {
    const bool is = std::ranges::any_of(
        patterns, [&](const std::string& pattern) { return matches(known, pattern); });
    if (is) { names.insert(known); }
  }
  const auto found = matching(sources, patterns);
  for (const auto* each : found) {
    if (each->second.status == Status::skip) { names.insert(each->second.name); }
  }
  for (const auto* each : found) {
    if (each->second.status != Status::skip) { names.erase(each->second.name); }
  }
  return names;
}

/// shown: all selected cases were judged and pass; in part: some pass; not shown.
const char* shown_by(const Sources& sources, const std::vector<std::string>& patterns) {
  Tally sum;
  for (const auto* each : matching(sources, patterns)) { sum.add(each->second.status); }
  if (sum.holds() && not_judged(sources, patterns).empty()) { return "shown"; }
  return sum.passed > 0 ? "in part" : "not shown";
}

Json quantity_json_of(const Quantity& q) {
  return object("name", q.name, "value", q.value, "unit", q.unit, "lower", finite_or_null(q.lower),
                "upper", finite_or_null(q.upper), "bound_from", q.bound_from, "status",
                q.judged() ? name_of(q.status()) : "info");
}

/// Hash of the file with the curves of a case; empty if the archive has none.
std::string trace_hash(const Files& files, const std::string& folder, const Outcome& outcome) {
  const auto found = files.find(folder + "/traces/" + trace_file_name(outcome.name));
  return found == files.end() ? std::string() : io::sha256(found->second);
}

Json claims_json(const ReadContext& context, const Sources& sources, const Files& files) {
  const auto claim = [&](const auto* each) {
    const auto& [folder, outcome] = *each;
    return object("case", outcome.name, "claim", outcome.claim, "status", name_of(outcome.status),
                  "reason", outcome.reason(), "results", folder, "trace_sha256",
                  text_or_null(trace_hash(files, folder, outcome)), "quantities",
                  list_of(outcome.quantities, quantity_json_of));
  };
  return list_of(context.of.requirements, [&](const EvidenceRequirement& one) {
    return object("requirement", one.id, "text", one.text, "status", shown_by(sources, one.cases),
                  "not_judged", not_judged(sources, one.cases), "claims",
                  list_of(matching(sources, one.cases), claim));
  });
}

std::string csv_field(const Json& value) {
  const std::string text = value.is_string() ? value.get<std::string>()
                           : value.is_null() ? ""
                                             : value.dump();
  if (text.find_first_of(",\"\n") == std::string::npos) { return text; }
  std::string quoted = "\"";
  for (const char c : text) { quoted += c == '"' ? "\"\"" : std::string(1, c); }
  return quoted + "\"";
}

/// One row for each quantity.
std::string claims_csv(const Json& claims) {
  std::string text =
      "requirement,requirement_status,case,claim,case_status,quantity,value,unit,lower,upper,"
      "bound_from,status,results,trace_sha256\n";
  for (const Json& one : claims) {
    for (const Json& claim : one.at("claims")) {
      for (const Json& q : claim.at("quantities")) {
        std::string row;
        for (const Json& field :
             {one.at("requirement"), one.at("status"), claim.at("case"), claim.at("claim"),
              claim.at("status"), q.at("name"), q.at("value"), q.at("unit"), q.at("lower"),
              q.at("upper"), q.at("bound_from"), q.at("status"), claim.at("results"),
              claim.at("trace_sha256")}) {
          row += (row.empty() ? "" : ",") + csv_field(field);
        }
        text += row + "\n";
      }
    }
  }
  return text;
}

Json credibility_json(const ReadContext& context, const Sources& sources) {
  return list_of(credibility_items(), [&](const Credibility& item) {
    const auto found = matching(sources, item.cases);
    std::string status = shown_by(sources, item.cases);
    std::string stated;
    for (const EvidenceFactor& factor : context.of.factors) {
      if (factor.name == item.name) { stated = factor.evidence; }
    }
    // Evidence that a user states is not computed here: alone it shows a factor in part only.
    if (status == "not shown" && !stated.empty()) { status = "in part"; }
    std::set<std::string> cases;
    for (const auto* each : found) {
      cases.insert(each->second.name + ": " + std::string(name_of(each->second.status)));
    }
    return object("scheme", item.scheme, "item", item.name, "status", status, "stated", stated,
                  "remark", item.remark, "cases", cases);
  });
}

Json domain_json(const Domain& use, const Domain& tested) {
  Json json = Json::object();
  for (const char* key : {"speed_m_per_s", "depth_m", "needle_diameter_m", "youngs_modulus_pa"}) {
    const auto range = [&](const Domain& domain) {
      const auto found = domain.find(key);
      return found == domain.end() ? Json(nullptr) : Json(found->second);
    };
    json[key] = object("tested", range(tested), "use", range(use));
  }
  return json;
}

Json anomalies_json(const ReadContext& context, const Sources& sources) {
  Json json = Json::array();
  for (const std::string& each : context.of.anomalies) {
    json.push_back(object("from", "context", "text", each));
  }
  for (const auto& [folder, outcome] : sources.outcomes) {
    if (outcome.status == Status::pass) { continue; }
    json.push_back(object("from", folder, "case", outcome.name, "status", name_of(outcome.status),
                          "text", outcome.reason()));
  }
  return json;
}

/// Refuses names of the context that name nothing.
void check_names(const ReadContext& context, const Sources& sources, const std::string& file) {
  if (context.of.requirements.empty()) {
    throw InputError(file + ": no [[requirement]]; at least one, which the results are to show");
  }
  std::set<std::string> ids;
  for (const EvidenceRequirement& one : context.of.requirements) {
    if (!ids.insert(one.id).second) {
      throw InputError(file + ": requirement " + one.id + ": its id is used twice; one of its own");
    }
    if (one.cases.empty()) {
      throw InputError(file + ": requirement " + one.id + ": cases = []; at least one case");
    }
    for (const std::string& pattern : one.cases) {
      if (!matching(sources, {pattern}).empty()) { continue; }
      throw InputError(file + ": requirement " + one.id + ": no case of the results is named \"" +
                       pattern + "\"; the name of a case or of a group");
    }
  }
  for (const EvidenceFactor& factor : context.of.factors) {
    if (std::ranges::any_of(credibility_items(),
                            [&](const Credibility& item) { return factor.name == item.name; })) {
      continue;
    }
    std::string names;
    for (const Credibility& item : credibility_items()) {
      names += (names.empty() ? "\"" : ", \"") + std::string(item.name) + "\"";
    }
    throw InputError(file + ": factor.name = \"" + factor.name + "\"; one of " + names);
  }
}

/// Tables that follow from the other files of the archive. `name` names the context in messages.
Files derived_files(const Files& files, const std::string& name) {
  const Sources sources = sources_in(files);
  const io::ScratchFolder scratch;
  io::replace_file(scratch / "context.toml", files.at("context.toml"));
  const auto renamed = [&](std::string message) {
    const std::string from = (scratch / "context.toml").string();
    for (std::size_t at = message.find(from); at != std::string::npos; at = message.find(from)) {
      message.replace(at, from.size(), name);
    }
    return message;
  };
  ReadContext context;
  try {
    context = read_context(scratch / "context.toml", sources.tested);
  } catch (const InputError& problem) { throw InputError(renamed(problem.what())); }
  check_names(context, sources, name);
  const Json claims = claims_json(context, sources, files);
  return {{"claims.json", json_text(claims)},
          {"claims.csv", claims_csv(claims)},
          {"credibility.json", json_text(credibility_json(context, sources))},
          {"domain.json", json_text(domain_json(context.use, sources.tested))},
          {"anomalies.json", json_text(anomalies_json(context, sources))}};
}

// Facts of this installation.

struct Planted {
  Mutation fault;
  std::vector<std::string> cases;
};

std::vector<Planted> planted_faults() {
  return {
      {stiffer(), {"oscillator/order/rk4", "network/patch-test", "needle/chain", "tissue/cube"}},
      {lighter(), {"oscillator/order/rk4", "network/load-edges"}},
      {reversed_damping(), {"oscillator/order/leapfrog", "network/skew/26", "needle/energy"}},
      {missing_spring(), {"network/patch-test", "needle/chain"}},
      {double_steps(), {"oscillator/discrete/leapfrog", "network/load-edges", "needle/order"}},
      {not_a_number(), {"oscillator/order/rk4", "oscillator/figure-7"}},
      {late_frames(), {"oscillator/order/rk4", "oscillator/discrete/leapfrog"}},
      {harder_to_cut(), {"needle/layers", "needle/loss-of-resistance"}},
      {delayed_loop(), {"haptics/wall/passivity", "haptics/falcon/reference"}}};
}

/// Runs quick cases with planted faults on this installation.
Json qualification() {
  Json faults = Json::array();
  const std::vector<Case> cases = all_cases();
  const auto status = [&](const std::string& name, const Mutation* fault) {
    const std::vector<std::string> pattern{name};
    const Outcome outcome =
        run_case(select_cases(cases, pattern, true).front(), {.quick = true, .mutation = fault});
    return name_of(outcome.status);
  };
  for (const Planted& planted : planted_faults()) {
    for (const std::string& name : planted.cases) {
      if (interrupted) { io::end_process(interrupted_code); }
      faults.push_back(object("fault", planted.fault.name, "case", name, "without",
                              status(name, nullptr), "with", status(name, &planted.fault)));
    }
  }
  return object("program", version_text(), "code_hash", build::code_hash(), "faults", faults);
}

Json names_of_cases() {
  return list_of(all_cases(), [](const Case& each) { return each.name; });
}

/// Content of run.json: the resolved scene of a run, and the domain that the run tested.
Json run_json(const io::SceneFile& scene, const Json& summary) {
  Trace reached;
  if (summary.contains("deepest_m")) {
    reached.time = {0.0};
    reached.columns.push_back(
        {.name = "tool.depth_m", .values = {number_from_json(summary.at("deepest_m"))}});
  }
  Json domain = Json::object();
  for (const auto& [key, range] : campaign::tested_domain(scene.scene, reached)) {
    domain[key] = key == "depth_m" ? Json{0.0, range[1]} : Json{range[0], range[1]};
  }
  return object("scene", io::resolved_scene(scene), "domain", domain);
}

/// Domain of a run.json from the scene in it. The depth alone is computed again if the scene reads
/// files, which an archive does not have.
Json domain_again(const Json& run, const Json& summary) {
  const io::ScratchFolder scratch;
  io::replace_file(scratch / "scene.toml", run.at("scene").get<std::string>());
  try {
    return run_json(io::read_scene(scratch / "scene.toml", {}), summary).at("domain");
  } catch (const InputError&) {
    Json domain = run.at("domain");
    domain.erase("depth_m");
    if (summary.contains("deepest_m")) {
      domain["depth_m"] = Json{0.0, std::max(0.0, number_from_json(summary.at("deepest_m")))};
    }
    return domain;
  }
}

int note_library(dl_phdr_info* info, std::size_t, void* list) {
  if (info->dlpi_name != nullptr && *info->dlpi_name == '/') {
    static_cast<std::set<std::string>*>(list)->insert(info->dlpi_name);
  }
  return 0;
}

struct Package {
  std::string name{};
  std::string version{};
  std::string architecture{};
  std::string source{};
};

/// Debian packages of the loaded libraries, from the database of dpkg; empty without dpkg.
std::vector<Package> packages() {
  std::set<std::string> libraries;
  dl_iterate_phdr(note_library, &libraries);
  const fs::path query = timing::find_program("dpkg-query");
  if (query.empty()) { return {}; }
  std::vector<std::string> search{query.string(), "-S"};
  for (const std::string& library : libraries) {
    const fs::path real = fs::canonical(library);
    search.push_back(real.string());
    constexpr std::string_view usr = "/usr";  // packages may name the path before /lib was merged
    if (real.string().starts_with(usr)) { search.push_back(real.string().substr(usr.size())); }
  }
  std::set<std::string> names;
  std::istringstream found(timing::run_child(search, &interrupted).output);
  for (std::string line; std::getline(found, line);) {
    const std::size_t end = line.find(": /");
    if (end != std::string::npos) { names.insert(line.substr(0, end)); }
  }
  std::vector<std::string> show{query.string(), "-W", "-f",
                                "${Package}\\t${Version}\\t${Architecture}\\t${source:Package}\\n"};
  if (names.empty()) { return {}; }
  show.insert(show.end(), names.begin(), names.end());
  std::vector<Package> list;
  std::istringstream rows(timing::run_child(show, &interrupted).output);
  for (std::string line; std::getline(rows, line);) {
    Package package;
    std::istringstream parts(line);
    std::getline(parts, package.name, '\t');
    std::getline(parts, package.version, '\t');
    std::getline(parts, package.architecture, '\t');
    std::getline(parts, package.source, '\t');
    list.push_back(std::move(package));
  }
  return list;
}

std::string purl_of(const Package& package) {
  std::string version;
  for (const char c : package.version) {
    version += c == '+' ? "%2B" : c == ':' ? "%3A" : std::string(1, c);
  }
  return "pkg:deb/debian/" + package.name + "@" + version + "?arch=" + package.architecture;
}

std::string spdx(const std::vector<Package>& list,
                 const std::map<std::string, std::string>& build) {
  const auto entry_of = [](const std::string& id, const std::string& name,
                           const std::string& version, const std::string& licence) {
    return object("SPDXID", id, "name", name, "versionInfo", version, "downloadLocation",
                  "NOASSERTION", "filesAnalyzed", false, "licenseConcluded", licence,
                  "licenseDeclared", licence, "copyrightText", "NOASSERTION");
  };
  Json entries = Json::array();
  entries.push_back(
      entry_of("SPDXRef-palpate", "palpate", build.at("version"), "GPL-3.0-or-later"));
  Json relations = Json::array();
  relations.push_back(object("spdxElementId", "SPDXRef-DOCUMENT", "relationshipType", "DESCRIBES",
                             "relatedSpdxElement", "SPDXRef-palpate"));
  for (const Package& package : list) {
    std::string id = "SPDXRef-" + package.name;
    for (char& c : id) { c = c == '+' || c == '_' ? '-' : c; }
    Json each = entry_of(id, package.name, package.version, "NOASSERTION");
    Json reference = object("referenceCategory", "PACKAGE-MANAGER", "referenceType", "purl",
                            "referenceLocator", purl_of(package));
    each["externalRefs"] = Json::array({reference});
    entries.push_back(each);
    relations.push_back(object("spdxElementId", "SPDXRef-palpate", "relationshipType",
                               "DYNAMIC_LINK", "relatedSpdxElement", id));
  }
  return json_text(object("spdxVersion", "SPDX-2.3", "dataLicense", "CC0-1.0", "SPDXID",
                          "SPDXRef-DOCUMENT", "name", "palpate", "documentNamespace",
                          std::string("urn:palpate:spdx:") + build::code_hash(), "creationInfo",
                          object("created", build.at("date"), "creators",
                                 std::vector<std::string>{"Tool: palpate-" + build.at("version")}),
                          "packages", entries, "relationships", relations));
}

std::string cyclonedx(const std::vector<Package>& list,
                      const std::map<std::string, std::string>& build) {
  const auto component = [](const Package& package) {
    return object("type", "library", "name", package.name, "version", package.version, "purl",
                  purl_of(package));
  };
  return json_text(object(
      "bomFormat", "CycloneDX", "specVersion", "1.5", "version", 1, "metadata",
      object("timestamp", build.at("date"), "component",
             object("type", "application", "name", "palpate", "version", build.at("version"))),
      "components", list_of(list, component)));
}

/// Throws std::runtime_error if the two bills of materials of an archive are not those of one list
/// of packages and of the build in provenance.json.
void check_bills(const Files& files, const std::map<std::string, std::string>& build) {
  std::vector<Package> list;
  const Json bill = parse_json(files.at("bom.cyclonedx.json"));
  for (const Json& each : bill.at("components")) {
    const std::string purl = each.at("purl");
    const std::size_t at = purl.rfind("?arch=");
    require_consistent(at != std::string::npos, "bom.cyclonedx.json has the package " + purl);
    list.push_back({.name = each.at("name"),
                    .version = each.at("version"),
                    .architecture = purl.substr(at + 6)});
  }
  require_consistent(files.at("bom.cyclonedx.json") == cyclonedx(list, build),
                     "bom.cyclonedx.json is not as palpate evidence writes it for its packages and "
                     "the build in provenance.json");
  require_consistent(files.at("bom.spdx.json") == spdx(list, build),
                     "bom.spdx.json has other packages than bom.cyclonedx.json, or another build");
}

/// Throws InputError if files of an archive contradict each other: `why` begins with the file.
void check_archive(const Files& files, const std::string& name) {
  const auto require = [&name](bool holds, const std::string& why) {
    if (!holds) { throw InputError(name + ": " + why + "; an archive of palpate evidence"); }
  };
  static const std::set<std::string> on_top{
      "anomalies.json", "bom.cyclonedx.json", "bom.spdx.json",     "cases.json",
      "claims.csv",     "claims.json",        "context.toml",      "credibility.json",
      "domain.json",    "provenance.json",    "qualification.json"};
  for (const auto& [file, bytes] : files) {
    std::vector<std::string> parts;
    std::istringstream path(file);
    for (std::string part; std::getline(path, part, '/');) { parts.push_back(part); }
    static const std::set<std::string> of_results{"results.json",    "campaign.jsonl",
                                                  "comparison.json", "run.json",
                                                  "summary.json",    "trace.h5"};
    const bool in_results = parts.size() >= 3 && parts[0] == "results" &&
                            parts[1].find_first_not_of("0123456789") == std::string::npos;
    const bool known =
        on_top.contains(file) ||
        (in_results && parts.size() == 3 && of_results.contains(parts[2])) ||
        (in_results && parts.size() == 4 && parts[2] == "traces" && parts[3].ends_with(".h5"));
    require(known, "has the file " + io::printable(file));
    if (file.ends_with("/run.json") || file.ends_with("/summary.json")) {
      const std::string folder = folder_of(file);
      for (const char* other : {"/run.json", "/summary.json", "/trace.h5"}) {
        require(files.contains(folder + other), folder + " has no " + (other + 1));
      }
    }
  }
  try {
    const Json provenance = parse_json(files.at("provenance.json"));
    const Json qualified = parse_json(files.at("qualification.json"));
    const std::string code = provenance.at("code_hash");
    require(qualified.at("code_hash") == code,
            "qualification.json is of other code than provenance.json");
    std::set<std::string> hashed;
    for (const Json& input : provenance.at("inputs")) {
      if (input.at("file").is_null()) { continue; }
      const auto file = files.find(input.at("file").get<std::string>());
      if (file != files.end()) { hashed.insert(file->first); }
      require(file != files.end() && io::sha256(file->second) == input.at("sha256"),
              "provenance.json has another hash of " + input.at("file").dump());
    }
    for (const auto& [file, bytes] : files) {
      const bool given =
          (file.starts_with("results/") && !file.ends_with("/run.json")) || file == "context.toml";
      require(!given || hashed.contains(file), "provenance.json has no hash of " + file);
      if (!file.ends_with("/summary.json")) { continue; }
      const Json summary = parse_sealed(bytes);
      const io::ScratchFolder scratch;
      io::replace_file(scratch / "trace.h5", files.at(folder_of(file) + "/trace.h5"));
      try {
        check_summary(summary, io::read_trace_hdf5(scratch / "trace.h5"));
      } catch (const std::exception& problem) {
        require(false, file + ": " + std::string(problem.what()));
      }
      const Json run = parse_json(files.at(folder_of(file) + "/run.json"));
      require(summary.at("status") == "ok", file + " is of a run that did not end well");
      require(nlohmann::json(run.at("domain")) == nlohmann::json(domain_again(run, summary)),
              folder_of(file) + "/run.json has another domain than its scene and summary.json");
    }
    if (code != build::code_hash()) { return; }
    check_bills(files, provenance.at("build").get<std::map<std::string, std::string>>());
    require(parse_json(files.at("cases.json")) == names_of_cases(),
            "cases.json does not have the cases of its program");
    Json planted = Json::array();
    for (const Planted& each : planted_faults()) {
      for (const std::string& of : each.cases) { planted.push_back(Json{each.fault.name, of}); }
    }
    const Json found = list_of(qualified.at("faults"), [](const Json& each) {
      return Json{each.at("fault"), each.at("case")};
    });
    require(found == planted, "qualification.json does not have the faults of its program");
  } catch (const InputError&) { throw; } catch (const std::exception& problem) {
    throw json_trouble(name, {}, problem, "an archive as palpate evidence wrote it");
  }
}

// Collection of results.

/// Input of an archive, to find out later whether it changed.
struct Input {
  std::string file{};  ///< name in the archive; empty: not in it
  fs::path path{};
  std::string sha256{};
};

void add_file(Files& files, const std::string& name, const fs::path& path,
              std::vector<Input>& inputs) {
  files[name] = io::read_bytes(path, most_file_bytes);
  inputs.push_back({name, fs::absolute(path).lexically_normal(), io::sha256(files[name])});
}

/// Adds files that results were made from and that the archive does not have. Throws InputError if
/// one is not as it was.
void add_sources(const std::vector<std::pair<fs::path, std::string>>& sources,
                 const fs::path& results, std::vector<Input>& inputs) {
  if (const std::string file = changed_file(sources); !file.empty()) {
    throw InputError(file + ": gone or changed since " + results.string() +
                     " was made; make it again");
  }
  for (const auto& [file, hash] : sources) {
    inputs.push_back({{}, fs::absolute(file).lexically_normal(), hash});
  }
}

/// Adds a folder with results.json, a run folder, or a merged campaign.
void add_results(Files& files, const std::string& folder, const fs::path& path,
                 std::vector<Input>& inputs) {
  if (fs::is_regular_file(path)) {
    add_file(files, folder + "/campaign.jsonl", path, inputs);
    Domain domain;  // refuses a file that was edited by its own name
    const std::string& text = files.at(folder + "/campaign.jsonl");
    (void)campaign_findings(text, path.string(), domain);
    add_sources(files_of_campaign(text.substr(0, text.find('\n')), path.string()), path, inputs);
    return;
  }
  if (fs::exists(path / "comparison.json") && !fs::exists(path / "results.json")) {
    const fs::path file = path / "comparison.json";
    add_file(files, folder + "/comparison.json", file, inputs);
    (void)compared_in(files.at(folder + "/comparison.json"), file.string());
    return;
  }
  if (!is_run_folder(path)) {
    const Results results = read_results_folder(path);  // refuses damaged traces
    add_file(files, folder + "/results.json", path / "results.json", inputs);
    for (const Outcome& outcome : results.outcomes) {
      if (outcome.figures.empty()) { continue; }
      const std::string name = trace_file_name(outcome.name);
      add_file(files, folder + "/traces/" + name, path / "traces" / name, inputs);
    }
    return;
  }
  const Outcome run = read_run_folder(path).outcomes.at(0);
  if (run.status == Status::error) {
    throw InputError(path.string() + ": " + run.reason() + "; a run that ended well");
  }
  const auto given = inputs_of_run(path);
  const std::string scene_file = entry(given, "scene_file");
  std::vector<std::string> overrides;
  std::istringstream lines(entry(given, "overrides"));
  for (std::string line; std::getline(lines, line);) { overrides.push_back(line); }
  const io::SceneFile scene = io::read_scene(scene_file, overrides);
  add_sources(files_of_run(given), path, inputs);
  const Json summary = parse_json(io::read_text(path / "summary.json", most_file_bytes));
  if (summary.at("status") != "ok") {
    throw InputError(path.string() + ": the run is " + summary.at("status").dump() +
                     "; a run with the status ok");
  }
  add_file(files, folder + "/trace.h5", path / "trace.h5", inputs);
  add_file(files, folder + "/summary.json", path / "summary.json", inputs);
  files[folder + "/run.json"] = json_text(run_json(scene, summary));
}

struct EvidenceOptions : CommonOptions {
  std::vector<fs::path> results{};
  fs::path context{};
  fs::path key{};
};

int run_evidence(const EvidenceOptions& options) {
  const auto is_archive = [](std::string_view start) {
    constexpr std::size_t name_at = 30;  // of the first file, in the order of their names
    return start.starts_with("PK\3\4") && start.size() > name_at &&
           start.substr(name_at).starts_with("anomalies.json");
  };
  refuse_to_replace(options.out, is_archive, "an archive");
  // Refuses a wrong key before the work.
  (void)evidence::statement_over({}, evidence::evidence_predicate, "{}", options.key);
  std::vector<Input> inputs;
  Files files;
  for (std::size_t n = 0; n < options.results.size(); ++n) {
    add_results(files, "results/" + std::to_string(n + 1), options.results[n], inputs);
  }
  add_file(files, "context.toml", options.context, inputs);
  files["cases.json"] = json_text(names_of_cases());
  // Refuses a context outside the domain before the faults are planted, which takes longer.
  (void)derived_files(files, options.context.string());
  const auto build = build_provenance();
  files["qualification.json"] = json_text(qualification());
  const std::vector<Package> list = packages();
  files["bom.spdx.json"] = spdx(list, build);
  files["bom.cyclonedx.json"] = cyclonedx(list, build);
  Json provenance = object("program", version_text(), "code_hash", build::code_hash(), "command",
                           options.command, "build", build);
  provenance["inputs"] = list_of(inputs, [](const Input& input) {
    return object("file", text_or_null(input.file), "path", input.path.string(), "sha256",
                  input.sha256);
  });
  files["provenance.json"] = json_text(provenance);
  const Files derived = derived_files(files, options.context.string());
  files.insert(derived.begin(), derived.end());
  files[statement_name] = evidence::statement_over(
      files, evidence::evidence_predicate,
      object("program", version_text(), "code_hash", build::code_hash(), "date", build.at("date"))
          .dump(),
      options.key);
  const std::string zip = evidence::to_zip(files);
  refuse_input(options.out);
  make_folder_of(options.out);
  io::replace_file(options.out, zip);
  std::size_t shown = 0;
  std::size_t all = 0;
  for (const Json& one : parse_json(files.at("claims.json"))) {
    ++all;
    shown += one.at("status") == "shown" ? 1 : 0;
  }
  const bool qualified =
      qualification_outcome(parse_json(files.at("qualification.json"))).status == Status::pass;
  std::printf("%zu of %zu requirements shown; planted faults %s; %s; %s\n", shown, all,
              qualified ? "found" : "missed", options.key.empty() ? "not signed" : "signed",
              io::printable(options.out.string()).c_str());
  return shown == all && qualified ? done : fell_short;
}

// Verification.

struct VerifyOptions : CommonOptions {
  fs::path file{};
  fs::path key{};
};

/// Prints inputs of the archive that are on this machine and have changed. Returns their number.
std::size_t tell_out_of_date(const Json& provenance) {
  std::size_t changed = 0;
  for (const Json& input : provenance.at("inputs")) {
    const fs::path path = input.at("path").get<std::string>();
    std::error_code absent;
    if (!fs::is_regular_file(path, absent)) { continue; }
    std::string now;
    try {
      now = io::sha256_of_file(path);
    } catch (const InputError&) { continue; }
    if (now == input.at("sha256").get<std::string>()) { continue; }
    ++changed;
    std::printf("out of date: %s changed since the evidence was made\n",
                io::printable(path.string()).c_str());
  }
  if (provenance.at("code_hash") != build::code_hash()) {
    std::printf("made by other code: %s; this program is %s\n",
                io::printable(provenance.at("program").get<std::string>()).c_str(),
                version_text().c_str());
  }
  return changed;
}

int run_verify(const VerifyOptions& options) {
  constexpr std::size_t most_bytes = std::size_t{1} << 30U;
  const std::string name = options.file.string();
  Files files = evidence::from_zip(io::read_bytes(options.file, most_bytes), name);
  for (const char* needed : {"context.toml", "cases.json", "provenance.json", "qualification.json",
                             "bom.spdx.json", "bom.cyclonedx.json", statement_name}) {
    if (files.contains(needed)) { continue; }
    throw InputError(name + ": has no " + needed + "; an archive of palpate evidence");
  }
  const std::string statement = files.extract(statement_name).mapped();
  const evidence::CheckedStatement checked = evidence::check_statement(
      statement, evidence::evidence_predicate, files, options.key, name + ": " + statement_name);
  check_archive(files, name);
  Files sources = files;
  const std::array tables{"claims.json", "claims.csv", "credibility.json", "domain.json",
                          "anomalies.json"};
  for (const char* table : tables) { sources.erase(table); }
  const Files derived = derived_files(sources, name + ": context.toml");
  for (const char* table : tables) {
    const auto found = files.find(table);
    if (found != files.end() && found->second == derived.at(table)) { continue; }
    throw InputError(name + ": " + table +
                     " does not follow from the results in it; an archive of "
                     "palpate evidence, verified by a program of its version");
  }
  std::size_t changed = 0;
  std::size_t shown = 0;
  std::size_t all = 0;
  try {
    changed = tell_out_of_date(parse_json(files.at("provenance.json")));
    for (const Json& one : parse_json(derived.at("claims.json"))) {
      ++all;
      const auto status = one.at("status").get<std::string>();
      shown += status == "shown" ? 1 : 0;
      if (!options.quiet) {
        std::printf("%-10s %s: %s\n", status.c_str(),
                    io::printable(one.at("requirement").get<std::string>()).c_str(),
                    io::printable(one.at("text").get<std::string>()).c_str());
        for (const Json& absent : one.at("not_judged")) {
          std::printf("           not judged: %s\n",
                      io::printable(absent.get<std::string>()).c_str());
        }
      }
    }
  } catch (const nlohmann::json::exception& problem) {
    throw json_trouble(name + ": provenance.json", files.at("provenance.json"), problem,
                       "as palpate evidence wrote it");
  }
  const bool qualified =
      qualification_outcome(parse_json(files.at("qualification.json"))).status == Status::pass;
  std::printf(
      "unchanged; %s; verdicts recomputed: %zu of %zu requirements shown; planted faults "
      "%s\n",
      checked.signature_checked ? "signature of this key"
      : checked.key_id.empty()  ? "not signed"
                                : "signature not checked (--key)",
      shown, all, qualified ? "found" : "missed");
  return changed == 0 && shown == all && qualified ? done : fell_short;
}

}  // namespace

void add_evidence(Program& program) {
  const auto [command, options] = add_command(
      program, "evidence", "pack results and their context of use into one archive", run_evidence);
  command.remove_option(command.get_option("--out"));
  add_value(command, "-o,--out", options.out, "FILE", "archive (ZIP)")->required();
  add_value(command, "results", options.results, "RESULTS",
            "folders of validate, compare, campaign report or run, or merged campaigns")
      ->required();
  add_value(command, "--context", options.context, "FILE",
            "context of use (TOML, docs/evidence.md)")
      ->required();
  add_value(command, "--key", options.key, "FILE", "Ed25519 private key (PEM) that signs it");
  command.footer(
      "Exit codes: 0 every requirement is shown and every planted fault found, 1 not so "
      "(written),\n2 bad input, also a context outside the tested domain (nothing "
      "written).");
}

void add_verify(Program& program) {
  const auto [command, options] =
      add_command(program, "verify", "check an archive of evidence", run_verify);
  add_value(command, "file", options.file, "FILE", "archive of palpate evidence")->required();
  add_value(command, "--key", options.key, "PUB",
            "Ed25519 public key (PEM) that must have signed it");
  writes_nothing(command);
  command.footer(
      "Exit codes: 0 unchanged and all requirements shown, 1 a requirement is not shown "
      "or an input on\nthis machine changed, 2 changed, damaged or not signed by the "
      "key.");
}

}  // namespace palpate::cli
