// The one file that is compiled with Beast's server side.
#include <thread>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "rali/base/assert.hpp"
#include "rali/view/internal/http_session.hpp"
#include "rali/view/view_server.hpp"

namespace rali::view {
namespace {

using asio::ip::tcp;

constexpr std::size_t kTokenBytesMin = 16;
constexpr std::chrono::milliseconds kFarewell{300};  ///< for closing viewers when the server stops

class BeastServer final : public ViewServer {
 public:
  explicit BeastServer(const ViewOptions& options)
      : exchange_(options.queue_bytes), hub_(exchange_, options.token, options.queue_bytes) {}

  ~BeastServer() override {
    if (!thread_.joinable()) return;
    asio::post(io_, [this] { stop(); });
    thread_.join();
    stopping_ = false;  // the rest is destroyed with `io_` and need not stop it again
  }

  BeastServer(const BeastServer&) = delete;
  BeastServer& operator=(const BeastServer&) = delete;

  [[nodiscard]] Status listen(const tcp::endpoint& endpoint);

  [[nodiscard]] std::uint16_t port() const override { return port_; }

  [[nodiscard]] int add_channel(const ViewChannel& channel) override {
    {
      const std::lock_guard lock(exchange_.mutex);
      ++channels_;
      if (channel.topic == "/rali/state") state_channel_ = channels_;
      exchange_.new_channels.push_back({static_cast<std::uint32_t>(channels_), channel});
    }
    wake();
    return channels_;
  }

  void publish(int channel, Time t, std::span<const std::uint8_t> bytes) override {
    RALI_ASSERT(channel >= 1 && channel <= channels_);
    auto frame = std::make_shared<Frame>();
    *frame = {static_cast<std::uint32_t>(channel), t, {bytes.begin(), bytes.end()}};
    {
      const std::lock_guard lock(exchange_.mutex);
      if (channel == state_channel_) exchange_.published.state.assign(bytes.begin(), bytes.end());
      exchange_.published.frames_dropped += exchange_.inbox.push(std::move(frame));
    }
    wake();
  }

  void set_health(bool healthy, std::string json) override {
    const std::lock_guard lock(exchange_.mutex);
    exchange_.published.healthy = healthy;
    exchange_.published.health = std::move(json);
  }

  void set_metrics(std::string text) override {
    const std::lock_guard lock(exchange_.mutex);
    exchange_.published.metrics = std::move(text);
  }

  [[nodiscard]] std::vector<OperatorRequest> take_requests() override {
    const std::lock_guard lock(exchange_.mutex);
    return std::exchange(exchange_.published.orders, {});
  }

  [[nodiscard]] int viewers() const override {
    const std::lock_guard lock(exchange_.mutex);
    return exchange_.published.viewers;
  }

 private:
  /// Asks the server's thread to check for input, once until it has checked.
  void wake() {
    {
      const std::lock_guard lock(exchange_.mutex);
      if (std::exchange(exchange_.woken, true)) return;
    }
    asio::post(io_, [this] { hub_.take_over(); });
  }

  void run();
  void accept();
  void take(tcp::socket socket);
  void stop();

  // This order: connections destroyed with `io_` decrement a counter in `hub_`.
  mutable Exchange exchange_;
  Hub hub_;
  bool stopping_ = false;
  std::string session_;
  asio::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer timer_{io_};
  std::uint16_t port_ = 0;
  int channels_ = 0, state_channel_ = 0;
  std::thread thread_;
};

Status BeastServer::listen(const tcp::endpoint& endpoint) {
  const std::string where = fmt::format("{}:{}", endpoint.address().to_string(), endpoint.port());
  beast::error_code error;
  acceptor_.open(endpoint.protocol(), error);
  if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
  if (error == asio::error::address_in_use) {
    return fail(ErrorCode::kMachine, where, "another program listens on this port",
                "Stop it ('ss -ltnp' names it) or choose another port; 0 takes any free one.");
  }
  if (error == asio::error::access_denied) {
    return fail(ErrorCode::kMachine, where, "this port needs rights of the administrator",
                "Choose a port above 1023.");
  }
  if (error) {
    return fail(ErrorCode::kMachine, where, "cannot listen: " + error.message(),
                "Is it an address of this machine? 'ip address' lists them.");
  }
  port_ = acceptor_.local_endpoint().port();
  // A session identifies one run of the server: viewers detect a restart by it.
  session_ = fmt::format("{:x}", std::chrono::system_clock::now().time_since_epoch().count());
  accept();
  thread_ = std::thread([this] { run(); });
  return {};
}

/// A handler that throws (no memory) closes its connection, not the server.
void BeastServer::run() {
  while (true) {
    try {
      io_.run();
      return;
    } catch (const std::exception&) {
      continue;
    }
  }
}

void BeastServer::accept() {
  acceptor_.async_accept([this](beast::error_code error, tcp::socket socket) {
    if (stopping_) return;
    if (!error) {
      take(std::move(socket));
      return accept();
    }
    timer_.expires_after(std::chrono::milliseconds(100));  // no file descriptor is free
    timer_.async_wait([this](beast::error_code) {
      if (!stopping_) accept();
    });
  });
}

void BeastServer::take(tcp::socket socket) {
  if (hub_.connections >= kConnectionsMax) return;
  auto connection = std::make_shared<Connection>(hub_, io_, stopping_);
  std::make_shared<HttpSession>(std::move(socket), hub_, std::move(connection), session_)->read();
}

void BeastServer::stop() {
  stopping_ = true;
  beast::error_code ignored;
  acceptor_.close(ignored);
  if (hub_.connections == 0) return io_.stop();
  hub_.close_all();
  timer_.expires_after(kFarewell);
  timer_.async_wait([this](beast::error_code) { io_.stop(); });
}

Status check_token(const ViewOptions& options, bool loopback) {
  if (options.token.empty()) {
    if (loopback) return {};
    return fail(ErrorCode::kInput, "view of " + options.bind,
                "an address that others can reach needs a token",
                "Set a token of at least 16 characters, or listen on 127.0.0.1.");
  }
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~";
  if (options.token.size() < kTokenBytesMin ||
      options.token.find_first_not_of(kPlain) != std::string::npos) {
    return fail(ErrorCode::kInput, "view of " + options.bind,
                "the token is shorter than 16 characters or has others than a-z A-Z 0-9 - . _ ~",
                "Make one by 'openssl rand -hex 16'.");
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<ViewServer>> start_view_server(const ViewOptions& options) {
  beast::error_code error;
  const asio::ip::address address = asio::ip::make_address(options.bind, error);
  if (error) {
    return fail(ErrorCode::kInput, "view", fmt::format("'{}' is no IP address", options.bind),
                "Write 127.0.0.1, or 0.0.0.0 for all addresses of this machine.");
  }
  if (Status status = check_token(options, is_loopback(address)); !status) {
    return tl::make_unexpected(status.error());
  }
  auto server = std::make_unique<BeastServer>(options);
  if (Status status = server->listen({address, options.port}); !status) {
    return tl::make_unexpected(status.error());
  }
  return server;
}

}  // namespace rali::view
