// SPDX-License-Identifier: MIT

#include <algorithm>
#include <fstream>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_file.hpp"
#include "model/problem/input_error.hpp"
#include "model/tissue/network_builder.hpp"
#include "reports/subject/foreign_subject.hpp"
#include "tests/check.hpp"
#include "validation/case.hpp"

namespace PALPATE_FILE {

using namespace palpate;

const std::string faulty = PALPATE_FAULTY_SUBJECT;

/// The time limit of a call is short for the one that never ends; others wait on a busy machine.
SubjectChoice with_fault(const std::string& fault) {
  return {.subject = faulty,
          .options_json = "{\"fault\": \"" + fault + "\"}",
          .limits = {.call_seconds = fault == "hang" ? 1.0 : 100.0, .memory_mib = 512.0}};
}

Outcome judge(const std::string& name, const SubjectChoice& choice) {
  const std::vector<std::string> patterns{"subject/" + name};
  const CaseContext context{
      .quick = true, .seed = 7, .subject = [choice] { return make_subject(choice); }};
  return run_case(select_cases(all_cases(), patterns, true).front(), context);
}

void check_verdict(const std::string& name, const std::string& fault, Status expected,
                   const std::string& reason = {}) {
  const Outcome outcome = judge(name, with_fault(fault));
  if (outcome.status != expected || outcome.reason().find(reason) == std::string::npos) {
    std::printf("  %s with %s is %s: %s\n", name.c_str(), fault.c_str(),
                name_of(outcome.status).data(), outcome.reason().c_str());
  }
  CHECK(outcome.status == expected);
  CHECK(outcome.reason().find(reason) != std::string::npos);
}

TEST("a sound subject passes the cases that its faults fail") {
  for (const char* name :
       {"first-step", "static", "patch", "chain", "damping", "fixed-nodes", "momentum", "energy",
        "invariance", "rest", "stability", "energy-report", "set-state", "audit/renumbered",
        "audit/stiffness", "audit/drawn", "audit/repeat", "audit/substeps", "audit/memory"}) {
    check_verdict(name, "none", Status::pass);
  }
}

TEST("a subject that crashes, exits, hangs or fills the memory is an error that says so") {
  check_verdict("chain", "crash", Status::error, "killed by signal 11 (SIGSEGV) in step");
  check_verdict("chain", "exit", Status::error, "exit code 7");
  check_verdict("chain", "hang", Status::error, "no answer to step within the time limit of 1 s");
  check_verdict("chain", "memory", Status::error, "more memory than the limit of 512 MiB");
  check_verdict("chain", "null-subject", Status::error, "null pointer");
  check_verdict("chain", "reason", Status::error,
                "failed in step; its last message: the solver found no solution");
  check_verdict("chain", "status", Status::error, "status 77; allowed are 0 to 3");
}

TEST("a subject that claims what it cannot do is an error, not a skip") {
  check_verdict("first-step", "claims", Status::error, "declares");
}

TEST("a scene that is refused although its needs are declared is an error, not a skip") {
  check_verdict("audit/drawn", "refuse", Status::error, "declares all that it needs for the scene");
  check_verdict("chain", "refuse", Status::pass);
}

TEST("what failed before a capability was missed stays a failure") {
  const auto judged_then_skipped = [](double value) {
    return run_case({.name = "a",
                     .measure =
                         [value](const CaseContext&, Outcome& outcome) {
                           outcome.report("size", 3.0);
                           outcome.judge_at_most("error", value, 1.0, "test");
                           throw CannotDo("no gravity");
                         }},
                    {})
        .status;
  };
  CHECK(judged_then_skipped(2.0) == Status::fail);
  CHECK(judged_then_skipped(0.5) == Status::skip);
}

TEST("a subject that never answers is not started for every case") {
  const SubjectChoice choice = with_fault("hang");  // a limit of 1 s a call
  for (int n = 0; n < SubjectLimits::most_timeouts; ++n) {
    CHECK(judge("chain", choice).reason().find("within the time limit of") != std::string::npos);
  }
  const Outcome outcome = judge("chain", choice);
  CHECK(outcome.status == Status::error);
  CHECK(outcome.reason().find("not started again") != std::string::npos);
}

TEST("a subject that answers NaN, late, or in millimetres fails") {
  check_verdict("chain", "nan", Status::fail);
  check_verdict("first-step", "late", Status::fail);
  check_verdict("static", "millimetres", Status::fail);
}

TEST(
    "a state that is not finite fails every case, also where no record and no free node shows it") {
  for (const char* fault : {"nan-velocity", "infinite-fixed"}) {
    for (const char* name :
         {"first-step", "static", "patch", "chain", "momentum", "energy", "invariance", "rest",
          "stability", "audit/stiffness", "audit/drawn", "audit/substeps"}) {
      check_verdict(name, fault, Status::fail);
    }
  }
  for (const char* name : {"set-state", "audit/drawn", "damping", "static"}) {
    check_verdict(name, "nan", Status::fail);  // in the middle of a run
  }
}

TEST("a subject that ignores the stiffness or keeps that of the first scene fails") {
  check_verdict("audit/stiffness", "stiffness", Status::fail);
  check_verdict("audit/stiffness", "cache", Status::fail);
  check_verdict("audit/drawn", "cache", Status::fail);
  check_verdict("audit/drawn", "stiffness", Status::fail);
}

TEST("a subject whose nodes are a metre aside fails, also where nothing pulls that way") {
  for (const char* name : {"first-step", "static", "rest", "stability", "audit/drawn"}) {
    check_verdict(name, "aside", Status::fail);
  }
}

TEST("a subject that ignores rest lengths, or changes velocities, fails") {
  check_verdict("audit/drawn", "geometric", Status::fail);
  check_verdict("audit/drawn", "slow-start", Status::fail);
  check_verdict("damping", "velocity", Status::fail);
}

TEST("a subject that changes the viscosity, or moves fixed nodes, fails") {
  check_verdict("damping", "viscosity", Status::fail);
  check_verdict("fixed-nodes", "moved-fixed", Status::fail);
  check_verdict("fixed-nodes", "fast-fixed", Status::fail);
}

TEST("a subject that does not reset, ignores substeps, or whose memory grows, fails") {
  check_verdict("audit/repeat", "reset", Status::fail);
  check_verdict("audit/repeat", "left-load", Status::fail);
  check_verdict("audit/repeat", "left-energy", Status::fail);
  check_verdict("audit/substeps", "substeps", Status::fail);
  check_verdict("audit/substeps", "fine", Status::fail);  // exact, and without effect
  check_verdict("audit/memory", "leak", Status::fail);
}

TEST("a subject that reports a wrong energy, or sets half a state, fails") {
  check_verdict("energy-report", "energy", Status::fail);
  check_verdict("energy-report", "dissipation", Status::fail);
  check_verdict("set-state", "set-state", Status::fail);
}

Outcome judge_elements(const std::string& name, const std::string& options) {
  return judge(name, {.subject = PALPATE_AXISYMMETRIC_SUBJECT, .options_json = options});
}

TEST("a subject with its own discretisation is judged at the tool, and skipped elsewhere") {
  for (const char* name : {"needle", "probe", "layered"}) {
    const Outcome sound = judge_elements(name, "{}");
    if (sound.status != Status::pass) { std::printf("  %s\n", sound.reason().c_str()); }
    CHECK(sound.status == Status::pass);
    CHECK(judge_elements(name, "{\"modulus_factor\": 1.2}").status == Status::fail);
  }
  CHECK(judge_elements("s26", "{}").status == Status::skip);
  CHECK(judge_elements("audit/drawn", "{}").status == Status::skip);
}

TEST("a scene that is drawn at run time can be drawn again") {
  const std::vector<std::string> patterns{"subject/audit/drawn"};
  const Case drawn = select_cases(all_cases(), patterns, true).front();
  const auto error_of = [&](std::uint64_t seed) {
    return run_case(drawn, {.quick = true, .seed = seed}).timings.front().value;
  };
  CHECK(error_of(5) == error_of(5));
  CHECK(error_of(5) != error_of(6));
  CHECK(error_of(0) != error_of(0));
}

TEST("a subject cannot read files in hidden folders where the kernel can prevent it") {
  const io::ScratchFolder folder;
  std::filesystem::create_directories(folder / "references");
  std::filesystem::create_directories(folder / "other");
  for (const char* name : {"references/answer.txt", "other/file.txt"}) {
    std::ofstream(folder / name) << "42\n";
  }
  const auto answer_for = [&](const char* name, bool hides) {
    SubjectChoice choice = with_fault("peek");
    choice.options_json = R"({"fault": "peek", "file": ")" + (folder / name).string() + "\"}";
    if (hides) { choice.limits.hidden = {folder / "references"}; }
    const std::unique_ptr<Subject> subject = make_subject(choice);
    const Scene scene = s26_scene(3);
    std::string answer;
    try {
      subject->load(scene, build_network(scene), true);
    } catch (const SubjectFailure& failure) { answer = failure.what(); }
    const std::string confinement = subject->facts().confinement;
    CHECK(hides != confinement.empty());
    if (confinement.find("no Landlock") != std::string::npos) { return std::string("no Landlock"); }
    return answer.find("was read") != answer.npos            ? std::string("read")
           : answer.find("Permission denied") != answer.npos ? "refused"
                                                             : answer;
  };
  CHECK(answer_for("references/answer.txt", false) == "read");
  CHECK(answer_for("other/file.txt", true) != "refused");
  CHECK(answer_for("references/answer.txt", true) != "read");
}

TEST("a subject cannot rename a hidden folder where the kernel can prevent it") {
  const io::ScratchFolder folder;
  std::filesystem::create_directories(folder / "references");
  SubjectChoice choice = with_fault("move");
  choice.options_json =
      R"({"fault": "move", "file": ")" + (folder / "references/answer.txt").string() + "\"}";
  choice.limits.hidden = {folder / "references"};
  const std::unique_ptr<Subject> subject = make_subject(choice);
  const Scene scene = s26_scene(3);
  CHECK_THROWS_AS(SubjectFailure, subject->load(scene, build_network(scene), true), "references");
  const bool confined = subject->facts().confinement == "confined";
  CHECK(std::filesystem::exists(folder / "references") == confined);
}

TEST("what a shared library prints does not damage its answers") {
  check_verdict("chain", "print", Status::pass);
}

TEST("a program that prints beside its frames is an error that shows what it printed") {
  const SubjectChoice choice{.subject = "exec:echo hello from the simulator"};
  CHECK_THROWS_AS(InputError, make_subject(choice), "hello from the");
}

TEST("a subject that cannot be started is bad input with a reason") {
  for (const auto& [subject, reason] : std::vector<std::pair<std::string, std::string>>{
           {"exec:/no/such/program", "not found"},
           {"/no/such/library.so", "no such file"},
           {"simulator.exe", "unknown; model, PATH.so"},
           {"exec:", "needs a command"},
           {"trace:/no/such.csv", "no such file"}}) {
    CHECK_THROWS_AS(InputError, make_subject({.subject = subject}), reason);
  }
}

Trace run(const SubjectChoice& choice, const std::string& scene_file,
          const std::string& duration = "0.05") {
  const auto file = std::make_shared<const io::SceneFile>(
      io::read_scene(PALPATE_SCENES "/" + scene_file, {"simulation.duration=" + duration}));
  const std::unique_ptr<Subject> subject = make_subject(choice, file);
  subject->load(file->scene, build_network(file->scene), true);
  return roll_out(*subject, file->scene);
}

/// Returns the size [bytes] of what simulators of this process wrote to standard error, as kept.
std::uintmax_t kept_messages() {
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code closed;  // the descriptor of the iterator
    const std::string target = std::filesystem::read_symlink(entry.path(), closed).string();
    if (target.find("palpate-subject-errors") != target.npos) {
      bytes += std::filesystem::file_size(entry.path());
    }
  }
  return bytes;
}

TEST("messages of a simulator do not fill the memory") {
  const auto file = std::make_shared<const io::SceneFile>(
      io::read_scene(PALPATE_SCENES "/s26.toml", {"simulation.duration=1.0"}));
  const std::unique_ptr<Subject> subject = make_subject(with_fault("chatter"), file);
  subject->load(file->scene, build_network(file->scene), true);
  constexpr std::uintmax_t step = 256 * 64;
  const Trace trace = roll_out(*subject, file->scene);
  CHECK(static_cast<std::uintmax_t>(trace.ticks) * step > 15'000'000);  // were written
  CHECK(kept_messages() > 0);
  CHECK(kept_messages() < 6'000'000);  // a limit of 1 MiB, and 256 calls between two looks
}

#ifdef PALPATE_MODEL_SUBJECT
TEST("the model behind the interface gives the same bits as in this program") {
  // Long enough for the parts that once differed: a recorded force, a slanting needle, a probe that
  // rebounds after its withdrawal, a needle that is drawn back, a sliding probe.
  for (const auto& [scene, duration] :
       std::vector<std::pair<std::string, std::string>>{{"s26.toml", "0.05"},
                                                        {"seven-layers.toml", "0.05"},
                                                        {"epidural.toml", "0.05"},
                                                        {"falcon-soft.toml", "0.05"},
                                                        {"network-example/scene.toml", "0.05"},
                                                        {"mesh-example/scene.toml", "0.05"},
                                                        {"skin-example/scene.toml", "0.05"},
                                                        {"heterogeneous-block.toml", "0.05"},
                                                        {"ultrasound-probe.toml", "0.05"},
                                                        {"cube.toml", "0.2"},
                                                        {"paramedian.toml", "1.0"},
                                                        {"palpation.toml", "1.6"},
                                                        {"bone.toml", "4.0"},
                                                        {"sliding-probe.toml", "0.5"}}) {
    const Trace here = run({}, scene, duration);
    const Trace there = run({.subject = PALPATE_MODEL_SUBJECT}, scene, duration);
    CHECK(here.rows() == there.rows());
    CHECK(here.columns.size() == there.columns.size());
    for (std::size_t n = 0; n < std::min(here.columns.size(), there.columns.size()); ++n) {
      CHECK(here.columns[n].name == there.columns[n].name);
      CHECK(here.columns[n].values == there.columns[n].values);
    }
    for (std::size_t n = 0; n < std::min(here.text_columns.size(), there.text_columns.size());
         ++n) {
      CHECK(here.text_columns[n].values == there.text_columns[n].values);
    }
  }
}
#endif

TEST("a trace is judged like a simulator, with its own units") {
  const io::ScratchFolder folder;
  const Trace model = run({}, "s26.toml");
  std::ofstream file(folder / "mine.csv");
  file << "t_ms;up_mm\n";
  file.precision(17);
  for (std::size_t n = 0; n < model.rows(); ++n) {
    file << 1e3 * model.time[n] << ";" << 1e3 * model.values("tip.z_m")[n] << "\n";
  }
  file.close();
  const SubjectChoice choice{.subject = "trace:" + (folder / "mine.csv").string(),
                             .columns = {"t_ms=time_ms", "up_mm=tip.z_mm"}};
  const Trace replayed = run(choice, "s26.toml");
  for (std::size_t n = 0; n < model.rows(); ++n) {
    CHECK_NEAR(replayed.values("tip.z_m")[n], model.values("tip.z_m")[n], 1e-15);  // rounding
  }
  const auto refused = [&](const std::string& name, const std::string& content,
                           const std::string& reason) {
    std::ofstream(folder / name) << content;
    const SubjectChoice wrong{.subject = "trace:" + (folder / name).string(),
                              .columns = {"t=time_s"}};
    CHECK_THROWS_AS(InputError, run(wrong, "s26.toml"), reason);
  };
  refused("gap.csv", "t,tip.z_m\n0,0\n0.1,nan\n0.2,0\n", "tip.z_m is no number at 0.1 s");
  refused("two.csv", "t,tip.z_m,tip.z_mm\n0,0,0\n0.2,0,0\n", "two columns are tip.z_m");
  // It lasts 0.05 s, which is shorter than the scene of the case.
  CHECK(judge("s26", choice).status == Status::skip);
  for (const char* name : {"momentum", "audit/drawn"}) {
    CHECK(judge(name, choice).status == Status::skip);
  }
}

}  // namespace PALPATE_FILE
