// SPDX-License-Identifier: MIT
/// The `palpate` program: command line in, exit code out.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <functional>
#include <sstream>

#include "model/kernels/instruction_set.hpp"
#include "model/problem/input_error.hpp"
#include "model/stepping/integrator.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/provenance.hpp"

namespace {

using namespace palpate;
using namespace palpate::cli;

void add_scene(CLI::App& command, CommonOptions& options, std::filesystem::path& scene) {
  command.add_option("scene", scene, "scene file (TOML, docs/scenes.md)")
      ->required()
      ->type_name("SCENE");
  add_overrides(command, options, "scene");
}

std::string integrator_help() {
  std::string text = "Integrators:\n";
  for (const IntegratorInfo* info : integrators()) {
    std::string name(info->name);
    name.resize(26, ' ');
    text += "  " + name + std::string(info->summary) + "\n";
  }
  return text +
         "  auto                      chosen for the scene; `palpate inspect` says which and why\n";
}

void add_judged(CLI::App& command, GateOptions& options, const std::string& name) {
  command.add_option("results", options.results, "folder that validate, bench or run wrote")
      ->required()
      ->type_name("RESULTS");
  command
      .add_option("--baseline", options.baseline,
                  "what was accepted (JSON; its curves beside it as .h5)")
      ->required()
      ->type_name("FILE");
  command.add_option("--case", options.cases, "a case or group alone; repeatable [all]")
      ->type_name("NAME")
      ->allow_extra_args(false);
  add_common(command, options, name);
}

void add_approve(CLI::App& command, ApproveOptions& options) {
  add_judged(command, options, "approve");
  command.add_option("--reason", options.reason, "why numbers may change; stands in the ledger")
      ->required()
      ->type_name("TEXT");
  command
      .add_option(
          "--spread", options.spreads,
          "the same cases by another build or order of summation: what rounding moves; repeatable")
      ->type_name("RESULTS")
      ->allow_extra_args(false);
  command.footer(
      "Prints what was, what becomes of it and the bound it is judged by, then writes FILE and "
      "its\n"
      "curves. Results that ended in an error or are not finite are refused. docs/gate.md has "
      "more.");
}

void add_certify(CLI::App& command, CertifyOptions& options) {
  add_scene(command, options, options.scene);
  command.add_option("--rate", options.rate, "ticks a second [falcon.rate, or a tick a step]")
      ->type_name("HZ")
      ->check(number_range(0.01, 20000.0));
  command
      .add_option("--duration", options.duration,
                  "of the empty loop and of the scene, under each load [10]")
      ->type_name("S")
      ->check(number_range(1e-3, 86400.0));
  command
      .add_option("--deadline", options.deadline,
                  "from a release until the tick is done [the period]")
      ->type_name("US")
      ->check(number_range(1.0, 1e8));
  command
      .add_option("--load", options.loads,
                  "other work meanwhile: idle, cpu, cache, memory or stress-ng; repeatable, one "
                  "after the other [idle]")
      ->type_name("LOAD")
      ->allow_extra_args(false);
  command.add_flag("--ordinary", options.ordinary,
                   "ordinary scheduling and memory: no certificate, all figures");
  add_common(command, options, "certify");
  command.footer(
      "Writes certificate.json, histogram.csv and report.html; docs/certificate.md says what they "
      "claim\n"
      "and how to prepare a machine. Exit codes: 0 certified, 1 not certified, 2 bad input,\n"
      "3 environment not qualified, 130 Ctrl-C, with a certificate for what ran.");
}

/// "palpate: " before every line of a message.
int refuse(const std::string& message, int code) {
  std::istringstream lines(message);
  for (std::string line; std::getline(lines, line);) {
    std::fprintf(stderr, "palpate: %s\n", line.c_str());
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Palpate: validation and regression harness for haptic soft-tissue simulation");
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  app.footer(integrator_help() +
             "\nExit codes: 0 every check holds, 1 one fell short, 2 bad usage or input "
             "(nothing written),\n3 this machine cannot do it, 130 interrupted.");
  std::function<int()> chosen;

  RunOptions run_options;
  CLI::App* command = app.add_subcommand("run", "simulate one scene");
  add_scene(*command, run_options, run_options.scene);
  add_common(*command, run_options, "run");
  command->add_flag("--no-skip", run_options.no_skip,
                    "compute what the scene does not need; same result");
  command->add_flag("--no-view", run_options.no_view,
                    "no view in three dimensions in report.html, and nothing kept for it");
  command->add_flag("--real-time", run_options.real_time,
                    "every tick waits for its time on the wall clock");
  command
      ->add_option("--script", run_options.script,
                   "faults on the Falcon's line by time (TOML, docs/falcon.md)")
      ->type_name("FILE");
  command->add_flag("--packets", run_options.packets,
                    "write packets.csv: what went over the Falcon's line");
  command->footer(integrator_help());
  command->callback([&] { chosen = [&] { return run(run_options); }; });

  InspectOptions inspect_options;
  command =
      app.add_subcommand("inspect", "say what a scene is, needs and skips, without simulating");
  add_scene(*command, inspect_options, inspect_options.scene);
  add_common(*command, inspect_options, "inspect");
  command->add_flag("--json", inspect_options.json, "as JSON on standard output");
  command->add_flag("--no-skip", inspect_options.no_skip, "plan without skipping");
  command->footer(integrator_help());
  command->callback([&] { chosen = [&] { return inspect(inspect_options); }; });

  ValidateOptions validate_options;
  command = app.add_subcommand("validate", "judge the model: accuracy, stability, physics");
  command->add_option("cases", validate_options.cases, "cases, groups or suites; all when none")
      ->type_name("CASE");
  add_common(*command, validate_options, "validate");
  command->add_flag("--list", validate_options.list, "name every case and stop");
  command->add_flag("--quick", validate_options.quick, "the short form");
  command->add_flag(
      "--no-skip", validate_options.no_skip,
      "run cases whose code is as before, compute what scenes do not need; same verdicts");
  command->add_option("--jobs", validate_options.jobs, "cases at a time [one per core]")
      ->check(CLI::Range(1, 1024));
  command
      ->add_option("--order", validate_options.order,
                   "nodes and springs in an order of chance with this seed: what rounding moves "
                   "(docs/gate.md)")
      ->type_name("SEED");
  command
      ->add_option("--cache", validate_options.cache,
                   "folder of kept references and judged cases [user's cache]")
      ->type_name("DIR");
  command->add_option("--data", validate_options.data, "folder of data outside the project")
      ->type_name("DIR");
  command->callback([&] { chosen = [&] { return validate(validate_options); }; });

  BenchOptions bench_options;
  command = app.add_subcommand("bench", "run time against error, and what a spring costs");
  add_bench(*command, bench_options);
  command->callback([&] { chosen = [&] { return bench(bench_options); }; });

  StepsOptions steps_options;
  command = app.add_subcommand("steps", "ticks of a scene and nothing else, for profilers");
  add_steps(*command, steps_options);
  command->callback([&] { chosen = [&] { return steps(steps_options); }; });

  CertifyOptions certify_options;
  command = app.add_subcommand("certify", "does a scene keep its deadlines on this machine?");
  add_certify(*command, certify_options);
  command->callback([&] { chosen = [&] { return certify(certify_options); }; });

  ReportOptions report_options;
  command = app.add_subcommand("report", "render report.html again from a results folder");
  command->add_option("results", report_options.results, "folder with results.json and traces/")
      ->required()
      ->type_name("RESULTS");
  add_common(*command, report_options, "report");
  command->callback([&] { chosen = [&] { return report(report_options); }; });

  FalconOptions falcon_options;
  command = app.add_subcommand(
      "falcon", "the emulated Novint Falcon: on its wire protocol, or its kinematics");
  command->add_flag("--pty", falcon_options.pty,
                    "on a new pseudo-terminal, whose path is the first line of output");
  command->add_flag("--stdio", falcon_options.stdio,
                    "on standard input and output, until the input ends");
  command
      ->add_option(
          "--solve", falcon_options.solve,
          "kinematics of the poses in a CSV file with x_m,y_m,z_m and, if asked, fx_n,fy_n,fz_n")
      ->type_name("FILE");
  command
      ->add_option("--script", falcon_options.script,
                   "faults, grip and buttons by time (TOML, docs/falcon.md)")
      ->type_name("FILE");
  add_overrides(*command, falcon_options, "script");
  add_common(*command, falcon_options, "falcon");
  command->footer(
      "One of --pty, --stdio and --solve is needed. Ctrl-C ends the service; log.csv in DIR has "
      "every\n"
      "request. --solve writes solution.csv.\n"
      "docs/falcon.md shows how to connect.");
  command->callback([&] { chosen = [&] { return falcon(falcon_options); }; });

  ImportOptions import_options;
  command = app.add_subcommand("import", "a recording of any kind to one recording.h5");
  add_import(*command, import_options);
  command->callback([&] { chosen = [&] { return import_recording(import_options); }; });

  TransducerCommandOptions transducer_options;
  command = app.add_subcommand("transducer", "replay a recording as the 9600 baud pressure link");
  add_transducer(*command, transducer_options);
  command->callback([&] { chosen = [&] { return transducer(transducer_options); }; });

  GateOptions gate_options;
  command = app.add_subcommand("gate", "hold results against a baseline");
  add_judged(*command, gate_options, "gate");
  command->footer(
      "Writes gate.json, gate.xml (JUnit) and report.html. Exit codes: 0 nothing became worse, 1 "
      "something\n"
      "did or cannot be compared, 2 bad input. docs/gate.md has the rules.");
  command->callback([&] { chosen = [&] { return gate(gate_options); }; });

  ApproveOptions approve_options;
  command = app.add_subcommand("approve", "take results as the new baseline");
  add_approve(*command, approve_options);
  command->callback([&] { chosen = [&] { return approve(approve_options); }; });

  CompareOptions compare_options;
  command = app.add_subcommand("compare", "recorded insertions against a simulated one");
  add_compare(*command, compare_options);
  command->callback([&] { chosen = [&] { return compare_recordings(compare_options); }; });

  CalibrateOptions calibrate_options;
  command = app.add_subcommand("calibrate", "fit layers and syringe of a scene to recordings");
  add_calibrate(*command, calibrate_options);
  command->callback([&] { chosen = [&] { return calibrate(calibrate_options); }; });

  ReconstructOptions reconstruct_options;
  command =
      app.add_subcommand("reconstruct", "recordings rebuilt from a table of published values");
  command
      ->add_option("table", reconstruct_options.table,
                   "fixtures/clinical/published_values.csv, or one like it")
      ->required()
      ->type_name("TABLE");
  add_common(*command, reconstruct_options, "reconstruct");
  command->footer(
      "Writes one .h5 per recording into DIR. They are no measurements, and each says so\n"
      "(fixtures/recordings/README.md).");
  command->callback([&] { chosen = [&] { return reconstruct(reconstruct_options); }; });

  for (CLI::App* each : app.get_subcommands({})) {
    each->set_version_flag("--version", version_text());
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) { return app.exit(error); }  // --help, --version
    return refuse(std::string(error.what()) + "; `palpate --help` shows what is allowed",
                  bad_input);
  }
  try {
    (void)widest_allowed();
  } catch (const std::invalid_argument& error) { return refuse(error.what(), bad_input); }
  try {
    return chosen();
  } catch (const InputError& error) {
    return refuse(error.what(), bad_input);
  } catch (const std::exception& error) { return refuse(error.what(), fell_short); }
}
