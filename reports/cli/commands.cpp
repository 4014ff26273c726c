// SPDX-License-Identifier: MIT

#include "reports/cli/commands.hpp"

#include <csignal>

#include "reports/cli/tolerance_text.hpp"

namespace palpate::cli {

std::atomic<bool> interrupted{false};

void catch_interrupts() {
  static_assert(std::atomic<bool>::is_always_lock_free);
  const auto note = [](int signal) {
    interrupted.store(true);
    std::signal(signal, SIG_DFL);  // whoever asks twice does not want to wait
  };
  std::signal(SIGINT, note);
  std::signal(SIGTERM, note);
}

void add_common(CLI::App& command, CommonOptions& options, const std::string& name) {
  command.add_option("--out", options.out, "folder for what is written [palpate-out/" + name + "]")
      ->type_name("DIR");
  command.add_flag("--quiet", options.quiet, "say nothing but errors");
}

void add_overrides(CLI::App& command, CommonOptions& options, const std::string& file) {
  command
      .add_option("--set", options.overrides,
                  file + " key to override, value in TOML syntax; repeatable")
      ->type_name("dotted.key=value")
      ->allow_extra_args(false);
}

void add_bench(CLI::App& command, BenchOptions& options) {
  command.add_option("cases", options.cases, "benches or groups; all when none")->type_name("CASE");
  add_common(command, options, "bench");
  command.add_flag("--list", options.list, "name every bench and stop");
  command.add_flag("--quick", options.quick, "the short form");
  command
      .add_option("--history", options.history,
                  "append what was found as a line of JSON, and look for slow creep in the runs "
                  "that stand there")
      ->type_name("FILE");
  command
      .add_option("--cache", options.cache,
                  "folder of kept references and of libraries of revisions [user's cache]")
      ->type_name("DIR");
  CLI::Option* against = command
                             .add_option("--against", options.against,
                                         "time this build in pairs with that of a revision "
                                         "(scripts/build-base makes it), or with a library")
                             ->type_name("REV|FILE");
  command
      .add_option(
          "--self-test", options.self_test,
          "so many comparisons of this build with itself, and with itself slowed down by 5 %")
      ->type_name("N")
      ->check(CLI::Range(1, 10000))
      ->excludes(against);
}

void add_steps(CLI::App& command, StepsOptions& options) {
  command.add_option("what", options.what, "a workload of bench/instructions, or a scene file")
      ->required()
      ->type_name("WORKLOAD|SCENE");
  add_overrides(command, options, "scene");
  command
      .add_option("--before", options.before,
                  "ticks that a profiler does not look at [the workload's; 0]")
      ->type_name("N")
      ->check(CLI::Range(0L, 1000000000L));
  command.add_option("--ticks", options.ticks, "ticks that it looks at [the workload's; 1]")
      ->type_name("N")
      ->check(CLI::Range(1L, 1000000000L));
  command
      .add_option("--times", options.times, "how often all that is done, set up anew each time [1]")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  command
      .add_option("--rate", options.rate,
                  "ticks of a scene a second [falcon.rate, or a tick a step]")
      ->type_name("HZ")
      ->check(number_range(0.01, 20000.0));
  CLI::Option* library = command
                             .add_option("--library", options.library,
                                         "step library whose code is used [the program's own]")
                             ->type_name("FILE");
  CLI::Option* beside =
      command
          .add_option("--beside", options.beside,
                      "another that is timed in turn with it; prints pairs of seconds")
          ->type_name("FILE")
          ->needs(library);
  command.add_option("--pairs", options.pairs, "of batches [40]")
      ->type_name("N")
      ->check(CLI::Range(1, 100000))
      ->needs(beside);
  command.add_option("--seed", options.seed, "of the order within pairs [1]")
      ->type_name("N")
      ->needs(beside);
  command.add_flag("--head-first", options.head_first, "load the other one first")->needs(beside);
  command.add_flag("--planted", options.planted, "the other one takes one tick in twenty more")
      ->needs(beside);
  command.add_flag("--quiet", options.quiet, "say nothing but errors");
  command.footer(
      "Steps, and does nothing else: for profilers. `valgrind --tool=callgrind --instr-atstart=no "
      "palpate\n"
      "steps cube-list-double` counts the instructions of these ticks alone (docs/bench.md).");
}

void add_import(CLI::App& command, ImportOptions& options) {
  command
      .add_option("file", options.file, "CSV, recording.h5, MATLAB 7.3, or bytes of the raw link")
      ->required()
      ->type_name("FILE");
  command.add_option("--format", options.format, "auto (by content), csv, raw or hdf5 [auto]");
  command
      .add_option(
          "--column", options.columns,
          "what a column holds: time_ms, pressure_kPa, depth_mm, force_N, ignore; repeatable")
      ->type_name("NAME=ROLE")
      ->allow_extra_args(false);
  const CLI::Validator positive = number_range(1e-12, 1e12);
  command.add_option("--rate", options.sample_rate, "samples a second, for a file without time")
      ->type_name("HZ")
      ->check(positive);
  command.add_option("--bmi", options.body_mass_index, "body mass index, kg/m^2")
      ->type_name("BMI")
      ->check(positive);
  command.add_option("--plunger-area", options.plunger_area, "m^2 [1.767e-4]")
      ->type_name("AREA")
      ->check(positive);
  command.add_option("--technique", options.technique, "continuous or intermittent")
      ->check(CLI::IsMember({"continuous", "intermittent"}));
  command.add_option("--source", options.source, "publication, hospital or device")
      ->type_name("TEXT");
  command.add_option("--group", options.group, "subjects that belong together")->type_name("TEXT");
  command
      .add_option("--subject", options.subject,
                  "who it is, as a code; recordings of one count once")
      ->type_name("TEXT");
  command.add_option("--name", options.name, "for people [the file's]")->type_name("TEXT");
  command.add_flag("--pump", options.pump, "pressure of a pump that injects, not of a thumb");
  add_common(command, options, "import");
  command.footer(
      "Units: a column is named like pressure_mmHg, \"pressure (kPa)\" or \"t [s]\", or has its\n"
      "role from --column. Writes recording.h5 and recording.csv. docs/recordings.md shows how.");
}

void add_transducer(CLI::App& command, TransducerCommandOptions& options) {
  command.add_option("recording", options.recording, "recording of any kind that import reads")
      ->required()
      ->type_name("RECORDING");
  command.add_flag("--pty", options.pty,
                   "on a new pseudo-terminal, whose path is the first line of output");
  command.add_flag("--stdio", options.stdio, "on standard output");
  command.add_flag("--fast", options.fast,
                   "with --stdio: as fast as they are read, not at 9600 baud");
  command.add_flag("--repeat", options.repeat, "begin again after the last sample, until Ctrl-C");
  const CLI::Validator share = number_range(0.0, 1.0);
  command.add_option("--drop", options.drop, "chance of each byte to be lost [0]")->check(share);
  command.add_option("--double", options.duplicate, "chance of each byte to come twice [0]")
      ->check(share);
  command.add_option("--corrupt", options.corrupt, "chance of each byte to become another [0]")
      ->check(share);
  command
      .add_option("--burst", options.burst,
                  "chance of each byte to begin a burst of corruption [0]")
      ->check(share);
  command.add_option("--burst-bytes", options.burst_bytes, "bytes of a burst [20]")
      ->check(CLI::Range(1, 1000000));
  command.add_option("--seed", options.seed, "of the faults [1]");
  command.add_flag("--battery-low", options.battery_low, "say so in every frame");
  add_common(command, options, "transducer");
  command.footer(
      "One of --pty and --stdio is needed. 8 bytes a sample, 120 samples/s (docs/formats.md).\n"
      "Ends with the recording, or at Ctrl-C. The same seed gives the same faults.");
}

void add_compare(CLI::App& command, CompareOptions& options) {
  command
      .add_option("recordings", options.recordings,
                  "of any kind that import reads, or folders of .h5")
      ->required()
      ->type_name("RECORDING");
  command.add_option("--scene", options.scene, "scene to simulate")->type_name("SCENE");
  command.add_option("--trace", options.trace, "trace.h5 or trace.csv of an earlier run")
      ->type_name("TRACE");
  add_overrides(command, options, "scene");
  command.add_option("--quantity", options.quantity, "pressure or force [pressure]");
  command.add_option(
      "--align", options.alignment,
      "clocks: automatic (depth, else event, else start), depth, event or start [automatic]");
  command
      .add_option("--cutoff", options.cutoff,
                  "of the low-pass, from 1 to a quarter of a rate; 0: none, and noise is not "
                  "estimated [20]")
      ->type_name("HZ")
      ->check(number_range(0.0, 1e6));
  command
      .add_option("--tolerance", options.tolerances,
                  "FEATURE=WIDTH instead of its default; repeatable")
      ->type_name("FEATURE=WIDTH")
      ->allow_extra_args(false);
  const CLI::Validator share = number_range(0.0, 10.0);
  command
      .add_option("--numerical-uncertainty", options.numerical_uncertainty,
                  "u_num, standard, as a share of simulated values [0]")
      ->type_name("SHARE")
      ->check(share);
  command
      .add_option("--input-uncertainty", options.input_uncertainty,
                  "u_input, standard, as a share of simulated values [0]")
      ->type_name("SHARE")
      ->check(share);
  command
      .add_option("--results", options.results,
                  "folder of `palpate validate`, as evidence at the end")
      ->type_name("DIR");
  add_common(command, options, "compare");
  command.footer(
      "One of --scene and --trace is needed. Default tolerances of a pressure:\n" +
      tolerance_help(comparison::QuantityKind::pressure) +
      "A width is a share (15%), a number with its unit (7mmHg), their sum (30%+5mmHg/s)\n"
      "or a factor (x2). Writes comparison.json and report.html, and with --scene trace.h5;\n"
      "docs/comparison.md has what is judged. Exit codes: 0 agrees, 1 differs, is not "
      "distinguishable\n"
      "or not comparable, 2 bad input.");
}

void add_calibrate(CLI::App& command, CalibrateOptions& options) {
  command.add_option("recordings", options.recordings, "recordings of any kind that import reads")
      ->required()
      ->type_name("RECORDING");
  command
      .add_option("--scene", options.scene, "scene file: needle, layers, syringe (docs/scenes.md)")
      ->required()
      ->type_name("SCENE");
  add_overrides(command, options, "scene");
  command
      .add_option("--parameter", options.parameters,
                  "fit this key, as material.NAME.friction; repeatable [all]")
      ->type_name("KEY")
      ->allow_extra_args(false);
  command
      .add_option("--prior", options.priors,
                  "value and SD of its logarithm, in place of the scene's; repeatable")
      ->type_name("KEY=VALUE:SPREAD")
      ->allow_extra_args(false);
  command
      .add_option("--bounds", options.bounds,
                  "least and largest value [4 spreads either side]; repeatable")
      ->type_name("KEY=LOWER:UPPER")
      ->allow_extra_args(false);
  command.add_option("--jobs", options.jobs, "simulations at a time [one per core]")
      ->check(CLI::Range(1, 1024));
  add_common(command, options, "calibrate");
  command.footer(
      "Keys: material.NAME.cutting_force, friction, youngs_modulus; layer.INDEX.thickness of the "
      "fat;\n"
      "syringe.thumb_force, compliance, tissue_resistance, epidural_resistance. What recordings "
      "cannot\n"
      "tell stays as it is and is named. Nothing is drawn at random: the same input, the same "
      "fit.\n"
      "Writes fitted.toml, calibration.json, report.html. docs/calibration.md shows how.");
}

}  // namespace palpate::cli
