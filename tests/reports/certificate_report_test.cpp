// SPDX-License-Identifier: MIT

#include "reports/certificate_report.hpp"

#include <nlohmann/json.hpp>

#include "fixtures/io/file_bytes.hpp"
#include "reports/results/results_json.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::certificate;
using namespace palpate;
using Json = nlohmann::json;

CertificateReport sample(long scene_misses) {
  CertificateReport report{.file = "scene.toml",
                           .title = "A scene <with> signs",
                           .not_counted = "valgrind is not installed",
                           .command = "palpate certify scene.toml"};
  report.resolved_scene = "[simulation]\nstep = 0.001\nduration = 3.0\n";
  report.scene_hash = io::sha256(report.resolved_scene + "\n" + report.code_hash);
  Certificate& all = report.result;
  all.claim = {.rate = 1000.0, .deadline = 1e-3, .duration = 2.0, .max_miss_rate = 2e-3};
  all.budget.happenings = {{.tick = 700, .happening = {.time = 0.7, .event = ToolEvent::puncture}},
                           {.tick = 2000, .happening = {.time = 2.0}}};
  all.budget.probes = {{.name = "first tick",
                        .what = "the first",
                        .processor = 4e-4,
                        .wall = 5e-4,
                        .repetitions = 3,
                        .ticks = 1}};
  for (const char* name : {"costliest tick", "puncture", "contact", "cold caches"}) {
    all.budget.probes.push_back(all.budget.probes.front());
    all.budget.probes.back().name = name;
  }
  LoadResult& load = all.loads.emplace_back("idle", 1e-3);
  for (long n = 0; n < 2000; ++n) {
    const double due = 1e-3 * static_cast<double>(n);
    load.control.record.add({.due = due, .begin = due + 5.5e-6, .end = due + 6.5e-6}, {});
    load.scene.record.add(
        {.due = due, .begin = due + 5.5e-6, .end = due + (n < scene_misses ? 1.5003e-3 : 3.002e-4)},
        {.scene_time = due, .happening = ToolHappening{.event = ToolEvent::puncture}});
  }
  load.control.seconds = load.scene.seconds = 2.0;
  load.tail.refusal = "too few ticks";
  report.environment = {{"kernel", "kernel", std::string("6.1")},
                        {"scheduling", "scheduling", std::string("SCHED_FIFO, priority 80")},
                        {"memory", "memory", std::string("locked, stack touched")},
                        {"smt", "two threads a core", false},
                        {"turbo", "turbo", {}},
                        {"clock_resolution_ns", "clock resolution (ns)", 1.0}};
  return report;
}

TEST("the keys that others read are there, with their units") {
  const Json json = Json::parse(to_json(sample(0)));
  CHECK(json["verdict"] == "certified");
  CHECK_NEAR(json["rate_hz"].get<double>(), 1000.0, 0.0);
  CHECK_NEAR(json["deadline_us"].get<double>(), 1000.0, 1e-9);
  CHECK(json["ticks"] == 2000);
  CHECK(json["misses"] == 0);
  CHECK(json["longest_miss_run"] == 0);
  CHECK_NEAR(json["miss_probability_upper_95"].get<double>(), 1.0 - std::pow(0.05, 1.0 / 2000.0),
             1e-15);
  for (const char* key : {"p50", "p99.9", "max"}) {  // the end of the bin, at most the maximum
    CHECK_NEAR(json["response_us"][key].get<double>(), 300.2, 1e-3);
  }
  CHECK(json["response_us"]["p99.99"].is_null());  // 2000 ticks
  CHECK_NEAR(json["control"]["wakeup_us"]["max"].get<double>(), 5.5, 1e-3);
  CHECK(json["response_us"]["max_at_event"] == "puncture");
  CHECK(json["tail"]["refused"] == "too few ticks");
  CHECK(json["compute_budget"]["worst_instructions"].is_null());
  CHECK(json["compute_budget"]["not_counted"] == "valgrind is not installed");
  CertificateReport counted = sample(0);
  counted.result.budget.worst_instructions = 1234567;
  const Json budget = Json::parse(to_json(counted))["compute_budget"];
  CHECK(budget["worst_instructions"] == 1234567);
  CHECK(budget["not_counted"].is_null());
  CHECK(json["missed_tick"].is_null());
  const Json& environment = json["environment"];
  CHECK(environment["kernel"] == "6.1");
  CHECK(environment["smt"] == false);
  CHECK(environment["turbo"].is_null());  // the system does not say
  CHECK_NEAR(environment["clock_resolution_ns"].get<double>(), 1.0, 0.0);
}

TEST("the evidence is listed: ticks needed, events, inputs and hashes of what ran") {
  CertificateReport report = sample(0);
  report.inputs = {{"scene.toml", "aa"}, {"nodes.csv", "bb"}};
  report.nodes = 27;
  report.code_hash = "cc";
  const Json json = Json::parse(to_json(report));
  CHECK_NEAR(json["max_miss_rate"].get<double>(), 2e-3, 0.0);
  CHECK(json["ticks_needed"] == certificate::ticks_needed(2e-3));
  CHECK(json["events"].size() == 2);
  CHECK(json["events"][0]["event"] == "puncture");
  CHECK(json["events"][0]["tick"] == 700);
  CHECK(json["events"][0]["in_loop"] == true);
  CHECK(json["events"][1]["in_loop"] == false);  // the loop ended at tick 1999
  CHECK(json["events_absent"].empty());
  CHECK(json["inputs"][1]["file"] == "nodes.csv");
  CHECK(json["inputs"][1]["sha256"] == "bb");
  CHECK(json["nodes"] == 27);
  CHECK(json["code_hash"] == "cc");
  CHECK(json["subject_sha256"].is_null());
  report.result.budget.absent = {"contact"};
  const Json absent = Json::parse(to_json(report));
  CHECK(absent["events_absent"][0] == "contact");
  CHECK(absent["verdict"] == "not certified");
}

TEST("the seal is the hash of the file with zeros in its place, and covers the histogram") {
  const CertificateReport report = sample(0);
  const std::string text = to_json(report);
  const Json json = Json::parse(text);
  const std::string seal = json["seal"];
  std::string zeroed = text;
  zeroed.replace(zeroed.rfind(seal), seal.size(), std::string(64, '0'));
  CHECK(seal == io::sha256(zeroed));
  CHECK(json["histogram_sha256"] == io::sha256(to_csv(report)));
  CHECK(Json::parse(to_json(sample(2)))["histogram_sha256"] != json["histogram_sha256"]);
  CertificateReport other = report;
  other.program_hash = "dd";
  CHECK(Json::parse(to_json(other))["seal"] != seal);
}

TEST("a certificate or a histogram that was changed is refused, and an unchanged one is read") {
  const CertificateReport report = sample(0);
  const std::string text = to_json(report);
  const std::string histogram = to_csv(report);
  const SealedVerdict sealed = verified_certificate(text, histogram, "c.json");
  CHECK(sealed.verdict == "certified");
  CHECK(sealed.reason == std::string(Json::parse(text)["reason"]));
  const auto refused = [&](const std::string& part, const std::string& other) {
    std::string changed = text;
    changed.replace(changed.find(part), part.size(), other);
    CHECK(changed != text);
    CHECK_THROWS_AS(InputError, verified_certificate(changed, histogram, "c.json"), "was changed");
  };
  refused("\"certified\"", "\"environment not qualified\"");
  refused("\"misses\": 0", "\"misses\": 1");
  refused("\"seal\": \"", "\"seal\": \"0");
  CHECK_THROWS_AS(InputError, verified_certificate(text + "\n", histogram, "c.json"),
                  "was changed");
  CHECK_THROWS_AS(InputError, verified_certificate(text, histogram + "\n", "c.json"),
                  "c.json: histogram.csv");
  CHECK_THROWS_AS(InputError, verified_certificate("{}", histogram, "c.json"), "has no seal");
  CHECK_THROWS_AS(InputError, verified_certificate(text.substr(0, 100), histogram, "c.json"),
                  "c.json");
}

TEST("a loop that began the scene again has less time than its ticks have periods") {
  CertificateReport report = sample(0);
  report.result.loads.front().scene.restarts = 9;
  report.result.loads.front().scene.seconds = 1.995;
  const std::string histogram = to_csv(report);
  CHECK(verified_certificate(sealed_text(Json::parse(to_json(report)), 2), histogram, "c.json")
            .verdict == "certified");
}

TEST("a certificate of a loop that was interrupted before it began is read") {
  CertificateReport report = sample(0);
  report.result.loads.clear();
  report.result.interrupted = true;
  const std::string histogram = to_csv(report);
  CHECK(verified_certificate(sealed_text(Json::parse(to_json(report)), 2), histogram, "c.json")
            .verdict == "environment not qualified");
}

/// Checks that a certificate is refused after a change, sealed again with a histogram.
void refuses(const std::string& text, const std::function<void(Json&)>& change, const char* message,
             const std::string& histogram) {
  Json json = Json::parse(text);
  change(json);
  json["histogram_sha256"] = io::sha256(histogram);
  check::row = message;
  CHECK_THROWS_AS(InputError, verified_certificate(sealed_text(json, 2), histogram, "c.json"),
                  message);
}

TEST("a certificate that contradicts itself is refused although its seal fits") {
  const std::string text = to_json(sample(0));
  const auto refused = [&](const std::function<void(Json&)>& change, const char* message,
                           const std::string& histogram = to_csv(sample(0))) {
    refuses(text, change, message, histogram);
  };
  const auto of_scene = [](Json& json, const char* key, const Json& value) {
    json[key] = value;
    json["loads"][0]["scene"][key] = value;
  };
  CHECK(verified_certificate(sealed_text(Json::parse(text), 2), to_csv(sample(0)), "c.json")
            .verdict == "certified");
  refused([&](Json& json) { of_scene(json, "misses", 5000); }, "5000 misses");
  refused([&](Json& json) { of_scene(json, "misses", 1); }, "runs of 0 misses");
  refused([&](Json& json) { of_scene(json, "miss_probability_upper_95", 1e-9); },
          "miss probability");
  refused([&](Json& json) { of_scene(json, "steps", -1); }, "-1 steps");
  refused([&](Json& json) { of_scene(json, "seconds", -5.0); }, "negative seconds");
  refused([&](Json& json) { of_scene(json, "seconds", 0.5); }, "ticks within 0.5 s of 1000 Hz");
  refused([&](Json& json) { of_scene(json, "paused_s", 1e3); }, "ticks within");
  refused(
      [&](Json& json) {
        of_scene(json, "restarts", 3);
        of_scene(json, "seconds", 1.99);
      },
      "ticks within");
  refused([&](Json& json) { of_scene(json, "longest_recovery_us", 9.0); },
          "a longest recovery of 9 us");
  refused([&](Json& json) { of_scene(json, "minor_faults", -1); }, "negative minor_faults");
  refused([&](Json& json) { of_scene(json, "restarts", "none"); }, "no whole number");
  refused([](Json& json) { json["compute_budget"]["provocations"][0]["share_of_deadline"] = 9.0; },
          "share_of_deadline");
  refused([](Json& json) { json["compute_budget"]["provocations"][0]["repetitions"] = 0; },
          "without ticks");
  refused([](Json& json) { json["nodes"] = -27; }, "negative nodes");
  refused([](Json& json) { json["ticks"] = 9; }, "ticks is not that of the worst load");
  refused([](Json& json) { json["loads"][0]["control"]["ticks"] = 3; }, "empty loop");
  refused([](Json& json) { json["verdict"] = "not certified"; }, "it says \"not certified\"");
  refused([](Json& json) { json["verdict"] = "sound"; }, "it says \"sound\"");
  refused([](Json& json) { json["ticks_needed"] = 3; }, "ticks_needed");
  refused([](Json& json) { json["events_absent"].push_back("puncture"); }, "\"not certified\"");
  refused([](Json& json) { json["compute_budget"]["worst_us"] = 2000.0; }, "worst_us");
  refused(
      [](Json& json) {
        CertificateReport slow = sample(0);
        slow.result.budget.probes.front().processor = 2e-3;
        json["compute_budget"] = Json::parse(to_json(slow))["compute_budget"];
      },
      "\"not certified\"");
  refused(
      [](Json& json) {
        CertificateReport fast = sample(0);
        for (auto& probe : fast.result.budget.probes) { probe.processor = 1e-4; }
        json["compute_budget"] = Json::parse(to_json(fast))["compute_budget"];
        json["compute_budget"]["statement"] = "Whatever the environment: nothing costs anything.";
      },
      "the statement is not");
  for (const char* gone : {"first tick", "costliest tick", "cold caches", "puncture"}) {
    refused(
        [&](Json& json) {
          Json& all = json["compute_budget"]["provocations"];
          std::erase_if(all.get_ref<Json::array_t&>(),
                        [&](const Json& each) { return each["name"] == gone; });
          CertificateReport less = sample(0);
          std::erase_if(less.result.budget.probes,
                        [&](const WorstCaseProbe& each) { return each.name == gone; });
          json["compute_budget"] = Json::parse(to_json(less))["compute_budget"];
        },
        "it has no provocation");
  }
  refused([](Json& json) { json["compute_budget"]["provocations"][1]["name"] = "first tick"; },
          "given twice");
  refused([](Json& json) { json["compute_budget"]["worst_cycles"] = 3.0; }, "worst_cycles");
  refused([](Json& json) { json["compute_budget"]["deadline_cycles"] = 3.0; }, "deadline_cycles");
  refused([](Json& json) { json["command"] = "palpate certify scene.toml --load idle --load cpu"; },
          "it has 1 loads, and its command 2");
  refused([](Json& json) { json["command"] = "palpate certify scene.toml --load cpu"; },
          "its load \"idle\" is cpu in its command");
  refused([](Json& json) { json["deadline_us"] = 10.0; }, "its slowest tick took");
  refused([](Json& json) { json["environment"]["memory"] = "refused"; }, "not qualified");
  refused([](Json&) {}, "other ticks in column", to_csv(sample(0)) + "999,1,0,0,0\n");
  const std::string moved =
      "bin_start_us,wakeup,compute,response,control\n5,2000,0,0,0\n"
      "6,0,0,0,2000\n294,0,2000,0,0\n99999,0,0,2000,0\n";
  refused([](Json&) {}, "column response: the slowest", moved);
  refused([](Json& json) { json["schema"] = 2; }, "schema");
  refused([](Json& json) { json["confidence"] = 0.9999; }, "confidence");
  refused([](Json& json) { json["events_absent"] = nullptr; }, "absent events");
  refused([&](Json& json) { of_scene(json, "longest_miss_run", 7); }, "runs of 7 misses");
  refused(
      [](Json& json) {
        json["tail"]["refused"] = nullptr;
        json["tail"]["checks"] = {
            {{"value", 2.0}, {"lower", nullptr}, {"upper", 1.0}, {"holds", false}}};
      },
      "its tail");
  refused([](Json& json) { json["tail"]["refused"] = nullptr; }, "or there is none");
  refused(
      [](Json& json) {
        json["tail"]["checks"] = {
            {{"value", 2.0}, {"lower", nullptr}, {"upper", 1.0}, {"holds", true}}};
      },
      "a check of its tail");
  refused([](Json& json) { json["events"][0]["scene_s"] = 3.1; }, "in a scene of 3 s");
  refused([](Json& json) { json["events"][0]["scene_s"] = -1.0; }, "an event at −1 s");
  refused(
      [](Json& json) {
        json["subject_sha256"] = std::string(64, '1');
        json["subject_options"] = "{}";
      },
      "scene_hash");
  refused([](Json&) {}, "do not increase", to_csv(sample(0)) + "5,1,0,0,0\n");
  refused([](Json& json) { json["rate_hz"] = 500.0; }, "contradicts itself");
  refused([](Json& json) { json["duration_s"] = 3.0; }, "rate_hz and duration_s");
  refused([](Json& json) { json["resolved_scene"] = "[simulation]\nstep = 0.001\nthreads = 2\n"; },
          "scene_hash");
  refused([](Json& json) { json["code_hash"] = "ee"; }, "scene_hash");
  refused([](Json& json) { json["compute_budget"]["provocations"][0]["processor_us"] = 999.0; },
          "share_of_deadline");
  refused([](Json& json) { json["compute_budget"]["provocations"][1]["processor_us"] = 999.0; },
          "share_of_deadline");
  refused(
      [](Json& json) {
        json["compute_budget"]["provocations"][1]["processor_us"] = 999.0;
        json["compute_budget"]["provocations"][1]["share_of_deadline"] = 0.999;
      },
      "largest first");
  refused([](Json& json) { json["reason"] = "No tick of 1000000000 missed 1000 us."; }, "reason");
  refused(
      [&](Json& json) {
        Json times = json["compute_us"];
        times["p50"] = 5000.0;
        of_scene(json, "compute_us", times);
      },
      "compute_us.p50");
  refused([](Json&) {}, "no count", to_csv(sample(0)) + "999,1,x,0,0\n");
  refused(
      [&](Json& json) {
        json = Json::parse(to_json(sample(2)));  // all but two ticks took 300.2 us
        Json times = json["response_us"];
        for (const char* key : {"p50", "p90", "p99", "p99.9"}) { times[key] = 400.0; }
        of_scene(json, "response_us", times);
      },
      "column response: p50", to_csv(sample(2)));
  refused(
      [&](Json& json) {
        Json times = json["wakeup_us"];
        times["min"] = 1.0;
        of_scene(json, "wakeup_us", times);
      },
      "column wakeup: the fastest");
  const CertificateReport missed = sample(2);
  CHECK(verified_certificate(to_json(missed), to_csv(missed), "c.json").verdict == "not certified");
}

TEST("a load in quotes of the command is none of its loads") {
  CertificateReport report = sample(0);
  report.command = "palpate certify scene.toml --subject 'exec:python3 sim.py --load model.pt'";
  CHECK(verified_certificate(to_json(report), to_csv(report), "c.json").verdict == "certified");
}

TEST("each load of a certificate is compared with its columns of the histogram") {
  CertificateReport report = sample(0);
  report.command = "palpate certify scene.toml --load idle --load cpu";
  report.result.loads.push_back(report.result.loads.front());
  report.result.loads.back().load = "cpu";
  report.result.loads.back().control.record.add({.due = 2.0, .begin = 2.0, .end = 2.0}, {});
  report.result.claim.duration = 2.001;
  report.result.interrupted = true;  // during the scene under the second load
  const std::string histogram = to_csv(report);
  const std::string text = to_json(report);
  CHECK(verified_certificate(text, histogram, "c.json").verdict == "certified");
  const auto refused = [&](const std::function<void(Json&)>& change, const char* message,
                           const std::string& other) { refuses(text, change, message, other); };
  refused(
      [](Json& json) {
        for (const char* key : {"p50", "p90", "p99", "p99.9", "max"}) {
          json["loads"][1]["scene"]["compute_us"][key] = 299.0;
        }
      },
      "column compute_cpu: the slowest", histogram);
  refused([](Json& json) { json["load"] = "cpu"; }, "has the largest miss probability", histogram);
  refused([](Json& json) { json["loads"].erase(1); }, "columns of other loads", histogram);
  const std::size_t end = histogram.find('\n');
  refused([](Json&) {}, "a row of other length",
          histogram.substr(0, histogram.rfind(',', end)) + histogram.substr(end));
  report.result.loads.pop_back();
  refused([](Json&) {}, "no column wakeup_idle", to_csv(report));
}

TEST("a certificate of a needle needs the contact, and time for the way of its drive") {
  const auto verdict_of = [](const std::string& scene, ToolEvent first) {
    CertificateReport report = sample(0);
    report.resolved_scene += scene;
    report.scene_hash = io::sha256(report.resolved_scene + "\n" + report.code_hash);
    report.result.budget.happenings.front().happening.event = first;
    report.result.budget.happenings.back().happening.event = ToolEvent::puncture;
    return verified_certificate(to_json(report), to_csv(report), "c.json").verdict;
  };
  const std::string needle = "[needle]\ngauge = 18\n[drive]\nkind = \"trajectory\"\nspeed = 0.01\n";
  CHECK(verdict_of(needle, ToolEvent::contact) == "certified");
  CHECK_THROWS(verdict_of(needle, ToolEvent::puncture), "without a contact");
  CHECK(verdict_of(needle + "from = -0.001\ndepth = 0.028\n", ToolEvent::contact) == "certified");
  CHECK_THROWS(verdict_of(needle + "from = -0.001\ndepth = 0.03\n", ToolEvent::contact),
               "its scene of 3 s ends before the way of the drive, 3.1 s");
  CHECK_THROWS(
      verdict_of(needle + "depth = 0.02\nhold = 0.5\nwithdraw_speed = 0.03\n", ToolEvent::contact),
      "ends before the way of the drive");
}

TEST("bins without any tick are left out, and each column counts every tick") {
  const std::string csv = to_csv(sample(2));
  CHECK(csv ==
        "bin_start_us,wakeup,compute,response,control\n5,2000,0,0,0\n6,0,0,0,2000\n294,0,1998,0,0\n"
        "300,0,0,1998,0\n1494,0,2,0,0\n1500,0,0,2,0\n");
}

TEST("the page begins with the verdict and its reason") {
  CHECK_CONTAINS(to_html(sample(0)), "verdict pass", "<strong>Certified",
                 "Extrapolation refused: too few ticks", "A scene &lt;with&gt; signs",
                 "not counted (valgrind is not installed)");
  CHECK_CONTAINS(to_html(sample(3)), "verdict fail", "Not certified");
  CertificateReport open = sample(3);
  open.result.rights.fifo = "Operation not permitted";
  CHECK_CONTAINS(to_html(open), "verdict open");
}

TEST("a certificate without loads is complete") {
  CertificateReport report = sample(0);
  report.result.loads.clear();
  report.result.budget.probes.clear();
  const Json json = Json::parse(to_json(report));
  CHECK(json["ticks"] == 0);
  CHECK(json["response_us"].is_null());
  CHECK(json["verdict"] == "environment not qualified");
  CHECK(to_csv(report) == "bin_start_us,wakeup,compute,response,control\n");
  CHECK_CONTAINS(to_html(report), "It did not run");
}

TEST("each of several loads has its own columns after those of the worst") {
  CertificateReport report = sample(0);
  LoadResult& load = report.result.loads.emplace_back("cpu", 1e-3);
  load.scene.record.add({.due = 0.0, .begin = 1e-6, .end = 9.5e-6}, {});
  const std::string csv = to_csv(report);
  CHECK(csv.starts_with(
      "bin_start_us,wakeup,compute,response,control,wakeup_idle,compute_idle,response_idle,"
      "control_idle,wakeup_cpu,"));
  CHECK(Json::parse(to_json(report))["load"] == "cpu");  // one tick supports least
}

}  // namespace PALPATE_FILE
