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

namespace {

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
  const CaseContext context{.quick = true, .subject = [choice] { return make_subject(choice); }};
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
       {"first-step", "static", "patch", "chain", "momentum", "energy", "invariance", "rest",
        "stability", "audit/renumbered", "audit/stiffness", "audit/repeat", "audit/memory"}) {
    check_verdict(name, "none", Status::pass);
  }
}

TEST("a subject that crashes, exits, hangs or fills the memory is an error that says so") {
  check_verdict("chain", "crash", Status::error, "killed by signal 11 (SIGSEGV) in step");
  check_verdict("chain", "exit", Status::error, "exit code 7");
  check_verdict("chain", "hang", Status::error, "no answer to step within the time limit of 1 s");
  check_verdict("chain", "memory", Status::error, "more memory than the limit of 512 MiB");
  check_verdict("chain", "null-subject", Status::error, "null pointer");
  check_verdict("chain", "status", Status::error, "status 77; allowed are 0 to 3");
}

TEST("a subject that claims what it cannot do is an error, not a skip") {
  check_verdict("first-step", "claims", Status::error, "declares");
}

TEST("a subject that answers NaN, late, or in millimetres fails") {
  check_verdict("chain", "nan", Status::fail);
  check_verdict("first-step", "late", Status::fail);
  check_verdict("static", "millimetres", Status::fail);
}

TEST("a subject that ignores the stiffness or keeps that of the first scene fails") {
  check_verdict("audit/stiffness", "stiffness", Status::fail);
  check_verdict("audit/stiffness", "cache", Status::fail);
}

TEST("a subject that does not reset, or whose memory grows, fails") {
  check_verdict("audit/repeat", "reset", Status::fail);
  check_verdict("audit/memory", "leak", Status::fail);
}

TEST("a subject that reports a wrong energy, or sets half a state, fails") {
  check_verdict("energy-report", "energy", Status::fail);
  check_verdict("set-state", "set-state", Status::fail);
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

Trace run(const SubjectChoice& choice, const std::string& scene_file) {
  const auto file = std::make_shared<const io::SceneFile>(
      io::read_scene(PALPATE_SCENES "/" + scene_file, {"simulation.duration=0.05"}));
  const std::unique_ptr<Subject> subject = make_subject(choice, file);
  subject->load(file->scene, build_network(file->scene), true);
  return roll_out(*subject, file->scene);
}

#ifdef PALPATE_MODEL_SUBJECT
TEST("the model behind the interface gives the same bits as in this program") {
  for (const char* scene : {"s26.toml", "seven-layers.toml", "epidural.toml", "falcon-soft.toml",
                            "network-example/scene.toml", "ultrasound-probe.toml"}) {
    const Trace here = run({}, scene);
    const Trace there = run({.subject = PALPATE_MODEL_SUBJECT}, scene);
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
  // It lasts 0.05 s, which is shorter than the scene of the case.
  CHECK(judge("s26", choice).status == Status::skip);
  CHECK(judge("momentum", choice).status == Status::skip);
}

}  // namespace
