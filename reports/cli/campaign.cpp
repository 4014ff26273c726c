// SPDX-License-Identifier: MIT
/// The commands `campaign`, whose jobs are runs of scenes on many machines, and `merge`, which
/// joins shards of `validate` (docs/campaigns.md).

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>
#include <thread>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/toml_file.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/results/results_json.hpp"
#include "reports/timing/child_process.hpp"
#include "validation/campaign/findings.hpp"
#include "validation/gate/gate.hpp"
#include "validation/number_text.hpp"

namespace palpate::campaign {

constexpr auto words(Method e) {
  return in_order(e, "grid", "latin-hypercube", "sobol", "saltelli");
}
constexpr auto words(Scale e) { return in_order(e, "linear", "log"); }

}  // namespace palpate::campaign

namespace palpate::cli {

/// Keys that make a patient of a scene.
struct CampaignPatient {
  std::string name{};
  std::vector<std::string> set{};  ///< "dotted.key=value"
};

struct CampaignSubject {
  std::string name{};
  std::string subject{};  ///< as --subject
  std::string options = "{}";
};

/// Content of a campaign file.
struct CampaignFile {
  campaign::Campaign of{};
  int seed = 1;
  std::vector<std::string> scenes{};
  std::vector<int> seeds{};
  std::string seed_key{};
  std::vector<CampaignPatient> patients{};
  std::vector<CampaignSubject> subjects{};
  std::vector<std::string> builds{};
  double deadline_us = 0.0;  ///< 0: no claim on time
};

}  // namespace palpate::cli

namespace palpate::io {

template <class Visitor> void fields(Visitor& v, campaign::Parameter& p) {
  v.value("key", p.key, required({}));
  v.value("values", p.values, {});
  v.value("range", p.range, {});
  v.value("count", p.count, {"", range::at_least(2)});
  v.value("scale", p.scale, {});
}
template <class Visitor> void fields(Visitor& v, campaign::Claim& c) {
  v.value("quantity", c.quantity, required({}));
  v.value("lower", c.lower, {});
  v.value("upper", c.upper, {});
  v.value("bound_from", c.bound_from, required({}));
}
template <class Visitor> void fields(Visitor& v, cli::CampaignPatient& p) {
  v.value("name", p.name, required({}));
  v.value("set", p.set, required({}));
}
template <class Visitor> void fields(Visitor& v, cli::CampaignSubject& s) {
  v.value("name", s.name, required({}));
  v.value("subject", s.subject, required({}));
  v.value("options", s.options, {});
}
template <class Visitor> void fields(Visitor& v, cli::CampaignFile& c) {
  v.value("title", c.of.title, required({}));
  v.value("scenes", c.scenes, required({}));
  v.value("method", c.of.design.method, {});
  v.value("samples", c.of.design.samples, {"", range::from_to(1, 1'000'000)});
  v.value("seed", c.seed, {"", range::non_negative});
  v.value("seeds", c.seeds, {"", range::non_negative});
  v.value("seed_key", c.seed_key, {});
  v.value("builds", c.builds, {});
  v.value("deadline_us", c.deadline_us, {"us", range::positive});
  v.list("parameter", c.of.design.parameters);
  v.list("claim", c.of.claims);
  v.list("patient", c.patients);
  v.list("subject", c.subjects);
}

}  // namespace palpate::io

namespace palpate::cli {
namespace {

namespace fs = std::filesystem;
using campaign::Campaign;
using campaign::Domain;
using campaign::JobResult;
using campaign::Method;
using campaign::Shard;
using Json = nlohmann::ordered_json;

constexpr std::size_t most_jobs = 1'000'000;
constexpr std::size_t most_plan_bytes = std::size_t{1} << 32U;
constexpr std::size_t most_result_bytes = 1U << 20U;  // of one job

// Plan.

/// Returns a key in one spelling: "load[0].end" is "load.0.end".
std::string in_one_spelling(std::string key) {
  std::erase(key, ']');
  std::ranges::replace(key, '[', '.');
  return key;
}

/// Checks what relates keys of a campaign file.
void check(const CampaignFile& file, const io::Places& places, io::Problems& problems) {
  const campaign::Design& design = file.of.design;
  const bool grid = design.method == Method::grid;
  const std::string method(
      campaign::words(Method{})[static_cast<std::size_t>(design.method)].first);
  if (file.scenes.empty() && !problems.about("scenes")) {
    problems.add(places, "scenes", "scenes = []; at least one scene file is needed");
  }
  if (!grid && design.samples == 0 && !problems.about("samples")) {
    problems.add(places, "samples", "samples is missing; method \"" + method + "\" needs it");
  }
  if (grid && design.samples > 0) {
    problems.add(places, "samples", "samples: a grid has none; use count of each parameter");
  }
  const std::size_t dimensions =
      design.parameters.size() * (design.method == Method::saltelli ? 2 : 1);
  if (!grid && (dimensions == 0 || dimensions > campaign::most_dimensions)) {
    problems.add(
        places, "parameter",
        std::to_string(design.parameters.size()) + " parameters; method \"" + method +
            "\" takes 1 to " +
            std::to_string(design.method == Method::saltelli ? campaign::most_dimensions / 2
                                                             : campaign::most_dimensions));
  }
  for (std::size_t n = 0; n < design.parameters.size(); ++n) {
    const campaign::Parameter& one = design.parameters[n];
    const std::string key = "parameter[" + std::to_string(n) + "]";
    const auto same = [&](const std::string& other) {
      return in_one_spelling(other) == in_one_spelling(one.key);
    };
    const auto first = std::ranges::find_if(design.parameters, same, &campaign::Parameter::key);
    for (const CampaignPatient& patient : file.patients) {
      for (const std::string& set : patient.set) {
        if (!same(set.substr(0, set.find('=')))) { continue; }
        problems.add(places, key + ".key",
                     key + ".key = \"" + one.key + "\" is also set by the patient \"" +
                         patient.name + "\"; one of the two");
      }
    }
    if (&*first != &one) {
      problems.add(places, key + ".key",
                   key + ".key = \"" + one.key + "\" is also that of another parameter; one each");
    }
    const bool range = one.range.size() == 2 && one.range[0] < one.range[1];
    if (!one.range.empty() && !range) {
      problems.add(places, key + ".range", key + ".range must be [lowest, highest]");
    } else if (range && one.scale == campaign::Scale::log && one.range[0] <= 0.0) {
      problems.add(places, key + ".range", key + ".range must be > 0 for scale = \"log\"");
    } else if (grid ? !one.values.empty() == (range && one.count > 0) : !range) {
      problems.add(places, key,
                   key + (grid ? " needs values, or range and count" : " needs a range"));
    } else if (!grid && (!one.values.empty() || one.count > 0)) {
      problems.add(places, key, key + ": values and count are those of method = \"grid\"");
    }
  }
  for (std::size_t n = 0; n < file.of.claims.size(); ++n) {
    const campaign::Claim& one = file.of.claims[n];
    const std::string key = "claim[" + std::to_string(n) + "]";
    if (&*std::ranges::find(file.of.claims, one.quantity, &campaign::Claim::quantity) != &one) {
      problems.add(
          places, key + ".quantity",
          key + ".quantity = \"" + one.quantity + "\" has a claim already; one with both bounds");
    }
    if (!one.lower && !one.upper) { problems.add(places, key, key + " needs lower or upper"); }
    if (one.lower && one.upper && *one.lower > *one.upper) {
      problems.add(places, key + ".lower", key + ".lower is above upper; must be <= upper");
    }
  }
  for (std::size_t n = 0; n < file.patients.size(); ++n) {
    const std::string& name = file.patients[n].name;
    if (&*std::ranges::find(file.patients, name, &CampaignPatient::name) == &file.patients[n]) {
      continue;
    }
    const std::string key = "patient[" + std::to_string(n) + "].name";
    problems.add(places, key, key + " = \"" + name + "\" is that of another patient; one each");
  }
  if (file.seeds.empty() != file.seed_key.empty()) {
    problems.add(places, file.seeds.empty() ? "seed_key" : "seeds",
                 "seeds and seed_key, the scene key that takes a seed, need each other");
  }
}

CampaignFile read_campaign(const fs::path& path) {
  io::Problems problems;
  const io::TomlDocument document = io::read_toml(path, "a campaign", {}, problems);
  CampaignFile file;
  io::TomlReader reader(document.root, "", document.places, problems,
                        [](std::string_view) { return std::string(); });
  fields(reader, file);
  reader.refuse_unknown_keys();
  check(file, document.places, problems);
  problems.throw_if_any();
  file.of.design.seed = static_cast<std::uint64_t>(file.seed);
  if (file.patients.empty()) { file.patients.emplace_back(); }
  if (file.subjects.empty()) { file.subjects.emplace_back(); }
  if (file.builds.empty()) { file.builds.emplace_back(); }
  const std::size_t seeds = std::max<std::size_t>(1, file.seeds.size());
  const std::size_t factors[] = {file.scenes.size(), file.patients.size(), seeds,
                                 file.subjects.size(), file.builds.size()};
  std::size_t jobs = std::min(most_jobs + 1, campaign::row_count(file.of.design));
  for (const std::size_t factor : factors) { jobs = std::min(most_jobs + 1, jobs * factor); }
  if (jobs > most_jobs) {
    throw InputError(path.string() + ": has more than " + std::to_string(most_jobs) +
                     " jobs; fewer samples, or several campaigns");
  }
  return file;
}

/// SHA-256 by file, of this process, so that each file is read once.
using Hashes = std::map<fs::path, std::string>;

/// Everything that the result of a job depends on. Adds the files of scene and simulator to
/// `hashes`.
std::string job_id(const io::SceneFile& scene, const std::string& subject,
                   const std::string& subject_options, const std::string& code, Hashes& hashes) {
  std::string text = "palpate job 1\n" + io::resolved_scene(scene);
  const auto hash_of_file = [&hashes](const fs::path& file) {
    std::string& hash = hashes[file];
    if (hash.empty()) { hash = io::sha256_of_file(file); }
    return hash;
  };
  for (std::size_t n = 0; n < scene.inputs.size(); ++n) {
    const std::string hash = hash_of_file(scene.inputs[n]);
    if (n > 0) { text += hash + "\n"; }  // the scene itself is resolved above
  }
  if (!subject.empty()) {
    text += subject + "\n";
    for (const fs::path& file : files_of_subject(subject)) {
      text += hash_of_file(fs::absolute(file).lexically_normal()) + "\n";
    }
    text += subject_options + "\n";
  }
  return io::sha256(text + code);
}

/// Code hash of a program; of this one if the path is empty. Throws InputError.
std::string code_of(const std::string& program) {
  if (program.empty()) { return build::code_hash(); }
  constexpr std::size_t digits = 64;
  const timing::ChildEnd end = timing::run_child({program, "campaign", "job", "--code"}, nullptr);
  const std::string code = end.output.substr(0, end.output.find('\n'));
  if (end.status == 0 && code.size() == digits) { return code; }
  throw InputError(program + ": is no palpate with campaigns" +
                   (end.last_words().empty() ? "" : ": " + end.last_words()) +
                   "; the path of such a program");
}

std::string absolute_in(const fs::path& folder, const std::string& path) {
  return path.empty() ? path : fs::absolute(folder / path).lexically_normal().string();
}

/// Joins the names that tell jobs of one row apart.
std::string group_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    if (!name.empty()) { text += (text.empty() ? "" : ", ") + name; }
  }
  return text;
}

/// Writes all jobs of a campaign, one a line, and adds the files that they are made from to
/// `hashes`.
std::string jobs_of(const CampaignFile& file, const fs::path& path, Hashes& hashes) {
  const fs::path folder = path.parent_path();
  const auto rows = campaign::rows_of(file.of.design);
  std::vector<std::string> codes;
  for (const std::string& each : file.builds) {
    const std::string program = absolute_in(folder, each);
    codes.push_back(code_of(program));
    if (!program.empty()) { hashes[program] = io::sha256_of_file(program); }
  }
  std::vector<std::optional<int>> seeds(file.seeds.begin(), file.seeds.end());
  if (seeds.empty()) { seeds.emplace_back(); }
  std::vector<Json> jobs;
  std::map<std::string, std::size_t> known;  // positions in the list
  const auto add = [&](const std::string& scene, const CampaignPatient& patient,
                       std::optional<int> seed, const CampaignSubject& subject, std::size_t build,
                       std::size_t row) {
    std::vector<std::string> set = patient.set;
    if (seed) { set.push_back(file.seed_key + "=" + std::to_string(*seed)); }
    Json values = Json::object();
    for (std::size_t k = 0; k < rows[row].size(); ++k) {
      const std::string& key = file.of.design.parameters[k].key;
      set.push_back(key + "=" + exact_number(rows[row][k]));
      values[key] = json_number(rows[row][k]);
    }
    const std::size_t number = jobs.size() + 1;
    const std::string scene_file = absolute_in(folder, scene);
    const bool is_path = subject.subject.find(':') == std::string::npos;
    const std::string carrier = subject.subject == "model" ? ""
                                : is_path                  ? absolute_in(folder, subject.subject)
                                                           : subject.subject;
    std::string id;
    try {
      id = job_id(io::read_scene(scene_file, set), carrier, subject.options, codes[build], hashes);
    } catch (const InputError& problem) {
      throw InputError(path.string() + ": job " + std::to_string(number) + ": " + problem.what());
    }
    const std::string seed_name = seed ? "seed " + std::to_string(*seed) : "";
    const std::string group =
        group_of({scene, patient.name, seed_name, subject.name, file.builds[build]});
    const auto [before, fresh] = known.emplace(id, jobs.size());
    if (!fresh && jobs[before->second].at("group") == group) {  // Sobol points may coincide
      jobs[before->second]["rows"].push_back(row);
      return;
    }
    if (!fresh) {
      throw InputError(path.string() + ": " + group + " has the inputs of job " +
                       std::to_string(before->second + 1) + " of " +
                       jobs[before->second].at("group").get<std::string>() +
                       "; each combination once");
    }
    jobs.push_back(object(
        "id", id, "scene", scene, "file", scene_file, "set", set, "carrier", carrier, "options",
        subject.options, "program", absolute_in(folder, file.builds[build]), "group", group, "rows",
        std::vector<std::size_t>{row}, "parameters", values, "deadline_us", file.deadline_us));
  };
  for (const std::string& scene : file.scenes) {
    for (const CampaignPatient& patient : file.patients) {
      for (const std::optional<int>& seed : seeds) {
        for (const CampaignSubject& subject : file.subjects) {
          for (std::size_t build = 0; build < file.builds.size(); ++build) {
            for (std::size_t row = 0; row < rows.size(); ++row) {
              if (interrupted) { io::end_process(interrupted_code); }
              add(scene, patient, seed, subject, build, row);
            }
          }
        }
      }
    }
  }
  std::string text;
  for (const Json& job : jobs) { text += job.dump() + "\n"; }
  return text;
}

/// First line of a merged file, and content of campaign.json.
Json header_of(const CampaignFile& file, const std::string& jobs, const Hashes& hashes) {
  const campaign::Design& design = file.of.design;
  const auto parameter = [](const campaign::Parameter& one) {
    return object("key", one.key, "values", one.values, "range", one.range, "count", one.count);
  };
  const auto claim = [](const campaign::Claim& one) {
    return object("quantity", one.quantity, "lower", one.lower, "upper", one.upper, "bound_from",
                  one.bound_from);
  };
  return object("campaign", file.of.title, "schema", 1, "method",
                campaign::words(Method{})[static_cast<std::size_t>(design.method)].first, "samples",
                design.samples, "parameters", list_of(design.parameters, parameter), "claims",
                list_of(file.of.claims, claim), "jobs", std::ranges::count(jobs, '\n'),
                "jobs_sha256", io::sha256(jobs), "inputs", list_of(hashes, [](const auto& each) {
                  return object("path", each.first.string(), "sha256", each.second);
                }));
}

struct PlanOptions : CommonOptions {
  fs::path file{};
};

int run_plan(const PlanOptions& options) {
  const CampaignFile file = read_campaign(options.file);
  Hashes hashes;
  const std::string jobs = jobs_of(file, options.file, hashes);
  const fs::path folder = options.make_folder({"campaign.json", "jobs.jsonl"});
  fs::create_directories(folder / "results");
  const io::WholeWrite whole;
  io::replace_file(folder / "jobs.jsonl", jobs);
  io::replace_file(folder / "campaign.json", sealed_text(header_of(file, jobs, hashes), -1));
  std::printf("%ld jobs; %s\n", static_cast<long>(std::ranges::count(jobs, '\n')),
              io::printable((folder / "jobs.jsonl").string()).c_str());
  return done;
}

// Plan folder.

struct Plan {
  fs::path folder{};
  std::string header{};             ///< campaign.json, one line
  std::vector<std::string> jobs{};  ///< lines of jobs.jsonl
  std::vector<std::string> ids{};
};

/// Returns the text after `"id":"`, of 64 digits; empty if the line does not begin so.
std::string id_in(std::string_view line) {
  constexpr std::string_view begin = "{\"id\":\"";
  constexpr std::size_t digits = 64;
  if (!line.starts_with(begin) || line.size() < begin.size() + digits) { return {}; }
  const std::string_view id = line.substr(begin.size(), digits);
  const bool hexadecimal = id.find_first_not_of("0123456789abcdef") == std::string_view::npos;
  return hexadecimal ? std::string(id) : std::string();
}

Plan read_plan(const fs::path& folder) {
  Plan plan{.folder = folder};
  const std::string jobs = io::read_text(folder / "jobs.jsonl", most_plan_bytes);
  const fs::path header = folder / "campaign.json";
  plan.header = io::read_text(header, most_result_bytes);
  const char* allowed = "as palpate campaign plan wrote it";
  try {
    if (parse_sealed(plan.header).at("jobs_sha256") != io::sha256(jobs)) {
      io::refuse_file(folder / "jobs.jsonl",
                      std::string("was changed since the plan; a file ") + allowed);
    }
  } catch (const InputError&) { throw; } catch (const std::exception& problem) {
    throw json_trouble(header.string(), plan.header, problem, std::string("a file ") + allowed);
  }
  for (std::size_t at = 0; at < jobs.size();) {
    const std::size_t end = std::min(jobs.find('\n', at), jobs.size());
    plan.jobs.push_back(jobs.substr(at, end - at));
    plan.ids.push_back(id_in(plan.jobs.back()));
    if (plan.ids.back().empty()) {
      io::refuse_file(folder / ("jobs.jsonl:" + std::to_string(plan.ids.size())),
                      std::string("has no id; a file ") + allowed);
    }
    at = end + 1;
  }
  return plan;
}

fs::path result_file(const fs::path& folder, const std::string& id) {
  return folder / "results" / (id + ".result");
}

/// Returns the line of a stored result with its line end; empty if it is missing, damaged or of
/// another job.
std::string stored_result(const fs::path& folder, const std::string& id) {
  std::string sealed;
  try {
    sealed = io::read_bytes(result_file(folder, id), most_result_bytes);
  } catch (const InputError&) { return {}; }
  if (io::check_seal(sealed) != io::Seal::intact) { return {}; }
  sealed.resize(sealed.size() - io::seal_size);
  return id_in(sealed) == id && sealed.find('\n') + 1 == sealed.size() ? sealed : std::string();
}

// One job, in a process of its own.

struct JobOptions : CommonOptions {
  std::string job{};       ///< line of jobs.jsonl
  bool code = false;       ///< print the code hash only
  bool exclusive = false;  ///< the node is qualified for timing, and runs nothing else
};

/// Replaces every number by '#', so that equal causes have equal texts.
std::string without_digits(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const bool digit = (c >= '0' && c <= '9') || (c == '.' && result.ends_with('#'));
    if (!digit) {
      result += c;
    } else if (!result.ends_with('#')) {
      result += '#';
    }
  }
  return result;
}

/// Hash of all rows and events of a trace.
std::string hash_of(const Trace& trace) {
  std::string bytes;
  const auto add = [&bytes](const std::string& name, const std::vector<double>& values) {
    bytes += name + "\n";
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  };
  add("time_s", trace.time);
  for (const Column& column : trace.columns) { add(column.name, column.values); }
  for (const TextColumn& column : trace.text_columns) {
    bytes += column.name + "\n" + join(column.values, "\n");
  }
  for (const Event& event : trace.events) {
    bytes += exact_number(event.time) + event.kind + event.detail + "\n";
  }
  return io::sha256(bytes);
}

/// Peak (largest magnitude) and last value of every column, energies, and times of first events.
Json quantities_of(const Trace& trace) {
  Json json = Json::object();
  for (const Column& column : trace.columns) {
    if (column.values.empty()) { continue; }
    const auto peak = std::ranges::max_element(
        column.values, {}, [](double v) { return std::isnan(v) ? unbounded : std::abs(v); });
    json[column.name + ".peak"] = json_number(*peak);
    json[column.name + ".final"] = json_number(column.values.back());
  }
  json["energy.final_j"] = json_number(trace.energy.final);
  json["energy.max_j"] = json_number(trace.energy.maximum);
  for (const Event& event : trace.events) {
    const std::string name = "event." + event.kind + "_s";
    if (!json.contains(name)) { json[name] = json_number(event.time); }
  }
  return json;
}

/// Judges the mean time of a tick on a node that is declared exclusive.
Json timing_of(const Trace& trace, double deadline_us, bool exclusive) {
  if (!exclusive) {
    return object("status", "not judged", "reason",
                  "the node was not declared exclusive (campaign run --exclusive)");
  }
  const double tick_us = 1e6 * trace.seconds / static_cast<double>(std::max(1L, trace.ticks));
  return object("status", tick_us <= deadline_us ? "pass" : "fail", "tick_us", tick_us);
}

/// Begins the result of a job with what names it.
Json result_of(const Json& job) {
  Json result = Json::object();
  for (const char* key : {"id", "scene", "group", "rows", "parameters"}) {
    result[key] = job.at(key);
  }
  return result;
}

std::string job_line(const Json& job, bool exclusive) {
  CommonOptions options;
  options.overrides = job.at("set").get<std::vector<std::string>>();
  const fs::path file = job.at("file").get<std::string>();
  LoadedScene loaded = load_scene(file, options, false);
  const SubjectChoice choice{.subject = job.at("carrier"), .options_json = job.at("options")};
  Hashes hashes;
  if (job_id(loaded.file, choice.subject, choice.options_json, build::code_hash(), hashes) !=
      job.at("id").get<std::string>()) {
    throw InputError(file.string() +
                     ": the scene, a file that it names, the simulator or the program changed "
                     "since the plan; plan again");
  }
  Json result = result_of(job);
  const NetworkProblem* network = loaded.network();
  add_keys(result, "nodes", network != nullptr ? network->network().node_count() : 1, "status",
           "ok", "cause", "");
  const auto fails = [&result](const std::string& cause) {
    result["status"] = "error";
    result["cause"] = without_digits(cause);
    result["quantities"] = Json::object();
  };
  SampleOptions samples{.energy_range = true};
  if (network != nullptr && !choice.foreign()) { samples.cells = &network->network(); }
  try {
    const std::unique_ptr<Subject> foreign = foreign_subject(confined(choice, options), loaded);
    const Trace trace = roll_out(foreign != nullptr ? *foreign : loaded.subject, loaded.file.scene,
                                 samples, {.stop = &interrupted});
    if (trace.interrupted) { io::end_process(interrupted_code); }
    if (trace.diverged) {
      result["status"] = "diverged";
    } else if (trace.inverted_cells > 0) {
      result["status"] = "unreliable";
      result["cause"] = "cells turned inside out";
    }
    result["trace_sha256"] = hash_of(trace);
    Json domain = Json::object();
    for (const auto& [key, range] : campaign::tested_domain(loaded.file.scene, trace)) {
      domain[key] = {range[0], range[1]};
    }
    result["domain"] = domain;
    result["quantities"] = quantities_of(trace);
    const double deadline = job.at("deadline_us");
    if (deadline > 0.0) { result["timing"] = timing_of(trace, deadline, exclusive); }
  } catch (const SubjectFailure& failure) {
    fails(failure.what());
  } catch (const InputError& problem) {
    // A scene that the simulator cannot represent; one that cannot be started here is refused.
    if (!std::string_view(problem.what()).starts_with(file.string())) { throw; }
    fails(std::string(problem.what()).substr(file.string().size() + 2));
  }
  return result.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// Parses a line of jobs.jsonl. `place` begins the message of an InputError.
Json parsed_job(const std::string& job, const std::string& place) {
  try {
    return parse_json(job);
  } catch (const std::exception& problem) {
    throw json_trouble(place, job, problem, "a line of jobs.jsonl");
  }
}

int run_job(const JobOptions& options) {
  if (options.code) {
    std::printf("%s\n", build::code_hash());
    return done;
  }
  const Json job = parsed_job(options.job, "JOB");
  try {
    std::printf("%s", job_line(job, options.exclusive).c_str());
  } catch (const nlohmann::json::exception& problem) {
    throw json_trouble("JOB", options.job, problem, "a line of jobs.jsonl");
  }
  return done;
}

// Jobs of a shard.

struct CampaignRunOptions : CommonOptions {
  fs::path folder{};
  std::string shard{};
  int jobs = 1;
  bool exclusive = false;
};

/// Work shared by the threads of a shard.
struct ShardProgress {
  std::vector<std::size_t> todo{};
  std::mutex mutex{};
  std::size_t next = 0;
  std::size_t finished = 0;
  std::size_t not_ok = 0;
  std::size_t lost = 0;   ///< ended by a signal from outside; they are run again next time
  std::string refusal{};  ///< of a job whose inputs changed
};

/// Returns the result of a job that ended without one; empty if it must be run again.
std::string line_of_failure(const std::string& job, const timing::ChildEnd& end) {
  constexpr int signal_base = 128;
  constexpr std::array own_faults{SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL};
  std::string cause;
  if (end.status > signal_base) {
    if (std::ranges::count(own_faults, end.status - signal_base) == 0) { return {}; }
    cause = std::string("the program ended by ") + strsignal(end.status - signal_base);
  } else if (end.status == fell_short) {
    cause = without_digits(end.last_words());
  } else {
    return {};
  }
  Json result = result_of(parse_json(job));
  add_keys(result, "nodes", 0, "status", "error", "cause", cause);
  result["quantities"] = Json::object();
  return result.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// Returns the program of a job; empty: this one.
std::string program_of(const std::string& job, const fs::path& file) {
  const Json json = parsed_job(job, file.string());
  if (!json.contains("program") || !json["program"].is_string()) {
    io::refuse_file(file, "a job names no program; a file as palpate campaign plan wrote it");
  }
  return json["program"];
}

void run_jobs(const CampaignRunOptions& options, const Plan& plan, ShardProgress& progress) {
  const std::string own = timing::own_program().string();
  for (;;) {
    std::size_t number = 0;
    {
      const std::scoped_lock lock(progress.mutex);
      const bool ends = progress.next == progress.todo.size() || !progress.refusal.empty();
      if (ends || interrupted) { return; }
      number = progress.todo[progress.next++];
    }
    const std::string& job = plan.jobs[number];
    std::string program = program_of(job, plan.folder / "jobs.jsonl");
    if (program.empty()) { program = own; }
    std::vector<std::string> words{program, "campaign", "job", job};
    if (options.exclusive) { words.emplace_back("--exclusive"); }
    const timing::ChildEnd end = timing::run_child(words, &interrupted);
    if (interrupted) { return; }
    std::string line = end.status == done ? end.output : line_of_failure(job, end);
    if (end.status == done && id_in(line) != plan.ids[number]) { line.clear(); }
    if (!line.empty()) {
      io::replace_file_on_disk(result_file(plan.folder, plan.ids[number]),
                               line + io::seal_of(line));
    }
    const std::scoped_lock lock(progress.mutex);
    ++progress.finished;
    if (end.status == bad_input) { progress.refusal = end.last_words(); }
    if (line.empty()) { ++progress.lost; }
    const bool ok = line.find("\"status\":\"ok\"") != std::string::npos;
    if (!line.empty() && !ok) { ++progress.not_ok; }
    if (!options.quiet) {
      std::printf("%zu/%zu job %zu %s\n", progress.finished, progress.todo.size(), number + 1,
                  line.empty() ? "lost"
                  : ok         ? "ok"
                               : "failed");
      std::fflush(stdout);
    }
  }
}

int run_campaign(const CampaignRunOptions& options) {
  keep_results_of_interrupted();
  const Plan plan = read_plan(options.folder);
  // Kept results would be those of other scenes, simulators or programs.
  if (const std::string file =
          changed_file(files_of_campaign(plan.header, (options.folder / "campaign.json").string()));
      !file.empty()) {
    io::refuse_file(file, "was changed since the plan; plan again");
  }
  const Shard shard = chosen_shard(options.shard).value_or(Shard{});
  if (options.exclusive && options.jobs > 1) {
    throw InputError("--exclusive with --jobs " + std::to_string(options.jobs) +
                     ": jobs at the same time disturb each other's timing; --jobs 1");
  }
  ShardProgress progress;
  std::size_t kept = 0;
  for (std::size_t n = 0; n < plan.ids.size(); ++n) {
    if (!shard.has(n)) { continue; }
    if (stored_result(plan.folder, plan.ids[n]).empty()) {
      progress.todo.push_back(n);
    } else {
      ++kept;
    }
  }
  fs::create_directories(plan.folder / "results");
  std::mutex failure_mutex;
  std::exception_ptr failure;
  std::vector<std::thread> threads;
  for (int n = 0; n < options.jobs; ++n) {
    threads.emplace_back([&] {
      try {
        run_jobs(options, plan, progress);
      } catch (...) {
        const std::scoped_lock lock(failure_mutex);
        failure = std::current_exception();
      }
    });
  }
  for (std::thread& thread : threads) { thread.join(); }
  if (failure) { std::rethrow_exception(failure); }
  if (!progress.refusal.empty()) { throw InputError(progress.refusal); }
  std::printf("shard %s: %zu jobs ran, %zu kept, %zu failed, %zu lost\n", shard.text().c_str(),
              progress.finished, kept, progress.not_ok, progress.lost);
  if (interrupted) { return interrupted_code; }
  return progress.lost > 0 ? fell_short : done;
}

// Content of results.

Campaign campaign_from(const Json& json) {
  Campaign of{.title = json.at("campaign")};
  if (json.at("schema") != 1) { throw std::runtime_error("unknown schema"); }
  const auto method = json.at("method").get<std::string>();
  const auto all = campaign::words(Method{});
  const auto found = std::ranges::find(all, method, &WordOf<Method>::first);
  if (found == all.end()) { throw std::runtime_error("unknown method " + method); }
  of.design.method = found->second;
  of.design.samples = whole_from_json<int>(json.at("samples"));
  if (of.design.samples < 0 || static_cast<std::size_t>(of.design.samples) > most_jobs) {
    throw std::runtime_error("samples = " + json.at("samples").dump());
  }
  for (const Json& each : json.at("parameters")) {
    of.design.parameters.push_back({.key = each.at("key"),
                                    .values = each.at("values"),
                                    .range = each.at("range"),
                                    .count = whole_from_json<int>(each.at("count"))});
  }
  const auto limit = [](const Json& value) {
    return value.is_null() ? std::nullopt : std::optional(number_from_json(value));
  };
  for (const Json& each : json.at("claims")) {
    of.claims.push_back({.quantity = each.at("quantity"),
                         .lower = limit(each.at("lower")),
                         .upper = limit(each.at("upper")),
                         .bound_from = each.at("bound_from")});
  }
  return of;
}

JobResult job_from(const Json& json, std::size_t rows) {
  JobResult job{.id = json.at("id"),
                .scene = json.at("scene"),
                .group = json.at("group"),
                .nodes = whole_from_json<long>(json.at("nodes")),
                .status = json.at("status"),
                .cause = json.at("cause")};
  for (const Json& row : json.at("rows")) { job.rows.push_back(whole_from_json<std::size_t>(row)); }
  if (std::ranges::any_of(job.rows, [rows](std::size_t row) { return row >= rows; })) {
    throw std::runtime_error("rows = " + json.at("rows").dump());
  }
  for (const auto& [name, value] : json.at("quantities").items()) {
    job.quantities.emplace(name, number_from_json(value));
  }
  const Json domain = json.value("domain", Json::object());
  for (const auto& [key, range] : domain.items()) { job.domain[key] = {range.at(0), range.at(1)}; }
  if (json.contains("timing")) {
    job.timing = json.at("timing").at("status");
    job.timing_reason = json.at("timing").value("reason", "");
  }
  return job;
}

/// Throws std::runtime_error if the tested domain of a result is not that of one scene with these
/// values of parameters.
void check_domain(const campaign::Domain& domain, const Json& values) {
  constexpr double rounding = 1e-9;
  for (const auto& [key, parameter] : {std::pair{"speed_m_per_s", "drive.speed"},
                                       std::pair{"needle_diameter_m", "needle.diameter"}}) {
    const auto found = domain.find(key);
    if (found == domain.end()) { continue; }
    const auto [low, high] = found->second;
    const double value = values.contains(parameter) ? number_from_json(values.at(parameter)) : low;
    if (low == high && std::abs(value - low) <= rounding * low) { continue; }
    throw std::runtime_error("domain." + std::string(key) + " = " + short_number(low) + " to " +
                             short_number(high) + ", not the one " + parameter + " of its scene");
  }
}

/// Throws std::runtime_error if the numbers of a result contradict each other, or the parameters
/// of its job.
void check_result(const JobResult& job, const Json& parameters) {
  static const std::set<std::string> known{"ok", "diverged", "unreliable", "error"};
  if (!known.contains(job.status)) {
    throw std::runtime_error("status = \"" + io::printable(job.status) + "\"");
  }
  if (job.nodes < 0) { throw std::runtime_error("nodes = " + std::to_string(job.nodes)); }
  check_domain(job.domain, parameters);
  for (const auto& [key, range] : job.domain) {
    if (!(range[0] <= range[1])) {
      throw std::runtime_error("domain." + io::printable(key) + " ends before it begins");
    }
  }
  const auto quantity = [&job](const char* name) {
    const auto found = job.quantities.find(name);
    return found == job.quantities.end() ? std::nullopt : std::optional(found->second);
  };
  constexpr double rounding = 1e-9;
  const auto peak_depth = quantity("tool.depth_m.peak");
  for (const auto& [key, range] : job.domain) {
    const bool beyond = key == "depth_m" && range[1] > peak_depth.value_or(0.0) * (1.0 + rounding);
    if (!(range[0] >= 0.0) || beyond) {
      throw std::runtime_error("domain." + io::printable(key) + " = " + short_number(range[0]) +
                               " to " + short_number(range[1]) +
                               (beyond ? ", beyond tool.depth_m.peak" : ""));
    }
  }
  const auto final_energy = quantity("energy.final_j");
  const auto largest_energy = quantity("energy.max_j");
  if (final_energy && largest_energy && *final_energy > *largest_energy) {
    throw std::runtime_error("energy.final_j = " + short_number(*final_energy) +
                             ", more than energy.max_j, " + short_number(*largest_energy));
  }
  if (job.status == "ok") {
    const auto smallest = quantity("tissue.smallest_jacobian.final");
    const bool inverted = smallest && *smallest <= 0.0;
    if (!job.cause.empty() || job.quantities.empty() || inverted) {
      throw std::runtime_error("status = \"ok\", but it " +
                               (inverted ? "has cells that turned inside out"
                                : job.quantities.empty()
                                    ? "has no quantities"
                                    : "names a cause: " + io::printable(job.cause)));
    }
  }
  constexpr std::string_view last = ".final";
  for (const auto& [name, value] : job.quantities) {
    if (!name.ends_with(last)) { continue; }
    const auto peak = job.quantities.find(name.substr(0, name.size() - last.size()) + ".peak");
    if (peak == job.quantities.end() ||
        std::abs(value) <= std::abs(peak->second) * (1.0 + rounding)) {
      continue;
    }
    throw std::runtime_error(io::printable(peak->first) + " = " + short_number(peak->second) +
                             ", less than the last value, " + short_number(value));
  }
}

/// Throws std::runtime_error if a result has parameters that its design cannot have.
void check_parameters(const Json& values, const campaign::Design& design) {
  require_consistent(values.size() == design.parameters.size(),
                     "parameters = " + values.dump() + ", not those of the design");
  for (const campaign::Parameter& one : design.parameters) {
    const double value = number_from_json(values.at(one.key));
    constexpr double rounding = 1e-12;  // of a power, at the ends of a logarithmic range
    const bool drawn = one.range.size() == 2 &&
                       value >= one.range[0] - rounding * std::abs(one.range[0]) &&
                       value <= one.range[1] + rounding * std::abs(one.range[1]);
    require_consistent(drawn || std::ranges::count(one.values, value) > 0,
                       "parameters." + io::printable(one.key) + " = " + short_number(value) +
                           ", which the design does not have");
  }
}

// Union of results.

struct MergeOptions : CommonOptions {
  std::vector<fs::path> folders{};
  std::size_t shards = 0;  ///< of the array expression; 0: one job a task
};

/// Returns the line without the measured time, which may differ between two runs.
std::string without_timing(const std::string& line) {
  Json json = parse_json(line);
  json.erase("timing");
  return json.dump();
}

/// Returns the result of a job in any folder; of two that differ in their time alone the first in
/// the order of bytes. Throws std::runtime_error, a determinism failure, if others differ.
std::string merged_line(const std::vector<fs::path>& folders, const std::string& id) {
  std::string best;
  fs::path from;
  for (const fs::path& folder : folders) {
    std::string line = stored_result(folder, id);
    if (line.empty() || line == best) { continue; }
    if (best.empty()) {
      best = std::move(line);
      from = folder;
      continue;
    }
    if (without_timing(line) != without_timing(best)) {
      throw std::runtime_error("determinism failure: job " + id + " has other bytes in " +
                               result_file(folder, id).string() + " than in " +
                               result_file(from, id).string());
    }
    best = std::min(best, line);
  }
  return best;
}

/// Throws std::runtime_error if a result is not one of its job.
void check_merged(const std::string& line, const std::string& job, const Campaign& of) {
  const Json result = parse_json(line);
  const Json begun = result_of(parse_json(job));
  for (const auto& [key, value] : begun.items()) {
    if (result.at(key) != value) { throw std::runtime_error(key + " is not that of its job"); }
  }
  check_result(job_from(result, campaign::row_count(of.design)), result.at("parameters"));
}

int run_merge_jobs(const MergeOptions& options) {
  if (options.out.empty()) { throw InputError("campaign merge needs --out FILE"); }
  const auto is_merged = [](std::string_view start) {
    return start.starts_with("{\"campaign\":") &&
           start.substr(0, start.find('\n')).find("\"results_sha256\":") != start.npos;
  };
  refuse_to_replace(options.out, is_merged, "a merged campaign");
  const Plan plan = read_plan(options.folders.front());
  for (const fs::path& folder : options.folders) {
    if (io::read_text(folder / "campaign.json", most_result_bytes) != plan.header) {
      io::refuse_file(folder,
                      "is of another plan than " + plan.folder.string() + "; folders of one plan");
    }
  }
  Campaign of;
  try {
    of = campaign_from(parse_json(plan.header));
  } catch (const std::exception& problem) {
    throw json_trouble((plan.folder / "campaign.json").string(), plan.header, problem,
                       "a file as palpate campaign plan wrote it");
  }
  const std::size_t shards = options.shards > 0 ? options.shards : plan.ids.size();
  std::set<std::size_t> missing;
  io::Sha256 hash;
  for (std::size_t n = 0; n < plan.ids.size(); ++n) {
    const std::string line = merged_line(options.folders, plan.ids[n]);
    hash.add(line);
    if (line.empty()) {
      missing.insert(n % shards + 1);
    } else {
      try {
        check_merged(line, plan.jobs[n], of);
      } catch (const std::exception& problem) {
        throw json_trouble("results/" + plan.ids[n] + ".result", line, problem,
                           "a result as palpate campaign run wrote it");
      }
    }
    if (interrupted) { return interrupted_code; }
  }
  if (!missing.empty()) {
    const std::vector<std::size_t> numbers(missing.begin(), missing.end());
    throw InputError(plan.folder.string() + ": results are missing; --array=" +
                     campaign::array_expression(numbers) + " of " + std::to_string(shards) +
                     (shards == 1 ? " shard" : " shards") + " makes them");
  }
  Json header = parse_json(plan.header);
  const Json inputs = header.value("inputs", Json::array());  // last, because it may be long
  header.erase("inputs");
  header.erase("seal");
  add_keys(header, "results_sha256", hash.text(), "inputs", inputs);
  std::size_t next = 0;
  bool begun = false;
  refuse_input(options.out);
  make_folder_of(options.out);
  io::replace_file(options.out, [&](std::string& part) {
    constexpr std::size_t part_bytes = 1U << 20U;
    if (!begun) { part = sealed_text(header, -1); }
    begun = true;
    while (next < plan.ids.size() && part.size() < part_bytes) {
      part += merged_line(options.folders, plan.ids[next++]);
    }
    return next < plan.ids.size();
  });
  std::printf("%zu results; %s\n", plan.ids.size(), io::printable(options.out.string()).c_str());
  return done;
}

// Progress.

struct StatusOptions : CommonOptions {
  fs::path folder{};
};

std::string duration_text(double seconds) {
  const long whole = std::lround(seconds);
  constexpr long minute = 60;
  constexpr long hour = 3600;
  if (whole < minute) { return std::to_string(whole) + " s"; }
  if (whole < hour) { return std::to_string(whole / minute) + " min"; }
  return formatted("%ld h %ld min", whole / hour, whole % hour / minute);
}

int run_status(const StatusOptions& options) {
  const Plan plan = read_plan(options.folder);
  std::size_t ok = 0;
  std::size_t failed = 0;
  std::vector<fs::file_time_type> times;
  for (const std::string& id : plan.ids) {
    const std::string line = stored_result(plan.folder, id);
    if (line.empty()) { continue; }
    ++(line.find("\"status\":\"ok\"") != std::string::npos ? ok : failed);
    std::error_code gone;
    times.push_back(fs::last_write_time(result_file(plan.folder, id), gone));
  }
  const std::size_t left = plan.ids.size() - times.size();
  std::string estimate = left == 0 ? "complete" : "time left unknown";
  std::ranges::sort(times);
  constexpr std::size_t window =
      200;  // the latest results, so that a pause does not count for long
  const std::size_t first = times.size() > window ? times.size() - window : 0;
  if (left > 0 && times.size() - first > 1) {
    const double span = std::chrono::duration<double>(times.back() - times[first]).count();
    const double each = span / static_cast<double>(times.size() - first - 1);
    estimate = "about " + duration_text(each * static_cast<double>(left)) + " left";
  }
  std::printf("%zu of %zu jobs done: %zu ok, %zu failed; %s\n", times.size(), plan.ids.size(), ok,
              failed, estimate.c_str());
  return done;
}

// Report.

struct FindingsOptions : CommonOptions {
  fs::path file{};
};

/// Throws std::runtime_error if a result has the id of another, or the trace of another with other
/// quantities.
class TwinSearch {
 public:
  void add(const Json& result) {
    const std::string id = result.at("id");
    if (!ids_.insert(id).second) { throw std::runtime_error("id " + io::printable(id) + " twice"); }
    const std::string trace = result.value("trace_sha256", "");
    std::string quantities;  // that the trace determines; energies are not in its rows
    for (const auto& [name, value] : result.at("quantities").items()) {
      if (name.starts_with("energy.")) { continue; }
      quantities += name + " " + value.dump() + "\n";
    }
    if (!trace.empty() && traces_.emplace(trace, quantities).first->second != quantities) {
      throw std::runtime_error("trace_sha256 of another job, which has other quantities");
    }
  }

 private:
  std::set<std::string> ids_{};
  std::map<std::string, std::string> traces_{};
};

/// Throws std::runtime_error unless the jobs of each group have all rows of the design, once.
void check_rows(const std::vector<JobResult>& results, std::size_t rows) {
  std::map<std::string, std::vector<std::size_t>> found;
  for (const JobResult& job : results) {
    std::vector<std::size_t>& all = found[job.group];
    all.insert(all.end(), job.rows.begin(), job.rows.end());
  }
  for (auto& [group, all] : found) {
    std::ranges::sort(all);
    const bool whole = all.size() == rows && std::ranges::adjacent_find(all) == all.end();
    if (!whole) {
      throw std::runtime_error("the jobs of \"" + io::printable(group) +
                               "\" have not every row of the design once");
    }
  }
}

/// Reads a merged file line by line. Throws InputError.
Results findings_in(std::istream& in, const std::string& name, Domain& domain) {
  Campaign of;
  std::vector<JobResult> results;
  std::size_t number = 0;
  std::size_t rows = 0;
  std::size_t jobs = 0;
  std::string hash_of_results;
  TwinSearch twins;
  io::Sha256 hash;
  const char* allowed = "a file as palpate campaign merge wrote it";
  for (std::string line; std::getline(in, line); ++number) {
    const std::string place = name + ":" + std::to_string(number + 1);
    if (line.size() > most_result_bytes) {
      throw InputError(place + ": is " + std::to_string(line.size()) + " bytes long; at most " +
                       std::to_string(most_result_bytes));
    }
    try {
      const Json json = number == 0 ? parse_sealed(line + "\n") : parse_json(line);
      if (number == 0) {
        of = campaign_from(json);
        jobs = whole_from_json<std::size_t>(json.at("jobs"));
        hash_of_results = json.at("results_sha256");
        rows = campaign::row_count(of.design);
        if (rows > most_jobs) {
          throw std::runtime_error("has more than " + std::to_string(most_jobs) + " rows");
        }
        continue;
      }
      hash.add(line + "\n");
      results.push_back(job_from(json, rows));
      check_result(results.back(), json.at("parameters"));
      twins.add(json);
      check_parameters(json.at("parameters"), of.design);
      if (results.back().status == "ok") { campaign::widen(domain, results.back().domain); }
    } catch (const std::exception& problem) { throw json_trouble(place, line, problem, allowed); }
  }
  if (number == 0 || results.size() != jobs) {
    throw InputError(name + ": has " + std::to_string(results.size()) + " of " +
                     std::to_string(jobs) + " results; " + allowed);
  }
  if (hash.text() != hash_of_results) {
    throw InputError(name + ": was changed since it was written; " + allowed);
  }
  try {
    check_rows(results, rows);
  } catch (const std::runtime_error& problem) {
    throw InputError(name + ": " + problem.what() + "; " + allowed);
  }
  return {.title = "Campaign: " + of.title, .outcomes = campaign::outcomes_of(of, results)};
}

int run_findings(const FindingsOptions& options) {
  std::ifstream in = io::open_regular(options.file, "a merged campaign");
  Domain domain;
  Results findings = findings_in(in, options.file.string(), domain);
  findings.command = options.command;
  findings.provenance = build_provenance();
  findings.provenance["campaign_sha256"] = io::sha256_of_file(options.file);
  const fs::path folder = options.make_folder(files_of_results());
  write_results_folder(folder, findings);
  for (const Outcome& outcome : findings.outcomes) {
    if (options.quiet) { break; }
    std::printf("%s  %s%s%s\n",
                in_colour(std::string(name_of(outcome.status)), outcome.status).c_str(),
                outcome.name.c_str(), outcome.reason().empty() ? "" : ": ",
                io::printable(outcome.reason()).c_str());
  }
  std::printf("%s\n", io::printable((folder / "report.html").string()).c_str());
  return tally(findings.outcomes).holds() ? done : fell_short;
}

// Shards of validate.

struct ShardsOptions : CommonOptions {
  std::vector<fs::path> folders{};
};

/// Position of each case of a shard in the selection. Throws InputError.
std::vector<std::size_t> positions_of(const Results& shard, const fs::path& folder,
                                      std::size_t total) {
  std::vector<std::size_t> positions;
  std::istringstream words(entry(shard.provenance, shard_positions_key));
  for (std::size_t position = 0; words >> position;) {
    if (position < total) { positions.push_back(position); }
  }
  if (positions.size() == shard.outcomes.size() && words.eof()) { return positions; }
  throw InputError((folder / "results.json").string() + ": has " +
                   std::to_string(shard.outcomes.size()) +
                   " cases, which are not those of its shard; a shard that ran to its end");
}

std::string comparable(const Outcome& outcome) {
  Results one{.outcomes = {outcome}};
  return to_json(without_what_varies(one));
}

int run_merge_shards(const ShardsOptions& options) {
  std::map<std::size_t, Outcome> cases;
  std::map<std::size_t, fs::path> source;
  std::set<std::size_t> shards;
  std::optional<Results> merged;
  std::size_t total = 0;
  std::size_t count = 0;
  for (const fs::path& folder : options.folders) {
    Results part = read_results_folder(folder);
    const std::string name = entry(part.provenance, shard_key);
    if (name.empty()) {
      throw InputError((folder / "results.json").string() +
                       ": is no shard; a folder of palpate validate --shard i/N");
    }
    const Shard shard = campaign::parse_shard(name, (folder / "results.json").string() + ": shard");
    const std::size_t here =
        std::strtoull(entry(part.provenance, shard_total_key).c_str(), nullptr, 10);
    if (!merged) {
      total = here;
      count = shard.count;
      merged = Results{.title = part.title, .command = part.command, .provenance = part.provenance};
    }
    for (const char* key : {"version", "commit", "compiler", "flags"}) {
      const std::string a = entry(merged->provenance, key);
      const std::string b = entry(part.provenance, key);
      if (a == b) { continue; }
      throw InputError(folder.string() + ": " + key + " is " + b + ", but " + a + " in " +
                       options.folders.front().string() + "; shards of one build");
    }
    if (here != total || shard.count != count ||
        !gate::command_problem(merged->command, part.command, false).empty()) {
      throw InputError(folder.string() + ": is a shard of `" + part.command + "` in " +
                       std::to_string(shard.count) + " shards, but " +
                       options.folders.front().string() + " of `" + merged->command + "` in " +
                       std::to_string(count) + "; shards of one run");
    }
    shards.insert(shard.index);
    const std::vector<std::size_t> positions = positions_of(part, folder, total);
    for (std::size_t n = 0; n < positions.size(); ++n) {
      const auto [found, fresh] = cases.emplace(positions[n], part.outcomes[n]);
      if (fresh) {
        source[positions[n]] = folder;
      } else if (comparable(found->second) != comparable(part.outcomes[n])) {
        throw std::runtime_error("determinism failure: case " + part.outcomes[n].name +
                                 " has other bytes in " + folder.string() + " than in " +
                                 source[positions[n]].string());
      }
    }
  }
  std::vector<std::size_t> missing;
  for (std::size_t n = 1; n <= count; ++n) {
    if (!shards.contains(n)) { missing.push_back(n); }
  }
  if (!missing.empty() || cases.size() != total) {
    throw InputError("shard " + campaign::array_expression(missing) + " of " +
                     std::to_string(count) + " is missing: " + std::to_string(cases.size()) +
                     " of " + std::to_string(total) + " cases are there; every shard");
  }
  for (auto& [position, outcome] : cases) { merged->outcomes.push_back(std::move(outcome)); }
  for (const char* key : {shard_key, shard_positions_key, shard_total_key, "not run again"}) {
    merged->provenance.erase(key);
  }
  merged->provenance["merged shards"] = std::to_string(count);
  const fs::path folder = options.make_folder(files_of_results());
  write_results_folder(folder, *merged);
  const Tally sum = tally(merged->outcomes);
  std::printf("%d passed, %d failed, %d skipped of %zu cases; %s\n", sum.passed, sum.not_passed(),
              sum.skipped, total, io::printable((folder / "report.html").string()).c_str());
  return sum.holds() ? done : fell_short;
}

const char* environment_value(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != '\0' ? value : nullptr;
}

}  // namespace

std::vector<std::pair<fs::path, std::string>> files_of_campaign(const std::string& header,
                                                                const std::string& name) {
  std::vector<std::pair<fs::path, std::string>> files;
  try {
    const Json json = parse_json(header);
    for (const Json& input : json.at("inputs")) {
      files.emplace_back(input.at("path").get<std::string>(),
                         input.at("sha256").get<std::string>());
    }
  } catch (const nlohmann::json::exception& problem) {
    throw json_trouble(name, header, problem, "as palpate campaign plan wrote it");
  }
  return files;
}

Results campaign_findings(const std::string& text, const std::string& name, Domain& domain) {
  std::istringstream in(text);
  return findings_in(in, name, domain);
}

void add_shard(CLI::App& command, std::string& shard, const std::string& items) {
  add_value(command, "--shard", shard, "i/N",
            "run every N-th of the " + items +
                " only, i from 1 to N [TEST_SHARD_INDEX and TEST_TOTAL_SHARDS, those of GTEST, or "
                "a Slurm array]");
}

std::optional<Shard> chosen_shard(const std::string& given) {
  if (!given.empty()) { return campaign::parse_shard(given, "--shard"); }
  const auto from = [](const char* index, const char* count, long first) -> std::optional<Shard> {
    const char* i = environment_value(index);
    const char* n = environment_value(count);
    const std::string both = std::string(index) + " and " + count;
    if (i == nullptr && n == nullptr) { return {}; }
    if (i == nullptr || n == nullptr) {
      throw InputError(both + ": only one of them is set; both or none, or --shard i/N");
    }
    char* end = nullptr;
    const long number = std::strtol(i, &end, 10) - first + 1;
    return campaign::parse_shard((*end != '\0' ? std::string(i) : std::to_string(number)) + "/" + n,
                                 both);
  };
  if (const auto shard = from("TEST_SHARD_INDEX", "TEST_TOTAL_SHARDS", 0)) { return shard; }
  if (const auto shard = from("GTEST_SHARD_INDEX", "GTEST_TOTAL_SHARDS", 0)) { return shard; }
  const char* first = environment_value("SLURM_ARRAY_TASK_MIN");
  const char* last = environment_value("SLURM_ARRAY_TASK_MAX");
  const char* count = environment_value("SLURM_ARRAY_TASK_COUNT");
  if (environment_value("SLURM_ARRAY_TASK_ID") == nullptr || count == nullptr) { return {}; }
  const long begin = first != nullptr ? std::strtol(first, nullptr, 10) : 0;
  const long end = last != nullptr ? std::strtol(last, nullptr, 10)
                                   : begin + std::strtol(count, nullptr, 10) - 1;
  if ((begin != 0 && begin != 1) || end - begin + 1 != std::strtol(count, nullptr, 10)) {
    throw InputError("SLURM_ARRAY_TASK_COUNT = " + std::string(count) +
                     ": the array is not 1-N or 0-N, so it does not tell the number of shards; "
                     "--shard i/N");
  }
  return from("SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", begin);
}

void add_merge(Program& program) {
  const auto [command, options] =
      add_command(program, "merge", "join the results of all shards of validate", run_merge_shards);
  add_value(command, "folders", options.folders, "DIR",
            "folders of palpate validate --shard i/N, one of each shard")
      ->required();
  command.footer(
      "Exit codes: 0 all checks pass, 1 a check failed, or two folders have other bytes "
      "for one case,\n2 a shard is missing or of another run (nothing written).");
}

void add_campaign(Program& program) {
  CLI::App* parent = program.app.add_subcommand("campaign", "many runs on many machines");
  parent->require_subcommand(1);
  {
    const auto [command, options] =
        add_command(program, "plan", "write the list of jobs of a campaign", run_plan, parent);
    add_value(command, "file", options.file, "CAMPAIGN", "campaign (TOML, docs/campaigns.md)")
        ->required();
  }
  {
    const auto [command, options] = add_command(
        program, "run", "run the jobs that have no valid result yet", run_campaign, parent);
    command.remove_option(command.get_option("--out"));  // DIR is the folder
    add_value(command, "folder", options.folder, "DIR", "folder of campaign plan")->required();
    add_shard(command, options.shard, "jobs");
    command.add_option("--jobs", options.jobs, "jobs at a time [1]")->check(CLI::Range(1, 1024));
    command.add_flag("--exclusive", options.exclusive,
                     "this node is qualified for timing and runs nothing else: judge the time of a "
                     "tick; without it the results say \"not judged\"");
  }
  {
    const auto [command, options] = add_command(
        program, "merge", "join the results of folders of one plan", run_merge_jobs, parent);
    command.remove_option(command.get_option("--out"));
    add_value(command, "-o,--out", options.out, "FILE", "merged results, JSON lines")->required();
    add_value(command, "folders", options.folders, "DIR", "folders with results")->required();
    command
        .add_option("--shards", options.shards,
                    "number of shards, for the array expression of missing results [one job "
                    "each]")
        ->check(CLI::Range(1, 1'000'000));
    command.footer(
        "Exit codes: 0 done, 1 determinism failure: one job with two results, 2 results "
        "are missing.");
  }
  {
    const auto [command, options] =
        add_command(program, "status", "jobs done and time left", run_status, parent);
    add_value(command, "folder", options.folder, "DIR", "folder of campaign plan")->required();
    writes_nothing(command);
  }
  {
    const auto [command, options] = add_command(
        program, "report", "claims, distributions, sensitivity and failures of a campaign",
        run_findings, parent);
    add_value(command, "file", options.file, "FILE", "results of campaign merge")->required();
    add_json(command, options, "results.json");
  }
  {
    const auto [command, options] =
        add_command(program, "job", "run one job and print its result", run_job, parent);
    add_value(command, "job", options.job, "JOB", "line of jobs.jsonl");
    command.add_flag("--code", options.code, "print the hash of the program's code");
    command.add_flag("--exclusive", options.exclusive, "as for run");
    writes_nothing(command);
  }
}

}  // namespace palpate::cli
