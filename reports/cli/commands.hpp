// SPDX-License-Identifier: MIT
#pragma once
/// The commands of `palpate`: what each is given, and its exit code.

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace palpate::cli {

enum ExitCode : int {
  done = 0,
  fell_short = 1,
  bad_input = 2,
  machine_cannot = 3,
  interrupted_code = 130
};

/// What every command takes.
struct CommonOptions {
  std::filesystem::path out{};           ///< empty: palpate-out/COMMAND
  std::vector<std::string> overrides{};  ///< --set dotted.key=value
  bool quiet = false;

  [[nodiscard]] std::filesystem::path folder(const std::string& command) const {
    return out.empty() ? std::filesystem::path("palpate-out") / command : out;
  }
};

struct RunOptions : CommonOptions {
  std::filesystem::path scene{};
  bool no_skip = false;
  bool real_time = false;
  bool no_view = false;            ///< a page without pictures in three dimensions
  bool packets = false;            ///< write what went over the Falcon's line
  std::filesystem::path script{};  ///< faults on it
};
int run(const RunOptions& options);

struct InspectOptions : CommonOptions {
  std::filesystem::path scene{};
  bool json = false;
  bool no_skip = false;
};
int inspect(const InspectOptions& options);

struct ValidateOptions : CommonOptions {
  std::vector<std::string> cases{};
  bool list = false;
  bool quick = false;
  bool no_skip = false;
  int jobs = 0;             ///< 0: one per core
  std::uint64_t order = 0;  ///< seed of another order of summation; 0: none
  std::filesystem::path
      cache{};  ///< of references, judged cases, libraries; empty: the user's cache folder
  std::filesystem::path data{};  ///< of networks outside the project; empty: searched
};
int validate(const ValidateOptions& options);

struct BenchOptions : ValidateOptions {
  std::string against{};            ///< revision, or a step library: timed in pairs with this build
  int self_test = 0;                ///< comparisons of this build with itself; 0: none
  std::filesystem::path history{};  ///< of runs, one line each; empty: none is kept
};
/// The same of what is timed; cases run one after the other, whatever `jobs` says.
int bench(const BenchOptions& options);

struct StepsOptions : CommonOptions {
  std::string what{};  ///< name of a workload, or a scene file
  std::optional<long>
      before{};  ///< ticks that a profiler does not look at; empty: the workload's, or none
  std::optional<long> ticks{};   ///< that it looks at; empty: the workload's, or one
  std::optional<double> rate{};  ///< of a scene [Hz]; empty: its own
  int times = 1;
  std::filesystem::path library{};  ///< whose code steps the scene; empty: the program's own
  std::filesystem::path beside{};   ///< another that is timed in turn with it
  int pairs = 40;
  std::uint64_t seed = 1;
  bool head_first = false;  ///< `beside` is loaded first
  bool planted = false;     ///< `beside` takes one tick in twenty more
};
/// Ticks and nothing else; or pairs of them.
int steps(const StepsOptions& options);

struct CertifyOptions : CommonOptions {
  std::filesystem::path scene{};
  std::optional<double> rate{};      ///< [Hz]; empty: the scene's
  double duration = 10.0;            ///< [s] of each phase
  std::optional<double> deadline{};  ///< [us]; empty: the period
  std::vector<std::string> loads{};  ///< empty: idle
  bool ordinary = false;  ///< as if the system refused real-time scheduling and locked memory
};
int certify(const CertifyOptions& options);

struct ReportOptions : CommonOptions {
  std::filesystem::path results{};
};
int report(const ReportOptions& options);

/// Exactly one of the modes.
struct FalconOptions : CommonOptions {
  bool pty = false;
  bool stdio = false;
  std::filesystem::path script{};  ///< empty: no faults; a hand that rests, and homes when asked
  std::filesystem::path solve{};   ///< poses whose kinematics are asked for
};
int falcon(const FalconOptions& options);
/// Kinematics of poses: writes solution.csv.
int falcon_solve(const FalconOptions& options);

struct ImportOptions : CommonOptions {
  std::filesystem::path file{};
  std::string format = "auto";
  std::vector<std::string> columns{};       ///< NAME=ROLE
  std::optional<double> sample_rate{};      ///< [Hz], for a file without time
  std::optional<double> body_mass_index{};  ///< [kg/m^2]
  std::optional<double> plunger_area{};     ///< [m^2]
  std::string technique{}, source{}, group{}, subject{}, name{};
  bool pump = false;  ///< pressure of a pump, not of a thumb
};
int import_recording(const ImportOptions& options);

/// Exactly one of the modes.
struct TransducerCommandOptions : CommonOptions {
  std::filesystem::path recording{};
  bool pty = false;
  bool stdio = false;
  bool fast = false;         ///< --stdio at the reader's pace
  bool repeat = false;       ///< begins again after the last sample
  bool battery_low = false;  ///< said in every frame
  double drop = 0.0, duplicate = 0.0, corrupt = 0.0, burst = 0.0;  ///< chance of each byte
  int burst_bytes = 20;
  std::uint64_t seed = 1;
};
int transducer(const TransducerCommandOptions& options);

struct CalibrateOptions : CommonOptions {
  std::vector<std::filesystem::path> recordings{};
  std::filesystem::path scene{};
  std::vector<std::string> parameters{};  ///< keys; empty: all
  std::vector<std::string> priors{};      ///< KEY=VALUE:SPREAD
  std::vector<std::string> bounds{};      ///< KEY=LOWER:UPPER
  int jobs = 0;                           ///< simulations at a time; 0: one per core
};
int calibrate(const CalibrateOptions& options);

struct GateOptions : CommonOptions {
  std::filesystem::path results{};
  std::filesystem::path baseline{};
  std::vector<std::string> cases{};  ///< names or groups; empty: all
};
/// Results against a baseline (docs/gate.md).
int gate(const GateOptions& options);

struct ApproveOptions : GateOptions {
  std::string reason{};
  std::vector<std::filesystem::path>
      spreads{};  ///< results of the same cases by other builds or orders
};
/// Takes results as the new baseline.
int approve(const ApproveOptions& options);

struct ReconstructOptions : CommonOptions {
  std::filesystem::path table{};
};
/// Recordings rebuilt from a table of published values: writes one .h5 each.
int reconstruct(const ReconstructOptions& options);

/// Exactly one of scene and trace.
struct CompareOptions : CommonOptions {
  std::vector<std::filesystem::path> recordings{};  ///< files, or folders of them
  std::filesystem::path scene{}, trace{};
  std::filesystem::path results{};  ///< of a validation, for the table of credibility
  std::string quantity = "pressure";
  std::string alignment = "automatic";
  double cutoff = 20.0;                   ///< [Hz]; 0: none
  std::vector<std::string> tolerances{};  ///< tolerance_text.hpp
  double numerical_uncertainty = 0.0;     ///< u_num [1] of simulated values
  double input_uncertainty = 0.0;         ///< u_input [1] of simulated values
};
int compare_recordings(const CompareOptions& options);

// Ctrl-C: long work looks at this flag and ends with what is finished.

/// Set by SIGINT and SIGTERM once catch_interrupts() was called, which is for commands that look at
/// it; others end at once, and so does every command that is asked twice.
extern std::atomic<bool> interrupted;
void catch_interrupts();

/// A number from `least` to `most`, and nothing else: CLI::Range lets NaN pass, as no comparison
/// with it holds.
inline CLI::Validator number_range(double least, double most) {
  const auto check = [least, most](std::string& text) -> std::string {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) { return {}; }
    return "Value " + text + " not in range " + CLI::detail::to_string(least) + " to " +
           CLI::detail::to_string(most);
  };
  return CLI::Validator(check, "FLOAT in [" + CLI::detail::to_string(least) + " - " +
                                   CLI::detail::to_string(most) + "]");
}

// Arguments that several commands take.

/// --out and --quiet.
void add_common(CLI::App& command, CommonOptions& options, const std::string& name);

/// --set; `file`: what the keys are of.
void add_overrides(CLI::App& command, CommonOptions& options, const std::string& file);

// Command lines of what is timed and counted.

void add_bench(CLI::App& command, BenchOptions& options);
void add_steps(CLI::App& command, StepsOptions& options);

// Command lines of what reads recordings.

void add_import(CLI::App& command, ImportOptions& options);
void add_transducer(CLI::App& command, TransducerCommandOptions& options);
void add_compare(CLI::App& command, CompareOptions& options);
void add_calibrate(CLI::App& command, CalibrateOptions& options);

}  // namespace palpate::cli
