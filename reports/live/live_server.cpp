// SPDX-License-Identifier: MIT

#include "reports/live/live_server.hpp"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cerrno>
#include <chrono>
#include <list>
#include <map>
#include <sys/random.h>
#include <system_error>

#include "live_assets.hpp"
#include "report_assets.hpp"
#include "view_assets.hpp"

#include "model/problem/needle_path.hpp"
#include "model/stepping/tool_report.hpp"
#include "reports/html/html_page.hpp"
#include "reports/results/results_json.hpp"
#include "reports/view/view_encoding.hpp"

namespace palpate::live {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
namespace asio = boost::asio;
using asio::ip::tcp;
using Json = nlohmann::ordered_json;

namespace {

constexpr std::size_t most_viewers = 16;
constexpr std::size_t most_message = 512;  // [bytes]
constexpr double most_messages_per_second = 200.0;
constexpr double most_messages_at_once = 400.0;
constexpr std::size_t most_header = 8192;  // [bytes]
constexpr int most_behind = 1 << 15;       // [bytes] that a slow viewer has not taken
constexpr std::size_t events_shown = 12;
constexpr auto look_period = std::chrono::milliseconds(4);
constexpr auto request_timeout = std::chrono::seconds(10);

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

/// Compares in a time that depends on the lengths alone.
bool equal_secret(std::string_view a, std::string_view b) {
  unsigned differs = a.size() == b.size() ? 0U : 1U;
  for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n) {
    differs |= static_cast<unsigned char>(a[n]) ^ static_cast<unsigned char>(b[n]);
  }
  return differs == 0U;
}

double now() { return device::monotonic_now(); }

/// Frame of a run in the form that the page reads: a head of eight bytes, a JSON text and the
/// changes of the displacements.
std::string frame_of(bool keyframe, const std::string& json, std::span<const std::int16_t> values,
                     std::span<const std::int16_t> before) {
  std::string frame(8, '\0');
  frame[0] = 1;
  frame[1] = keyframe ? 1 : 0;
  for (unsigned n = 0; n < 4; ++n) { frame[4 + n] = static_cast<char>(json.size() >> (8 * n)); }
  frame += json;
  append_changes(values, keyframe ? std::span<const std::int16_t>() : before, frame);
  return frame;
}

}  // namespace

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::system_error(errno, std::generic_category(), "random numbers of the system");
  }
  std::string token;
  for (const unsigned char byte : bytes) {
    token += "0123456789abcdef"[byte >> 4U];
    token += "0123456789abcdef"[byte & 15U];
  }
  return token;
}

bool RequestCheck::allows_host(std::string_view host) const {
  const std::string end = ":" + std::to_string(port);
  return host == "127.0.0.1" + end || host == "localhost" + end;
}

bool RequestCheck::allows_origin(std::string_view origin) const {
  constexpr std::string_view scheme = "http://";
  return origin.starts_with(scheme) && allows_host(origin.substr(scheme.size()));
}

bool RequestCheck::allows_target(std::string_view target, std::string_view path) const {
  return !token.empty() && equal_secret(target, std::string(path) + "?token=" + token);
}

bool RateLimit::allows(double time) {
  room_ = std::min(burst_, room_ + rate_ * std::max(0.0, time - last_));
  last_ = time;
  if (room_ < 1.0) { return false; }
  room_ -= 1.0;
  return true;
}

std::optional<Command> command_of(std::string_view message) {
  using Kind = Command::Kind;
  static const std::map<std::string, Kind, std::less<>> kinds{
      {"start", Kind::start},         {"pause", Kind::pause}, {"reset", Kind::reset},
      {"drive", Kind::drive},         {"hold", Kind::hold},   {"speed", Kind::speed},
      {"stiffness", Kind::stiffness}, {"stop", Kind::stop}};
  if (message.size() > most_message || std::ranges::count(message, '[') > 0 ||
      std::ranges::count(message, '{') != 1) {
    return {};
  }
  const Json json = Json::parse(message, nullptr, false);
  if (!json.is_object() || !json.contains("do") || !json["do"].is_string()) { return {}; }
  const auto kind = kinds.find(json["do"].get<std::string>());
  if (kind == kinds.end()) { return {}; }
  Command command{.kind = kind->second};
  const bool needs_value = command.kind == Kind::drive || command.kind == Kind::hold ||
                           command.kind == Kind::speed || command.kind == Kind::stiffness;
  if (needs_value) {
    if (!json.contains("value") || !json["value"].is_number()) { return {}; }
    command.value = json["value"].get<double>();
    if (!std::isfinite(command.value)) { return {}; }
  }
  if (command.kind == Kind::stiffness) {
    if (!json.contains("index") || !json["index"].is_number_unsigned()) { return {}; }
    command.index = json["index"].get<std::size_t>();
  }
  return command;
}

LivePage live_page(const Scene& scene, const NetworkProblem& network, const NodeVectors& position,
                   const std::vector<std::string>& materials, const std::string& device) {
  Trace trace;
  trace.time = {0.0};
  trace.frames = {.time = {0.0}, .position = {position}};
  if (scene.needle || scene.probe) { trace.columns = tool_columns(scene); }
  for (Column& column : trace.columns) { column.values = {0.0}; }
  trace.text_columns = {{"tool.layer", {""}}, {"tool.event", {""}}};
  std::vector<std::string> notes;
  std::vector<ViewSurface> surfaces;
  if (std::optional<ViewSurface> skin = view_of_skin(scene, notes)) {
    surfaces.push_back(std::move(*skin));
  }
  View view = make_view({scene, network, trace, std::move(surfaces)}).value();
  const Eigen::Vector3d extent = view.rest.rowwise().maxCoeff() - view.rest.rowwise().minCoeff();
  LivePage page{.quantiser = Quantiser(view.nodes, network.network().rest_position,
                                       std::max(extent.maxCoeff(), 1e-6)),
                .has_tool = scene.needle || scene.probe,
                .has_pressure = scene.syringe && scene.needle};
  const EncodedView encoded = encode(view);
  const Drive drive = scene.drive.value_or(Drive{});
  double deepest = 0.5 * extent.maxCoeff();
  if (page.has_tool) {
    const NeedlePath path(scene, network.network());
    for (const PathInterval& interval : path.intervals()) {
      page.layers.emplace_back(interval.begin, interval.label);
    }
    deepest = drive.depth.value_or(scene.needle ? 0.9 * extent.z() : 0.1 * extent.z());
  }
  const Json about =
      object("title", scene.title.empty() ? "Live simulation" : scene.title, "tool", page.has_tool,
             "needle", scene.needle.has_value(), "pressure", page.has_pressure, "step",
             page.quantiser.step(), "nodes", page.quantiser.size() / 3, "materials", materials,
             "device", device, "speed", drive.speed, "period", scene.simulation.step, "depth",
             deepest, "from", drive.from, "notes", notes);
  std::string body(assets::live_html);
  const std::string mark = "<!--view-->";
  body.replace(body.find(mark), mark.size(), assets::view_html);
  page.html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<link rel=\"icon\" href=\"data:,\"><title>" +
      escape_markup(scene.title.empty() ? "Live simulation" : scene.title) + "</title>\n<style>\n";
  for (const std::string_view style : {assets::report_css, assets::view_css, assets::live_css}) {
    page.html += style;
  }
  std::string about_text = about.dump();
  for (auto at = about_text.find('<'); at != about_text.npos; at = about_text.find('<', at)) {
    about_text.replace(at, 1, "\\u003c");
  }
  page.html += "</style></head><body>\n" + body +
               inert_script("view-header", "application/json", encoded.header) +
               inert_script("view-numbers", "text/plain", encoded.numbers) +
               inert_script("live-about", "application/json", about_text) + "<script>";
  page.html += assets::three_js;
  page.html += "</script>\n<script>(function () {\n'use strict';\n" + view_parts();
  page.html += assets::live_js;
  page.html += "})();\n</script></body></html>\n";
  return page;
}

// ---- connections; everything below runs on the server's thread ----

class LiveServer::Core {
 public:
  Core(LiveLoop& loop, LivePage page, std::string token, std::uint16_t port)
      : loop_(loop), page_(std::move(page)), acceptor_(context_), timer_(context_) {
    const tcp::endpoint here(asio::ip::address_v4::loopback(), port);
    acceptor_.open(here.protocol());
    acceptor_.set_option(tcp::acceptor::reuse_address(true));
    acceptor_.bind(here);
    acceptor_.listen();
    gate_ = {std::move(token), acceptor_.local_endpoint().port()};
  }

  void run() {
    accept();
    look();
    context_.run();
  }
  void stop() {
    asio::post(context_, [this] { context_.stop(); });
  }

  [[nodiscard]] const RequestCheck& gate() const { return gate_; }
  [[nodiscard]] const ServerCounts& counts() const { return counts_; }

 private:
  class Visit;
  class Viewer;

  void accept();
  void look();
  void send_frame();
  [[nodiscard]] Json state_json(const LiveState& state);
  [[nodiscard]] std::string layer_at(double depth) const;
  void take_events(const LiveState& state);

  LiveLoop& loop_;
  LivePage page_;
  RequestCheck gate_{};
  asio::io_context context_{1};
  tcp::acceptor acceptor_;
  asio::steady_timer timer_;
  std::list<std::shared_ptr<Viewer>> viewers_{};
  const Viewer* writer_ = nullptr;  ///< compared only
  std::vector<std::int16_t> values_{};
  std::vector<std::string> events_{};
  int events_run_ = 0;
  std::list<std::weak_ptr<Visit>> visits_{};  ///< requests being read, the oldest first
  ServerCounts counts_{};
};

/// One viewer. It has at most one message under way; a frame that comes meanwhile is dropped.
class LiveServer::Core::Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(Core& core, beast::tcp_stream stream) : core_(core), socket_(std::move(stream)) {}

  void begin(const http::request<http::empty_body>& request) {
    auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::server);
    timeout.idle_timeout = std::chrono::seconds(30);
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
    socket_.read_message_max(most_message);
    socket_.binary(true);
    beast::get_lowest_layer(socket_).expires_never();
    socket_.async_accept(request, [me = shared_from_this()](beast::error_code problem) {
      if (problem) { return; }
      me->core_.viewers_.push_back(me);
      me->read();
    });
  }

  /// Sends the frame unless the one before is still under way.
  void send(Json state, const std::vector<std::int16_t>& values) {
    if (writing_) {
      ++dropped_;
      ++core_.counts_.dropped;
      keyframe_ = true;
      return;
    }
    state["dropped"] = dropped_;
    state["writer"] = core_.writer_ == this      ? "you"
                      : core_.writer_ == nullptr ? "nobody"
                                                 : "another";
    message_ = frame_of(keyframe_, state.dump(), values, sent_);
    sent_ = values;
    keyframe_ = false;
    writing_ = true;
    ++core_.counts_.frames;
    core_.counts_.bytes += message_.size();
    socket_.async_write(asio::buffer(message_),
                        [me = shared_from_this()](beast::error_code problem, std::size_t) {
                          me->writing_ = false;
                          if (problem) { me->leave(); }
                        });
  }

 private:
  void read() {
    socket_.async_read(buffer_, [me = shared_from_this()](beast::error_code problem, std::size_t) {
      if (problem) { return me->leave(); }
      const std::string message = beast::buffers_to_string(me->buffer_.data());
      me->buffer_.consume(me->buffer_.size());
      if (!me->rate_.allows(now())) {
        ++me->core_.counts_.refused;
        return me->leave();
      }
      me->obey(message);
      me->read();
    });
  }

  /// The first viewer that gives a command is the only one that may, until it leaves.
  void obey(const std::string& message) {
    const std::optional<Command> command = command_of(message);
    if (!command) {
      ++core_.counts_.refused;
      return;
    }
    if (core_.writer_ == nullptr) { core_.writer_ = this; }
    const bool emergency = command->kind == Command::Kind::stop;  // everybody may
    if (core_.writer_ == this || emergency) { (void)core_.loop_.commands.push(*command); }
  }

  void leave() {
    if (core_.writer_ == this) { core_.writer_ = nullptr; }
    core_.viewers_.remove(shared_from_this());
    beast::get_lowest_layer(socket_).close();
  }

  Core& core_;
  websocket::stream<beast::tcp_stream> socket_;
  beast::flat_buffer buffer_{};
  RateLimit rate_{most_messages_per_second, most_messages_at_once};
  std::string message_{};
  std::vector<std::int16_t> sent_{};
  bool keyframe_ = true;
  bool writing_ = false;
  long dropped_ = 0;
};

/// One request: the page, the socket, or a refusal.
class LiveServer::Core::Visit : public std::enable_shared_from_this<Visit> {
 public:
  Visit(Core& core, tcp::socket socket) : core_(core), stream_(std::move(socket)) {
    parser_.header_limit(most_header);
    parser_.body_limit(0);
  }

  void begin() {
    stream_.expires_after(request_timeout);
    http::async_read(stream_, buffer_, parser_,
                     [me = shared_from_this()](beast::error_code problem, std::size_t) {
                       if (!problem) { return me->answer(); }
                       const auto& of_http =
                           http::make_error_code(http::error::bad_field).category();
                       if (problem.category() == of_http && problem != http::error::end_of_stream) {
                         me->refuse(http::status::bad_request, problem.message());
                       }
                     });
  }

  void close() { stream_.close(); }

 private:
  void answer() {
    const auto& request = parser_.get();
    const std::string_view target = view_of(request.target());
    const auto field = [&](http::field name) { return view_of(request[name]); };
    if (request.count(http::field::host) != 1 ||
        !core_.gate_.allows_host(field(http::field::host))) {
      return refuse(http::status::forbidden, "unknown host");
    }
    if (request.count(http::field::origin) > 0 &&
        !core_.gate_.allows_origin(field(http::field::origin))) {
      return refuse(http::status::forbidden, "unknown origin");
    }
    if (request.method() != http::verb::get) {
      return refuse(http::status::method_not_allowed, "only GET");
    }
    if (websocket::is_upgrade(request)) {
      if (!core_.gate_.allows_target(target, "/socket") ||
          !core_.gate_.allows_origin(field(http::field::origin))) {
        return refuse(http::status::forbidden, "token or origin is wrong");
      }
      if (core_.viewers_.size() >= most_viewers) {
        return refuse(http::status::service_unavailable, "too many viewers");
      }
      std::make_shared<Viewer>(core_, std::move(stream_))->begin(parser_.release());
      return;
    }
    if (!core_.gate_.allows_target(target, "/")) {
      return refuse(http::status::forbidden, "use the address that palpate live printed");
    }
    reply(http::status::ok, "text/html; charset=utf-8", core_.page_.html);
  }

  void refuse(http::status status, const std::string& why) {
    ++core_.counts_.refused;
    reply(status, "text/plain", why + "\n");
  }

  void reply(http::status status, const char* type, std::string body) {
    response_.result(status);
    response_.version(11);
    response_.keep_alive(false);
    response_.set(http::field::content_type, type);
    response_.set(http::field::cache_control, "no-store");
    response_.set("Referrer-Policy", "no-referrer");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("X-Frame-Options", "DENY");
    const std::string port = std::to_string(core_.gate_.port);
    response_.set(
        "Content-Security-Policy",
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
        "img-src data: blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'; "
        "connect-src ws://127.0.0.1:" +
            port + " ws://localhost:" + port);
    response_.body() = std::move(body);
    response_.prepare_payload();
    http::async_write(stream_, response_,
                      [me = shared_from_this()](beast::error_code, std::size_t) {
                        beast::error_code ignored;
                        me->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
                      });
  }

  Core& core_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{2 * most_header};
  http::request_parser<http::empty_body> parser_{};
  http::response<http::string_body> response_{};
};

void LiveServer::Core::accept() {
  acceptor_.async_accept([this](beast::error_code problem, tcp::socket socket) {
    if (!problem) {
      beast::error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      socket.set_option(asio::socket_base::send_buffer_size(most_behind), ignored);
      std::erase_if(visits_, [](const auto& visit) { return visit.expired(); });
      if (visits_.size() == 2 * most_viewers) {  // those that send nothing do not keep others out
        visits_.front().lock()->close();
        visits_.pop_front();
        ++counts_.refused;
      }
      const auto visit = std::make_shared<Visit>(*this, std::move(socket));
      visits_.push_back(visit);
      visit->begin();
    }
    accept();
  });
}

void LiveServer::Core::look() {
  timer_.expires_after(look_period);
  timer_.async_wait([this](beast::error_code problem) {
    if (problem) { return; }
    if (loop_.snapshots.update()) { send_frame(); }
    look();
  });
}

void LiveServer::Core::send_frame() {
  const Snapshot& snapshot = loop_.snapshots.front();
  ++counts_.snapshots;
  if (!snapshot.whole()) {
    ++counts_.torn;
    return;
  }
  take_events(snapshot.state);
  if (viewers_.empty()) { return; }
  page_.quantiser.quantise(snapshot.position, values_);
  const Json state = state_json(snapshot.state);
  const auto all = viewers_;  // a failed send may remove one
  for (const std::shared_ptr<Viewer>& viewer : all) { viewer->send(state, values_); }
}

void LiveServer::Core::take_events(const LiveState& state) {
  const int run = static_cast<int>(state.run);
  if (run != events_run_) {
    events_.clear();
    events_run_ = run;
  }
  LiveEvent event;
  while (loop_.events.pop(event)) {
    if (event.run != run) { continue; }
    const std::size_t interval = event.happening.interval;
    const std::string layer = interval < page_.layers.size() ? page_.layers[interval].second : "";
    std::array<char, 32> time{};
    std::snprintf(time.data(), time.size(), "%.3f s  ", event.happening.time);
    events_.push_back(time.data() + std::string(name_of(event.happening.event)) +
                      (layer.empty() ? "" : ", " + layer));
    if (events_.size() > events_shown) { events_.erase(events_.begin()); }
  }
}

std::string LiveServer::Core::layer_at(double depth) const {
  if (!(depth > 0.0)) { return ""; }
  std::string label;
  for (const auto& [begin, name] : page_.layers) {
    if (begin <= depth) { label = name; }
  }
  return label;
}

Json LiveServer::Core::state_json(const LiveState& state) {
  const auto whole = [](double number) { return static_cast<long>(number); };
  return object("time", state.time, "applied", state.applied, "reaction", state.reaction, "depth",
                state.depth, "cutting", state.cutting, "friction", state.friction, "pressing",
                state.pressing, "pressure", state.pressure, "place", state.place, "grip",
                state.grip, "target", state.target, "speed", state.speed, "ticks",
                whole(state.ticks), "periods", whole(state.periods), "missed", whole(state.missed),
                "worst", state.worst, "pace", state.pace, "left_out", state.left_out, "too_slow",
                state.too_slow != 0.0, "running", state.running != 0.0, "ended", whole(state.ended),
                "run", whole(state.run), "lost_rows", whole(state.lost_rows), "changing",
                whole(state.changing), "changed", state.changed, "device", whole(state.device),
                "device_force", state.device_force, "layer", layer_at(state.depth), "events",
                events_, "torn", counts_.torn, "viewers", static_cast<long>(viewers_.size()));
}

LiveServer::LiveServer(LiveLoop& loop, LivePage page, std::string token, std::uint16_t port)
    : core_(std::make_unique<Core>(loop, std::move(page), std::move(token), port)) {}

LiveServer::~LiveServer() { stop(); }

std::uint16_t LiveServer::port() const { return core_->gate().port; }

std::string LiveServer::url() const {
  return "http://127.0.0.1:" + std::to_string(port()) + "/?token=" + core_->gate().token;
}

void LiveServer::start() {
  thread_ = std::thread([this] { core_->run(); });
}

void LiveServer::stop() {
  if (!thread_.joinable()) { return; }
  core_->stop();
  thread_.join();
}

const ServerCounts& LiveServer::counts() const { return core_->counts(); }

}  // namespace palpate::live
