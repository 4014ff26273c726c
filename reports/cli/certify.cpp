// SPDX-License-Identifier: MIT
/// The command `certify`.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <future>
#include <map>
#include <optional>
#include <sstream>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

#include "device/real_time.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_file.hpp"
#include "model/problem/input_error.hpp"
#include "model/tissue/network_builder.hpp"
#include "reports/certificate_report.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/evidence.hpp"
#include "reports/html/html_page.hpp"
#include "reports/results/results_json.hpp"
#include "reports/timing/child_process.hpp"
#include "validation/certificate/certificate.hpp"
#include "validation/certificate/scene_loop.hpp"
#include "validation/number_text.hpp"
#include "validation/signal.hpp"

#if defined(__x86_64__)
#include <x86intrin.h>
#endif

namespace palpate::cli {
namespace {

struct CertifyOptions : CommonOptions {
  std::filesystem::path scene{};
  std::optional<double> rate{};  ///< tick rate [Hz]; empty: the rate of the scene
  double duration = 10.0;        ///< duration of each phase [s]
  double max_miss_rate = certificate::Claim{}.max_miss_rate;
  bool verify = false;               ///< `scene` is a certificate.json
  std::optional<double> deadline{};  ///< deadline [us]; empty: the period
  std::vector<std::string> loads{};  ///< load types; empty: idle
  std::filesystem::path key{};       ///< private key that signs, or the public one for --verify
  bool ordinary = false;  ///< if true, no real-time scheduling and no locked memory are requested
  SubjectChoice subject{};
};

constexpr const char* statement_file = "certificate.intoto.json";

using Value = decltype(EnvironmentFact::value);

std::string first_line(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

Value text(const std::string& found) { return found.empty() ? Value{} : Value{found}; }

/// Reads a file that contains 0 or 1.
Value yes_or_no(const std::string& file, bool yes_is_one = true) {
  const std::string found = first_line(file);
  return found.empty() ? Value{} : Value{(found == "1" || found == "Y") == yes_is_one};
}

bool has_flag(const std::string& flag) {
  std::istringstream flags(processor_line("flags"));
  for (std::string each; flags >> each;) {
    if (each == flag) { return true; }
  }
  return false;
}

std::string on_boot_line(const std::string& key) {
  std::istringstream words(first_line("/proc/cmdline"));
  for (std::string word; words >> word;) {
    if (word.starts_with(key + "=")) { return word.substr(key.size() + 1); }
  }
  return "none";
}

Value turbo() {
  const Value boost = yes_or_no("/sys/devices/system/cpu/cpufreq/boost");
  return boost.index() != 0 ? boost
                            : yes_or_no("/sys/devices/system/cpu/intel_pstate/no_turbo", false);
}

bool is_preempt_rt(const utsname& kernel) {
  return first_line("/sys/kernel/realtime") == "1" ||
         std::string(kernel.version).find("PREEMPT_RT") != std::string::npos;
}

double clock_resolution() {
  timespec resolution{};
  clock_getres(CLOCK_MONOTONIC, &resolution);
  return 1e9 * static_cast<double>(resolution.tv_sec) + static_cast<double>(resolution.tv_nsec);
}

std::string first_words(const std::string& line, int count) {
  std::istringstream in(line);
  std::string words;
  std::string word;
  for (int n = 0; n < count && in >> word; ++n) { words += (n > 0 ? " " : "") + word; }
  return words;
}

std::string granted(const std::string& what, const std::string& refusal) {
  return refusal.empty() ? what : "refused: " + refusal;
}

/// Size of the largest cache [bytes]; 32 MiB if the system does not report it.
std::size_t largest_cache() {
  constexpr long least = 1L << 20U;
  constexpr long most = 128L << 20U;
  const long found = sysconf(_SC_LEVEL3_CACHE_SIZE);
  return static_cast<std::size_t>(found <= 0 ? 32L << 20U : std::clamp(found, least, most));
}

/// Processors that the kernel command line isolates from the scheduler.
std::vector<int> isolated_processors() {
  std::vector<int> processors;
  std::istringstream parts(first_line("/sys/devices/system/cpu/isolated"));
  for (std::string part; std::getline(parts, part, ',');) {
    int first = 0;
    int last = 0;
    const int read = std::sscanf(part.c_str(), "%d-%d", &first, &last);
    for (int n = first; read >= 1 && n <= (read == 2 ? last : first); ++n) {
      processors.push_back(n);
    }
  }
  return processors;
}

/// Processor times since boot, from /proc/stat.
certificate::ProcessorTimes processor_times(int processor) {
  std::ifstream stat("/proc/stat");
  const double tick = 1.0 / static_cast<double>(sysconf(_SC_CLK_TCK));
  certificate::ProcessorTimes times;
  for (std::string line; std::getline(stat, line);) {
    if (!line.starts_with("cpu") || line[3] == ' ') {
      continue;
    }  // the first line is the sum of all
    int number = -1;
    double user = 0, nice = 0, system = 0, idle = 0, waiting = 0, hard = 0, soft = 0, stolen = 0;
    if (std::sscanf(line.c_str(), "cpu%d %lf %lf %lf %lf %lf %lf %lf %lf", &number, &user, &nice,
                    &system, &idle, &waiting, &hard, &soft, &stolen) != 9) {
      continue;
    }
    if (number == processor) {
      times.stolen = tick * stolen;
      times.interrupts = tick * (hard + soft);
    } else {
      times.others += tick * (user + nice + system + hard + soft);
    }
  }
  return times;
}

/// Rate of the time stamp counter [1/s], measured against the system clock. Empty if the counter
/// stops or has a variable rate.
std::optional<double> cycles_per_second() {
#if defined(__x86_64__)
  if (!has_flag("constant_tsc") || !has_flag("nonstop_tsc")) { return {}; }
  constexpr double enough = 0.05;  // [s]
  const double begin = device::monotonic_now();
  const auto first = __rdtsc();
  double now = begin;
  while (now - begin < enough) { now = device::monotonic_now(); }
  return static_cast<double>(__rdtsc() - first) / (now - begin);
#else
  return {};
#endif
}

/// Machine properties for the report, including the real-time rights granted to the loop.
std::vector<EnvironmentFact> environment_of(const certificate::Rights& rights, int priority,
                                            const std::optional<double>& cycles) {
  const auto build = build_provenance();
  const std::string governor =
      "/sys/devices/system/cpu/cpu" + std::to_string(rights.on) + "/cpufreq/scaling_governor";
  utsname kernel{};
  uname(&kernel);
  return {
      {"cpu", "processor", text(processor_line("model name"))},
      {"processors", "processors", static_cast<double>(sysconf(_SC_NPROCESSORS_ONLN))},
      {"microcode", "microcode", text(processor_line("microcode"))},
      {"virtualised", "virtual machine", has_flag("hypervisor")},
      {"governor", "frequency governor", text(first_line(governor))},
      {"turbo", "turbo", turbo()},
      {"smt", "two threads a core", yes_or_no("/sys/devices/system/cpu/smt/active")},
      {"cycles_per_second", "steady cycle counter (Hz)", cycles ? Value{*cycles} : Value{}},
      {"kernel", "kernel", std::string(kernel.release) + " " + kernel.version},
      {"preempt_rt", "PREEMPT_RT", is_preempt_rt(kernel)},
      {"boot_line", "boot line", text(first_line("/proc/cmdline"))},
      {"isolcpus", "isolcpus", on_boot_line("isolcpus")},
      {"nohz_full", "nohz_full", on_boot_line("nohz_full")},
      {"rt_runtime_us", "real-time share of a second (us)",
       text(first_line("/proc/sys/kernel/sched_rt_runtime_us"))},
      {"clock_source", "clock source",
       text(first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource"))},
      {"clock_resolution_ns", "clock resolution (ns)", clock_resolution()},
      {"load_average", "load average over 1, 5, 15 min",
       text(first_words(first_line("/proc/loadavg"), 3))},
      {"scheduling", "scheduling of the loop",
       granted("SCHED_FIFO, priority " + std::to_string(priority), rights.fifo)},
      {"memory", "memory", granted("locked, stack touched", rights.memory)},
      {"idle_states", "idle states", granted("none with latency", rights.idle)},
      {"processor", "loop kept to processor",
       rights.processor.empty() ? Value{static_cast<double>(rights.on)} : Value{rights.processor}},
      {"compiler", "compiler", build.at("compiler")},
      {"flags", "flags", build.at("flags")}};
}

using namespace certificate;

constexpr double least_rate = 0.01;  // [Hz]
constexpr double most_rate = 20000.0;
constexpr std::string_view costliest_tick = "costliest tick";  // as in worst_case_probe.cpp

Claim claim_of(const CertifyOptions& options, const LoadedScene& loaded) {
  const Scene& scene = loaded.file.scene;
  Claim claim{.rate = options.rate.value_or(rate_of(scene)),
              .duration = options.duration,
              .max_miss_rate = options.max_miss_rate};
  if (const std::string why = why_not_at(scene, claim.rate); !why.empty()) {
    throw InputError(loaded.file.where("simulation.step") + ": " + why);
  }
  if (!(claim.rate >= least_rate && claim.rate <= most_rate)) {
    throw InputError(loaded.file.where("simulation.step") + ": a tick a step is a rate of " +
                     plain_number(claim.rate) + " Hz; " + plain_number(least_rate) + " to " +
                     plain_number(most_rate) + " Hz");
  }
  claim.deadline = options.deadline ? *options.deadline / us : claim.period();
  if (!(claim.deadline <= claim.period() * (1.0 + 1e-9))) {
    throw InputError("--deadline " + plain_number(*options.deadline) +
                     ": longer than the period; at most " + plain_number(us * claim.period()) +
                     " us");
  }
  if (!(claim.duration * claim.rate >= 1.0 - 1e-9)) {
    throw InputError("--duration " + plain_number(options.duration) +
                     ": shorter than a period; at least " + plain_number(claim.period()) + " s");
  }
  return claim;
}

/// Stiffness of the tissue at the tool [N/m], without a device; empty if the tissue can move
/// freely.
std::optional<double> tissue_stiffness(const LoadedScene& loaded) {
  const NetworkProblem* network = loaded.network();
  const Scene& scene = loaded.file.scene;
  if (network == nullptr || (scene.drive && scene.drive->kind == Drive::Kind::falcon)) {
    return {};
  }
  const double compliance = tool_compliance(scene, *network).value_or(0.0);
  return compliance > 0.0 ? std::optional(1.0 / compliance) : std::nullopt;
}

void refuse_trace(const SubjectChoice& choice) {
  if (choice.subject.starts_with("trace:")) {
    throw InputError("--subject " + choice.subject +
                     ": a trace has no timing; a shared library (PATH.so) or exec:COMMAND");
  }
}

/// Returns what the report says about a simulator. `subject` is loaded; its empty calls are timed.
std::string subject_note(Subject& subject) {
  const SubjectFacts facts = subject.facts();
  std::string note = "The simulator is " + facts.name + " " + facts.version + ", " + facts.carrier +
                     "; a tick includes the way to it and back";
  std::vector<double> empty;
  for (int n = 0; n < 1000; ++n) { empty.push_back(us * subject.round_trip()); }
  const double median = comparison::quantile(empty, 0.5);
  if (!(median > 0.0)) { return note + "."; }
  return note + ". Control: an empty call takes " + plain_number(median, 3) +
         " us in the middle, " + plain_number(comparison::quantile(empty, 0.99), 3) +
         " us in 99 % of 1000, " + plain_number(*std::ranges::max_element(empty), 3) +
         " us at worst; it is not subtracted.";
}

CertifyPlan plan_of(const CertifyOptions& options, const LoadedScene& loaded, Progress& progress) {
  CertifyPlan plan{.claim = claim_of(options, loaded),
                   .cache_bytes = largest_cache(),
                   .isolated = isolated_processors(),
                   .tissue_stiffness = tissue_stiffness(loaded),
                   .ask_for_rights = !options.ordinary,
                   .stop = &interrupted,
                   .progress = &progress,
                   .processor_times = processor_times};
  if (options.subject.foreign()) {
    const auto file = std::make_shared<const io::SceneFile>(loaded.file);
    plan.subject = [choice = confined(options.subject, options), file] {
      return make_subject(choice, file);
    };
  }
  if (!options.loads.empty()) { plan.loads = options.loads; }
  plan.outside_load = [](const std::string&, const std::vector<int>& processors) {
    std::string list;  // loads processors, caches, memory and disk of these processors
    for (const int n : processors) { list += (list.empty() ? "" : ",") + std::to_string(n); }
    const std::string workers = std::to_string(processors.size());
    return std::make_shared<timing::Background>(std::vector<std::string>{
        "stress-ng", "--quiet", "--taskset", list, "--cpu", workers, "--cache", workers, "--vm",
        "1", "--vm-bytes", "64M", "--hdd", "1"});
  };
  return plan;
}

/// Hashes of everything that runs, and their sum.
void hash_what_runs(const CertifyOptions& options, const LoadedScene& loaded,
                    CertificateReport& report) {
  report.resolved_scene = io::resolved_scene(loaded.file);
  std::string all = report.resolved_scene;
  for (const std::filesystem::path& file : loaded.file.inputs) {
    report.inputs.push_back({file.filename().string(), io::sha256_of_file(file)});
    all += "\n" + report.inputs.back().second;
  }
  if (options.subject.foreign()) {
    report.subject_hash = hash_of_subject(options.subject.subject);
    report.subject_options = options.subject.options_json;
    all += "\n" + report.subject_hash + report.subject_options;
  }
  report.program_hash = io::sha256_of_file("/proc/self/exe");
  report.code_hash = build::code_hash();
  report.scene_hash = io::sha256(all + "\n" + report.code_hash);
  if (const NetworkProblem* network = loaded.network()) {
    report.nodes = network->network().node_count();
    report.springs = static_cast<long>(network->network().springs.size());
  }
}

/// Runs the certification on a new thread; the calling thread shows the progress.
Certificate certify_aside(const Scene& scene, const CertifyPlan& plan, bool quiet) {
  const bool show = !quiet && isatty(STDERR_FILENO) != 0;
  std::future<Certificate> work =
      std::async(std::launch::async, [&] { return certificate::certify(scene, plan); });
  while (work.wait_for(std::chrono::milliseconds(250)) != std::future_status::ready) {
    const long ticks = plan.progress->ticks;
    const double share =
        ticks > 0 ? 100.0 * static_cast<double>(plan.progress->done) / static_cast<double>(ticks)
                  : 0.0;
    if (show && ticks > 0) {
      std::fprintf(stderr, "\r\033[K%s: %3.0f %%", plan.progress->stage.load(), share);
    }
    if (show && ticks == 0) { std::fprintf(stderr, "\r\033[K%s", plan.progress->stage.load()); }
  }
  if (show) { std::fprintf(stderr, "\r\033[K"); }
  return work.get();
}

/// Counts the instructions of the slowest tick of the scene in a separate run.
void count_worst(const CertifyOptions& options, const Claim& claim, CertificateReport& report) {
  ComputeBudget& budget = report.result.budget;
  const auto worst = std::ranges::find(budget.probes, costliest_tick, &WorstCaseProbe::name);
  if (worst == budget.probes.end() || report.result.interrupted) {
    report.not_counted = report.result.interrupted ? "interrupted" : "no tick was timed";
    return;
  }
  std::vector<std::string> words{options.scene.string(), "--before",
                                 std::to_string(std::lround(worst->scene_time * claim.rate)),
                                 "--rate", exact_number(claim.rate)};
  for (const std::string& each : options.overrides) { words.insert(words.end(), {"--set", each}); }
  const timing::InstructionCount count = timing::count_steps(words, &interrupted);
  report.not_counted = count.refusal;
  if (count.refusal.empty()) { budget.worst_instructions = count.passes.front(); }
}

void tell(const CertificateReport& report, const Outcome& outcome,
          const std::filesystem::path& folder, const CommonOptions& options) {
  std::printf("%s: %s\n",
              in_colour(std::string(verdict_word(outcome.status)), outcome.status).c_str(),
              outcome.reason().c_str());
  if (options.quiet) { return; }
  std::printf("%s\n", budget_text(report.result).c_str());
  for (const NamedPhase& named : phases_of(report)) {
    const LoopRecord& record = named.phase->record;
    if (record.ticks() == 0) { continue; }
    std::printf(
        "  %-28s %9ld ticks, %ld missed; response %.1f us in the middle, %.1f us at worst\n",
        named.name.c_str(), record.ticks(), record.misses.count(),
        us * record.response.percentile(0.5).value_or(record.response.maximum()),
        us * record.response.maximum());
  }
  std::printf("%s\n", io::printable((folder / "report.html").string()).c_str());
}

/// Compares title, nodes and springs of a certificate.json, whose seal fits, with the scene in it.
/// Returns why they could not be compared; empty if they could. Throws InputError if they differ.
std::string compare_scene(const std::string& certificate, const std::string& file) {
  const nlohmann::ordered_json json = parse_json(certificate);
  if (json.at("code_hash") != build::code_hash()) { return "written by another version"; }
  if (json.at("inputs").size() > 1) { return "the scene reads more files"; }
  const io::ScratchFolder scratch;
  io::replace_file(scratch / "scene.toml", json.at("resolved_scene").get<std::string>());
  std::vector<std::string> differences;
  const auto compare = [&](const char* key, long has) {
    if (json.at(key) == has) { return; }
    differences.push_back(std::to_string(has) + " " + key + ", not " + json.at(key).dump());
  };
  try {
    const Scene scene = io::read_scene(scratch / "scene.toml").scene;
    if (json.at("title") != scene.title) { differences.emplace_back("another title"); }
    const bool network = scene.tissue.source != Source::oscillator;
    const SpringNetwork tissue = network ? build_network(scene) : SpringNetwork{};
    compare("nodes", tissue.node_count());
    compare("springs", static_cast<long>(tissue.springs.size()));
  } catch (const InputError& problem) {
    const std::string text = problem.what();  // begins with the file in the scratch folder
    differences.push_back("this mistake: " +
                          text.substr(std::min(text.find("scene.toml"), text.size())));
  }
  if (differences.empty()) { return {}; }
  throw InputError(file + ": the scene that it holds has " + join(differences) +
                   "; a certificate.json as palpate certify wrote it");
}

/// Compares a certificate.json with its seal, the histogram.csv beside it and the scene in it.
/// Throws InputError if they differ.
int verify(const CertifyOptions& options) {
  constexpr std::size_t most_bytes = 1U << 26U;
  const std::filesystem::path& file = options.scene;
  const evidence::Files files{
      {"certificate.json", io::read_text(file, most_bytes)},
      {"histogram.csv", io::read_text(file.parent_path() / "histogram.csv", most_bytes)}};
  const SealedVerdict sealed =
      verified_certificate(files.at("certificate.json"), files.at("histogram.csv"), file.string());
  const std::filesystem::path statement = file.parent_path() / statement_file;
  std::string signature;
  if (!options.key.empty() || std::filesystem::exists(statement)) {
    const evidence::CheckedStatement checked = evidence::check_statement(
        io::read_text(statement, most_bytes), evidence::certificate_predicate, files, options.key,
        statement.string());
    signature =
        checked.signature_checked ? "signature of this key; " : "signature not checked (--key); ";
  }
  const std::string unchecked = compare_scene(files.at("certificate.json"), file.string());
  std::printf("unchanged since it was written; %s%s%s: %s\n", signature.c_str(),
              unchecked.empty()
                  ? ""
                  : ("title, nodes and springs not checked, " + unchecked + "; ").c_str(),
              io::printable(sealed.verdict).c_str(), io::printable(sealed.reason).c_str());
  return sealed.verdict == verdict_word(Status::pass)   ? done
         : sealed.verdict == verdict_word(Status::fail) ? fell_short
                                                        : machine_cannot;
}

int run_certify(const CertifyOptions& options) {
  if (options.verify) { return verify(options); }
  if (!options.key.empty()) {  // refuses a wrong key before the measurement
    (void)evidence::statement_over({}, evidence::certificate_predicate, "{}", options.key);
  }
  for (const std::string& load : options.loads) {
    if (std::ranges::count(options.loads, load) > 1) {
      throw InputError("--load " + load + ": given twice; each load once");
    }
    if (is_own_load(load) || load == "stress-ng") { continue; }
    throw InputError("--load " + load + ": unknown; " + std::string(own_loads) + " or stress-ng");
  }
  if (std::ranges::find(options.loads, "stress-ng") != options.loads.end() &&
      timing::find_program("stress-ng").empty()) {
    std::fprintf(stderr, "palpate: --load stress-ng: not installed; the package stress-ng\n");
    return machine_cannot;
  }
  const LoadedScene loaded = load_scene(options.scene, options, false);
  refuse_trace(options.subject);
  std::string note;
  std::map<std::string, std::string> subject;
  // Refuses a scene that the simulator cannot represent.
  if (const auto foreign = foreign_subject(confined(options.subject, options), loaded)) {
    note = subject_note(*foreign);
    subject = subject_provenance(foreign->facts());
  }
  Progress progress;
  const CertifyPlan plan = plan_of(options, loaded, progress);
  const std::filesystem::path folder =
      options.make_folder({"certificate.json", "histogram.csv", "report.html", statement_file});
  keep_results_of_interrupted();
  const HappeningNames names(loaded.file.scene);
  CertificateReport report{
      .file = options.scene.filename().string(),
      .title = loaded.file.scene.title,
      .happening_name = [&](const ToolHappening& each) { return names.of(each); },
      .command = options.command,
      .provenance = scene_provenance(loaded)};
  hash_what_runs(options, loaded, report);
  report.result = certify_aside(loaded.file.scene, plan, options.quiet);
  report.cycles_per_second = cycles_per_second();
  report.environment =
      environment_of(report.result.rights, plan.priority, report.cycles_per_second);
  if (options.subject.foreign()) {
    report.provenance.merge(subject);
    report.not_counted = "only ticks of the model are counted";
    report.result.notes.push_back(note);
  } else {
    count_worst(options, plan.claim, report);
  }
  if (loaded.file.scene.simulation.threads > 1) {
    report.result.notes.emplace_back("The scene requests more threads; the loop used one.");
  }
  const Outcome outcome = outcome_of(report.result);
  const evidence::Files files{{"certificate.json", to_json(report)},
                              {"histogram.csv", to_csv(report)}};
  const io::WholeWrite whole;
  for (const auto& [name, content] : files) { io::replace_file(folder / name, content); }
  io::replace_file(folder / "report.html", to_html(report));
  std::filesystem::remove(folder / statement_file);  // of an earlier certificate
  if (!options.key.empty()) {
    io::replace_file(
        folder / statement_file,
        evidence::statement_over(files, evidence::certificate_predicate, "{}", options.key));
  }
  tell(report, outcome, folder, options);
  if (report.result.interrupted) { return interrupted_code; }
  return outcome.status == Status::pass   ? done
         : outcome.status == Status::fail ? fell_short
                                          : machine_cannot;
}

}  // namespace

void add_certify(Program& program) {
  const auto [command, options] = add_command(
      program, "certify", "test whether a scene keeps its deadlines on this machine", run_certify);
  add_scene(command, options, options.scene);
  add_value(command, "--rate", options.rate, "HZ",
            "ticks per second [falcon.rate, or one tick per step]")
      ->check(number_range(least_rate, most_rate));
  add_value(command, "--duration", options.duration, "S",
            "duration of the empty loop and of the scene, under each load [10]")
      ->check(number_range(1e-3, 86400.0));
  add_value(command, "--deadline", options.deadline, "US",
            "longest allowed time from the release to the end of a tick [the period]")
      ->check(number_range(1.0, 1e8));
  add_value(command, "--max-miss-rate", options.max_miss_rate, "P",
            "certify only with enough ticks to show, with 95 % confidence, that fewer than this "
            "share of all ticks misses [0.001, which needs " +
                std::to_string(ticks_needed(Claim{}.max_miss_rate)) + " ticks]")
      ->check(number_range(1e-9, 0.5));
  add_value(command, "--load", options.loads, "LOAD",
            "background load: idle, cpu, cache, memory or stress-ng; repeatable, one after the "
            "other [idle]");
  add_subject_options(command, options.subject);
  command.add_flag("--ordinary", options.ordinary,
                   "ordinary scheduling and memory: no certificate, but all figures");
  CLI::Option* verify =
      command.add_flag("--verify", options.verify,
                       "SCENE is a certificate.json: run nothing, refuse it with exit code 2 if it "
                       "or histogram.csv beside it was changed, else end as it says");
  for (const char* of_measurement : {"--rate", "--duration", "--deadline", "--max-miss-rate",
                                     "--load", "--subject", "--ordinary", "--set"}) {
    verify->excludes(command.get_option(of_measurement));
  }
  add_value(command, "--key", options.key, "FILE",
            "Ed25519 private key (PEM) that signs the certificate; with --verify the public key "
            "that must have signed it");
  add_json(command, options, "certificate.json");
  command.footer(
      "Writes certificate.json, histogram.csv and report.html; docs/certificate.md explains the "
      "claims\nand how to prepare a machine. Exit codes: 0 certified, 1 not certified, 2 bad "
      "input,\n"
      "3 environment not qualified, 130 Ctrl-C, with a certificate for what ran.");
}

}  // namespace palpate::cli
