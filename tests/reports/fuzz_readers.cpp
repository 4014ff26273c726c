// SPDX-License-Identifier: MIT
// Readers of results, baselines, histories and recordings of any format, and what other programs
// send: answers of a simulator, requests to its host, requests and messages of a browser.

#include "tests/fuzz_readers.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "model/problem/scene.hpp"
#include "model/tissue/network_builder.hpp"
#include "reports/certificate_report.hpp"
#include "reports/evidence.hpp"
#include "reports/index_page.hpp"
#include "reports/live/frame_codec.hpp"
#include "reports/live/live_server.hpp"
#include "reports/recording_input.hpp"
#include "reports/recording_preset.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/results/results_json.hpp"
#include "reports/subject/foreign_subject.hpp"
#include "reports/timing/history.hpp"
#include "tests/validation/insertion_scenes.hpp"
#include "validation/roll_out.hpp"

namespace {

void must(bool holds, const char* what) {
  if (!holds) { broken(what); }
}

/// Folder with one file, whose name the first byte selects.
void read_index_of_folder(std::string_view bytes) {
  constexpr std::array<const char*, 6> names{"summary.json",    "results.json",
                                             "gate.json",       "certificate.json",
                                             "comparison.json", "calibration.json"};
  if (bytes.empty()) { return; }
  const fs::path one = folder() / "indexed";
  fs::remove_all(one);
  fs::create_directory(one);
  const std::size_t n = static_cast<unsigned char>(bytes.front()) % names.size();
  (void)file_with(bytes.substr(1), std::string("indexed/") + names[n]);
  const std::vector<IndexLine> lines{index_line_of(one)};
  (void)to_text(lines.front());
  (void)index_html(lines, folder());
}

void read_ledger(std::string_view bytes) {
  const std::vector<IndexLine> lines = read_index(file_with(bytes, "index.jsonl"));
  for (const IndexLine& line : lines) { (void)to_text(line); }
  fs::create_directories(folder() / "run");
  (void)index_html(lines, folder());
}

void read_preset(std::string_view bytes) {
  const RecordingPreset preset = preset_from(std::string(bytes), "preset.json");
  io::ReadRecording read;
  Recording& recording = read.recording;
  for (int n = 0; n < 20; ++n) {
    recording.time.push_back(1e-3 * n);
    recording.depth.push_back(1e-4 * n);
    recording.force.push_back(n < 10 ? 0.0 : 1.0);
  }
  apply(preset, "fat_5_0_18_1_today.csv", read);
}

void read_statement(std::string_view bytes) {
  (void)evidence::check_statement(std::string(bytes), evidence::certificate_predicate,
                                  {{"certificate.json", "{}"}}, {}, "s.json");
}

// ---- a simulator behind a pipe ----

Scene scene_of_subject() {
  Scene scene = insertion_scene(4e-3);
  scene.syringe = Syringe{};
  return scene;
}

/// The whole input is what the simulator answers, whatever it was asked.
void read_answers(std::string_view bytes) {
  static const Scene scene = scene_of_subject();
  static const SpringNetwork network = build_network(scene);
  const fs::path file = file_with(bytes, "answers");
  try {
    const std::unique_ptr<Subject> subject =
        make_subject({.subject = "exec:cat " + file.string(), .limits = {.call_seconds = 5.0}});
    subject->load(scene, network, false);
    (void)roll_out(*subject, scene, {.every = 1}, {});
    (void)subject->reported_energy();
    (void)subject->round_trip();
    must(subject->reset(), "a simulator that was reset");
  } catch (const SubjectFailure& refusal) {
    must(*refusal.what() != '\0', "a message");
  } catch (const CannotDo& refusal) { must(*refusal.what() != '\0', "a message"); }
}

/// Columns that a simulator wrote.
void read_columns(std::string_view bytes) {
  static const Scene scene = scene_of_subject();
  static const SpringNetwork network = build_network(scene);
  const fs::path file = file_with(bytes, "c.csv");
  const std::unique_ptr<Subject> subject = make_subject({.subject = "trace:" + file.string()});
  try {
    subject->load(scene, network, false);
  } catch (const CannotDo&) { return; }
  (void)roll_out(*subject, scene, {.every = 1}, {});
}

/// Library that obeys every call, and touches all that a call hands it.
palpate_subject_api obedient_library() {
  static std::array<char, 1> state{};
  palpate_subject_api api{};
  api.abi = PALPATE_SUBJECT_ABI;
  api.size = sizeof api;
  api.name = "obedient";
  api.load = [](const char* at, const char* options, palpate_subject** subject, char* error,
                std::size_t size) -> int {
    *subject = reinterpret_cast<palpate_subject*>(state.data());
    std::snprintf(error, size, "%s %s", at, options);
    return *at == 'x' ? PALPATE_FAILED : PALPATE_OK;
  };
  api.reset = [](palpate_subject*, std::uint64_t) -> int { return PALPATE_OK; };
  api.step = [](palpate_subject*, double, double, const palpate_tool_input* in,
                palpate_tool_output* out) -> int {
    if (in != nullptr && out != nullptr) { out->insertion = in->insertion; }
    return PALPATE_OK;
  };
  api.get_state = [](palpate_subject*, double* x, double* v, std::size_t nodes) -> int {
    if (nodes > 0) { x[0] = x[3 * nodes - 1] = v[0] = v[3 * nodes - 1] = 1.0; }
    return PALPATE_OK;
  };
  api.set_state = [](palpate_subject*, const double* x, const double* v, std::size_t nodes) -> int {
    return nodes > 0 && x[3 * nodes - 1] == v[3 * nodes - 1] ? PALPATE_OK : PALPATE_FAILED;
  };
  api.set_parameter = [](palpate_subject*, const char* name, double) -> int {
    return *name == 'x' ? PALPATE_FAILED : PALPATE_OK;
  };
  api.energy = [](palpate_subject*, double joule[3]) -> int {
    joule[0] = joule[1] = joule[2] = 0.0;
    return PALPATE_OK;
  };
  api.destroy = [](palpate_subject*) {};
  return api;
}

/// Requests to the program that hosts a library.
void read_requests(std::string_view bytes) {
  static const palpate_subject_api api = obedient_library();
  const int in = open(file_with(bytes, "requests").c_str(), O_RDONLY | O_CLOEXEC);
  const int out = open("/dev/null", O_WRONLY | O_CLOEXEC);
  const int code = serve_library(api, in, out);
  close(in);
  close(out);
  must(code == 0 || code == 2, "an exit code of the host");
}

// ---- a browser ----

void read_command(std::string_view bytes) {
  const auto command = live::command_of(bytes);
  must(!command || std::isfinite(command->value), "a finite value");
}

void read_changes(std::string_view bytes) {
  std::array<std::int16_t, 60> values{};
  if (!live::add_changes(bytes, values)) { return; }
  std::string again;
  live::append_changes(values, {}, again);
  std::array<std::int16_t, 60> same{};
  must(live::add_changes(again, same) && same == values, "changes that are read as written");
}

/// Live run whose loop obeys the messages that its server received.
class LiveRun {
 public:
  LiveRun()
      : scene_(scene_of_live()),
        subject_(Simulation(scene_)),
        loop_(std::make_unique<live::LiveLoop>(scene_, subject_, live::LiveOptions{})) {
    loop_->begin(subject_);
    const NetworkProblem network(build_network(scene_));
    const live::LivePage page =
        live::live_page(scene_, network, network.network().rest_position, {"fat"}, "");
    server_ = std::make_unique<live::LiveServer>(*loop_, page, token, 0);
    server_->start();
    sigset_t alarm;  // of the fuzzer's timer: would interrupt connect() and recv()
    sigemptyset(&alarm);
    sigaddset(&alarm, SIGALRM);
    pthread_sigmask(SIG_BLOCK, &alarm, nullptr);
  }

  /// Sends bytes as one client, in which "@P" and "@T" of the head are port and token, and reads
  /// until the server closes.
  void visit(std::string_view bytes) {
    std::string sent(bytes);
    replace(sent, "@P", std::to_string(server_->port()));
    replace(sent, "@T", token);
    const int client = connected();
    (void)send(client, sent.data(), sent.size(), MSG_NOSIGNAL);
    shutdown(client, SHUT_WR);
    std::array<char, 4096> answer{};
    ssize_t got = 1;
    while (got > 0) { got = recv(client, answer.data(), answer.size(), 0); }
    must(got == 0 || errno == ECONNRESET, "a server that closes");
    close(client);
    (void)loop_->before_tick(subject_);
    for (const double factor : loop_->stiffness()) {
      must(factor >= 0.05 && factor <= 20.0, "a factor within its limits");
    }
  }

 private:
  static constexpr const char* token = "00112233445566778899aabbccddeeff";

  static Scene scene_of_live() {
    Scene scene = hand_scene(1.0, 1e-3);
    scene.drive->kind = Drive::Kind::recorded;
    scene.drive->depth = 0.01;
    return scene;
  }
  static void replace(std::string& text, std::string_view mark, const std::string& with) {
    const std::size_t at = text.find(mark);
    if (at < std::min(text.find("\r\n\r\n"), text.size())) {
      text.replace(at, mark.size(), with);
      replace(text, mark, with);
    }
  }
  [[nodiscard]] int connected() const {
    const int client = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(server_->port());
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{.tv_sec = 8, .tv_usec = 0};  // below the limit of a request
    setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    const linger reset{.l_onoff = 1, .l_linger = 0};  // leaves no port in TIME_WAIT
    setsockopt(client, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
    must(connect(client, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0,
         "a server that listens");
    return client;
  }

  Scene scene_;
  ModelSubject subject_;
  std::unique_ptr<live::LiveLoop> loop_;
  std::unique_ptr<live::LiveServer> server_{};
};

void read_visit(std::string_view bytes) {
  static LiveRun run;
  run.visit(bytes);
}

const std::map<std::string, Reader>& readers() {
  static const std::map<std::string, Reader> all{
      {"results",
       [](std::string_view bytes) { (void)results_from_json(std::string(bytes), "results.json"); }},
      {"baseline", [](std::string_view bytes) { (void)read_baseline(file_with(bytes, "b.json")); }},
      {"history",
       [](std::string_view bytes) { (void)timing::read_history(file_with(bytes, "h.jsonl")); }},
      {"index", read_index_of_folder},
      {"ledger", read_ledger},
      {"preset", read_preset},
      {"certificate",
       [](std::string_view bytes) {
         (void)verified_certificate(std::string(bytes), "", "certificate.json");
       }},
      {"statement", read_statement},
      {"evidence", [](std::string_view bytes) { (void)evidence::from_zip(bytes, "e.zip"); }},
      {"recording",  // CSV and raw link
       [](std::string_view bytes) { (void)read_any_recording(file_with(bytes, "r.csv")); }},
      {"answers", read_answers},
      {"columns", read_columns},
      {"requests", read_requests},
      {"command", read_command},
      {"changes", read_changes},
      {"visit", read_visit}};
  return all;
}

}  // namespace
