// SPDX-License-Identifier: MIT
#pragma once
/// Server of a live run: one page and one WebSocket on 127.0.0.1, on a thread of its own.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "model/problem/problem.hpp"
#include "model/problem/scene.hpp"
#include "reports/live/frame_codec.hpp"
#include "reports/live/live_loop.hpp"

namespace palpate::live {

/// Returns 128 random bits from the system as 32 hexadecimal digits. Throws std::runtime_error.
std::string random_token();

/// Checks of a request: its host, origin and target. The server uses nothing else of a request, and
/// its target never names a file.
struct RequestCheck {
  std::string token{};
  std::uint16_t port = 0;

  /// True for the names of this machine with the port: a page of another name that resolves to
  /// 127.0.0.1 has its own name here (DNS rebinding).
  [[nodiscard]] bool allows_host(std::string_view host) const;
  /// True for the page of this server; a page of another origin has its own here.
  [[nodiscard]] bool allows_origin(std::string_view origin) const;
  /// True if the target is `path` with the token. The time does not depend on where they differ.
  [[nodiscard]] bool allows_target(std::string_view target, std::string_view path) const;
};

/// Limit on messages: `burst` at once, and `rate` a second.
class RateLimit {
 public:
  RateLimit(double rate, double burst) : rate_(rate), burst_(burst), room_(burst) {}
  /// Returns false if a message at `time` [s] is too much; times must not decrease.
  [[nodiscard]] bool allows(double time);

 private:
  double rate_;
  double burst_;
  double room_;
  double last_ = 0.0;
};

/// Returns the command of a message, or nothing if it is not one.
std::optional<Command> command_of(std::string_view message);

/// Page, and what the server must know to fill it.
struct LivePage {
  std::string html{};
  Quantiser quantiser;
  std::vector<std::pair<double, std::string>> layers{};  ///< begin of each along the path [m]
  bool has_tool = false;
  bool has_pressure = false;
};

/// Makes the page of a scene from the view of the reports. `position` contains all nodes [m];
/// `materials` are the names of those that have a slider, in the order of their commands.
LivePage live_page(const Scene& scene, const NetworkProblem& network, const NodeVectors& position,
                   const std::vector<std::string>& materials, const std::string& device);

struct ServerCounts {
  long frames = 0;     ///< sent to viewers
  long dropped = 0;    ///< not sent, because a viewer had not taken the one before
  long torn = 0;       ///< snapshots with a wrong checksum
  long snapshots = 0;  ///< read from the loop
  long refused = 0;    ///< requests and connections
  std::uint64_t bytes = 0;
};

class LiveServer {
 public:
  /// Listens on 127.0.0.1 at once; `port` 0: any free one. Throws std::system_error.
  LiveServer(LiveLoop& loop, LivePage page, std::string token, std::uint16_t port);
  ~LiveServer();
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] std::string url() const;
  /// Starts the thread.
  void start();
  /// Ends the thread and closes all connections.
  void stop();
  /// After stop().
  [[nodiscard]] const ServerCounts& counts() const;

 private:
  class Core;
  std::unique_ptr<Core> core_;
  std::thread thread_{};
};

}  // namespace palpate::live
