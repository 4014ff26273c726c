// SPDX-License-Identifier: MIT
/// The command `live`.

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <optional>
#include <pthread.h>
#include <string>
#include <thread>
#include <vector>

#include "device/falcon/grip_thread.hpp"
#include "device/real_time.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_file.hpp"
#include "fixtures/io/scene_keys.hpp"
#include "model/problem/input_error.hpp"
#include "model/tissue/network_builder.hpp"
#include "reports/cli/commands.hpp"
#include "reports/live/live_loop.hpp"
#include "reports/live/live_server.hpp"
#include "reports/results/results_json.hpp"
#include "validation/certificate/certificate.hpp"

namespace palpate::cli {
namespace {

namespace fs = std::filesystem;
using namespace palpate::live;

struct LiveCommandOptions : CommonOptions {
  fs::path scene{};
  std::string device = "hand";
  int port = 0;
  double duration = 3600.0;  ///< longest run [s]
  fs::path firmware{};
  double most_force = device::falcon::GripThreadOptions{}.most_force;
  bool ordinary = false;
  bool no_record = false;
  SubjectChoice subject{};
};

constexpr std::string_view falcon_prefix = "falcon:";
constexpr std::size_t most_firmware = std::size_t{1} << 20U;  // [bytes]; images have some 8 kB

/// Returns the names of the materials that the tissue is built of, at most as many as the loop
/// keeps factors for. Meshes and images are built of theirs when they are read.
std::vector<std::string> materials_of(const Scene& scene) {
  std::vector<std::string> names;
  const auto add = [&names](const std::string& name) {
    const bool known = std::ranges::find(names, name) != names.end();
    if (!known && names.size() < most_materials) { names.push_back(name); }
  };
  const Tissue& tissue = scene.tissue;
  const bool cells =
      tissue.source == Source::lattice && tissue.lattice.weights == LatticeWeights::cell;
  if (cells) { add(tissue.lattice.material); }
  if (tissue.source == Source::layers) {
    for (const Layer& layer : tissue.layers) {
      if (!layer.gap) { add(layer.material); }
    }
  }
  if (!cells && tissue.source != Source::layers) { return names; }
  for (const Inclusion& inclusion : tissue.inclusions) { add(inclusion.material); }
  return names;
}

/// The scene of a live run: a tool is held through the coupling, and the time is the longest one.
Scene live_scene(const io::SceneFile& file, double duration) {
  Scene scene = file.scene;
  if (scene.needle || scene.probe) {
    Drive drive = scene.drive.value_or(Drive{});
    drive.kind = Drive::Kind::recorded;
    drive.grip.reset();
    scene.drive = drive;
  }
  scene.simulation.duration = duration;
  for (Material& material : scene.materials) {
    material.changes.clear();
  }  // the sliders change them
  return scene;
}

class LiveSession {
 public:
  explicit LiveSession(const LiveCommandOptions& options)
      : options_(options),
        file_(std::make_shared<const io::SceneFile>(
            io::read_scene(options.scene, options.overrides))),
        given_(live_scene(*file_, options.duration)),
        scene_(given_),
        materials_(materials_of(scene_)) {
    if (scene_.tissue.source == Source::oscillator) {
      throw InputError(options.scene.string() + ": an oscillator is not tissue; a network");
    }
    if (options.subject.foreign()) {
      subject_ = make_subject(confined(options.subject, options), file_);
    } else {
      subject_ = std::make_unique<ModelSubject>();
    }
    load();
    const NetworkProblem network(build_network(scene_));
    const NodeVectors position = subject_->node_positions();
    if (position.cols() != network.network().node_count()) {
      throw InputError("--subject " + options.subject.subject +
                       ": reports no positions of the scene's nodes, so there is nothing to show");
    }
    open_device();
    LiveOptions loop{.device = grip_ ? &*grip_ : nullptr, .records = !options.no_record};
    loop.drives = options.device == "hand";
    loop_ = std::make_unique<LiveLoop>(scene_, *subject_, loop);
    server_.emplace(*loop_,
                    live_page(scene_, network, position, materials_,
                              options.device.substr(0, options.device.find(':'))),
                    random_token(), static_cast<std::uint16_t>(options.port));
  }

  /// Serves until Ctrl-C or a failure of the subject. Returns the exit code.
  int run() {
    folder_ = options_.make_folder({"scene.toml", "summary.json", "times.csv", "trace.csv"});
    server_->start();
    std::printf("%s\n", server_->url().c_str());
    std::fflush(stdout);
    if (!options_.quiet) {
      std::fprintf(stderr,
                   "palpate: open this address in a browser on this machine; Ctrl-C ends\n");
    }
    std::thread loop([this] {
      pthread_setname_np(pthread_self(), "loop");  // for those who measure its processor time
      keep_running();
    });
    loop.join();
    server_->stop();
    if (grip_) { grip_->stop(); }
    if (failure_) { std::rethrow_exception(failure_); }
    tell();
    return interrupted ? interrupted_code : done;
  }

 private:
  void load() {
    try {
      const SpringNetwork network = build_network(scene_);
      subject_->load(scene_, network, true);
    } catch (const CannotDo& problem) {
      throw InputError(options_.scene.string() + ": --subject " + options_.subject.subject + ": " +
                       problem.what());
    } catch (const std::invalid_argument& problem) {
      throw InputError(options_.scene.string() + ": " + problem.what());
    }
  }

  void open_device() {
    if (options_.device == "hand" || options_.device == "mouse") { return; }
    if (!options_.device.starts_with(falcon_prefix)) {
      throw InputError("--device " + options_.device +
                       ": unknown; must be hand, mouse or falcon:PATH of a serial line");
    }
    const std::string path = options_.device.substr(falcon_prefix.size());
    device::falcon::GripThreadOptions grip{.most_force = options_.most_force};
    if (!options_.firmware.empty()) {
      const std::string bytes = io::read_bytes(options_.firmware, most_firmware);
      grip.firmware.assign(bytes.begin(), bytes.end());
    }
    try {
      line_.emplace(path);
    } catch (const std::system_error& problem) {
      throw InputError("--device " + options_.device + ": " + problem.what() +
                       "; the path of a serial line that can be opened is needed");
    }
    grip_.emplace(*line_, grip);
  }

  /// Runs the scene again after every reset, on its own thread.
  void keep_running() {
    try {
      for (int number = 1; !interrupted; ++number) {
        const fs::path folder = number == 1 ? folder_ : folder_ / ("run-" + std::to_string(number));
        run_once(folder);
        if (interrupted) { return; }
        scene_ = with_stiffness(given_, materials_, loop_->stiffness());
        load();
      }
    } catch (...) { failure_ = std::current_exception(); }
  }

  void run_once(const fs::path& folder) {
    fs::create_directories(folder);
    for (const char* of_earlier_run : {"summary.json", "times.csv", "scene.toml"}) {
      fs::remove(folder / of_earlier_run);  // in case this one is killed
    }
    std::optional<RowWriter> writer;
    device::DeadlineClock clock(scene_.simulation.step);
    loop_->begin(*subject_, &clock);
    if (!options_.no_record) { writer.emplace(*loop_, folder / "trace.csv"); }
    std::optional<MaterialBuilder> builder;
    if (const auto* model = dynamic_cast<const ModelSubject*>(subject_.get());
        model != nullptr && !materials_.empty()) {
      builder.emplace(*loop_, *model, given_, materials_, loop_->stiffness());
    }
    Trace trace;
    std::exception_ptr failure;  // of the subject; what it did until then is kept
    {
      std::optional<device::LockedMemory> memory;
      std::optional<device::AwakeProcessors> awake;
      std::optional<device::FifoScheduling> fifo;
      if (!options_.ordinary) {
        memory.emplace();
        awake.emplace();
        fifo.emplace(priority);
        rights_ = {.fifo = fifo->refusal() == 0 ? "" : "refused",
                   .memory = memory->refusal(),
                   .idle = awake->refusal()};
      }
      device::touch_stack();
      try {
        trace = roll_out(*subject_, scene_, {.every = subject_->tick_count()},
                         {.stop = &interrupted, .clock = &clock, .hook = &*loop_});
      } catch (...) { failure = std::current_exception(); }
    }
    changes_.clear();
    if (builder) {
      changes_ = builder->finish();
      if (!builder->refusal().empty()) {
        std::fprintf(stderr, "palpate: materials change at the next reset: %s\n",
                     builder->refusal().c_str());
      }
    }
    const bool whole = !writer || writer->finish();
    const char* status = failure ? "failed" : trace.diverged ? "diverged" : "ok";
    write_summary(folder, status, writer ? writer->rows() : 0, whole);
    if (failure) { std::rethrow_exception(failure); }
    if (!interrupted && !loop_->wants_reset()) {
      loop_->wait_for_reset(*subject_, trace.diverged, interrupted);
    }
  }

  /// Scene that replays the run, in the folder of its trace. Empty without a tool.
  [[nodiscard]] std::string replay_scene(const fs::path& folder, double duration) const {
    if (!scene_.drive) { return {}; }
    std::vector<std::pair<std::string, std::string>> changes = io::inputs_seen_from(*file_, folder);
    const auto set = [&](const std::string& key, const std::string& value) {
      changes.emplace_back(key, value);
    };
    set("drive.kind", "\"recorded\"");
    set("drive.recording", "\"trace.csv\"");
    set("simulation.duration", io::number_text(duration));
    for (std::size_t n = 0; n < materials_.size(); ++n) {
      const std::string key = "material." + materials_[n];
      const auto modulus = [&](const Scene& scene) {
        return std::ranges::find(scene.materials, materials_[n], &Material::name)->youngs_modulus;
      };
      if (modulus(scene_) != modulus(given_)) {
        set(key + ".youngs_modulus", io::number_text(modulus(scene_)));
      }
      std::string list;
      for (const MaterialChange& change : changes_) {
        if (change.material != n) { continue; }
        const double time = static_cast<double>(change.tick) * scene_.simulation.step;
        list += (list.empty() ? "" : ", ") +
                ("{time = " + io::number_text(time) +
                 ", youngs_modulus = " + io::number_text(change.youngs_modulus) + "}");
      }
      const auto given = std::ranges::find(file_->scene.materials, materials_[n], &Material::name);
      if (!list.empty() || !given->changes.empty()) { set(key + ".change", "[" + list + "]"); }
    }
    return io::rewrite_scene(*file_, changes,
                             {"Replays the live run whose trace.csv is beside it."});
  }

  void write_summary(const fs::path& folder, const char* status, long rows, bool whole) const {
    const LiveState& state = loop_->state();
    const auto us_of = [](std::optional<double> seconds) {
      return seconds ? std::optional(1e6 * *seconds) : std::nullopt;
    };
    const auto times_of = [&](const certificate::LatencyHistogram& times) {
      return object("median", us_of(times.percentile(0.5)), "p99", us_of(times.percentile(0.99)),
                    "p99_9", us_of(times.percentile(0.999)), "p99_99",
                    us_of(times.percentile(0.9999)), "worst", 1e6 * times.maximum());
    };
    const auto json =
        object("status", status, "scene", options_.scene.filename().string(), "device",
               options_.device, "period_s", scene_.simulation.step, "steps",
               static_cast<long>(state.ticks), "duration_s", state.time, "rows", rows, "rows_lost",
               static_cast<long>(state.lost_rows), "rows_whole", whole, "periods",
               static_cast<long>(state.periods), "missed", static_cast<long>(state.missed),
               "left_out_s", state.left_out, "response_us", times_of(loop_->record().response),
               "work_us", times_of(loop_->record().compute), "material_changes", changes_.size(),
               "scheduling", rights_.fifo.empty() ? "SCHED_FIFO" : rights_.fifo, "memory",
               rights_.memory.empty() ? "locked" : rights_.memory, "idle_states",
               rights_.idle.empty() ? "none with latency" : rights_.idle);
    const io::WholeWrite together;
    io::replace_file(folder / "summary.json", json.dump(2) + "\n");
    io::replace_file(folder / "times.csv", times_table());
    if (options_.no_record) { return; }
    if (const std::string text = replay_scene(folder, state.time); !text.empty()) {
      io::replace_file(folder / "scene.toml", text);
    }
  }

  /// Returns the numbers of periods by their times, without the times that no period has.
  [[nodiscard]] std::string times_table() const {
    const certificate::LoopRecord& record = loop_->record();
    const auto response = record.response.counts();
    const auto work = record.compute.counts();
    std::string text = "time_us,response,work\n";
    for (std::size_t n = 0; n < response.size(); ++n) {
      if (response[n] == 0 && work[n] == 0) { continue; }
      text += std::to_string(n) + "," + std::to_string(response[n]) + "," +
              std::to_string(work[n]) + "\n";
    }
    return text;
  }

  void tell() const {
    const ServerCounts& counts = server_->counts();
    const LiveState& state = loop_->state();
    std::printf(
        "%ld periods, %ld missed, worst response %.0f us; %ld snapshots, %ld torn; "
        "%ld frames sent (%.1f kB each), %ld dropped, %ld requests refused\n",
        static_cast<long>(state.periods), static_cast<long>(state.missed), 1e6 * state.worst,
        counts.snapshots, counts.torn, counts.frames,
        counts.frames > 0
            ? 1e-3 * static_cast<double>(counts.bytes) / static_cast<double>(counts.frames)
            : 0.0,
        counts.dropped, counts.refused);
    if (state.left_out > 0.0) {
      std::printf("%.1f s were not made up: this computer needs longer than %.3g ms for a tick\n",
                  state.left_out, 1e3 * scene_.simulation.step);
    }
    if (grip_) {
      const device::falcon::GripThreadCounts& device = grip_->counts();
      std::printf(
          "device: %lld exchanges, %lld without reply, force switched off %lld times, "
          "limited %lld times\n",
          static_cast<long long>(device.exchanges), static_cast<long long>(device.lost),
          static_cast<long long>(device.watchdog), static_cast<long long>(device.limited));
    }
  }

  static constexpr int priority = 80;  // as palpate certify

  const LiveCommandOptions& options_;
  std::shared_ptr<const io::SceneFile> file_;
  Scene given_;  ///< with the materials of the file
  Scene scene_;  ///< with those that a run begins with
  std::vector<std::string> materials_;
  std::unique_ptr<Subject> subject_{};
  std::optional<device::TerminalLink> line_{};
  std::optional<device::falcon::GripThread> grip_{};
  std::unique_ptr<LiveLoop> loop_{};
  std::optional<LiveServer> server_{};
  fs::path folder_{};
  certificate::Rights rights_{
      .fifo = "not asked for", .memory = "not asked for", .idle = "not asked for"};
  std::vector<MaterialChange> changes_{};  ///< of the last run
  std::exception_ptr failure_{};
};

int run_live(const LiveCommandOptions& options) {
  keep_results_of_interrupted();
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return LiveSession(options).run();
  } catch (const std::system_error& problem) {
    std::fprintf(stderr, "palpate: %s; this machine must offer it\n", problem.what());
    return machine_cannot;
  }
}

}  // namespace

void add_live(Program& program) {
  const auto [command, options] =
      add_command(program, "live",
                  "simulate a scene in real time, with a page to see and operate it", run_live);
  add_scene(command, options, options.scene);
  add_value(command, "--device", options.device, "DEVICE",
            "what holds the tool: hand (drives by itself), mouse, or falcon:PATH of a serial line "
            "or pseudo-terminal [hand]");
  add_value(command, "--port", options.port, "N", "port on 127.0.0.1; 0: any free one [0]")
      ->check(CLI::Range(0, 65535));
  add_value(command, "--duration", options.duration, "S", "longest run between two resets [3600]")
      ->check(number_range(1.0, 86400.0));
  add_value(command, "--firmware", options.firmware, "FILE",
            "image for the boot loader of a Falcon, if it has none yet; not part of Palpate");
  add_value(command, "--max-force", options.most_force, "N", "limit on the force of a device [8]")
      ->check(number_range(0.0, 20.0));
  command.add_flag("--ordinary", options.ordinary, "run with ordinary scheduling and memory");
  command.add_flag("--no-record", options.no_record, "write no trace.csv and no scene.toml");
  add_subject_options(command, options.subject);
  command.footer(
      "The address with its token is printed; the page needs no other server. trace.csv "
      "grows by some\n0.3 MB a second. docs/live.md explains the page, the recording and "
      "the devices.");
}

}  // namespace palpate::cli
