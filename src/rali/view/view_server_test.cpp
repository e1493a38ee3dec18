#include "rali/view/view_server.hpp"

#include <chrono>
#include <deque>
#include <thread>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace rali::view {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Clock = std::chrono::steady_clock;

std::unique_ptr<ViewServer> started(ViewOptions options = {}) {
  options.port = 0;
  auto server = start_view_server(options);
  EXPECT_TRUE(server) << server.error().message();
  return server ? std::move(*server) : nullptr;
}

ViewOptions options_of(std::string bind, std::uint16_t port, std::string token = {}) {
  ViewOptions options;
  options.bind = std::move(bind);
  options.port = port;
  options.token = std::move(token);
  return options;
}

ViewChannel channel(std::string topic, bool keep_last = false) {
  return {std::move(topic), "json", "rali/State", "jsonschema", "{}", keep_last};
}

std::vector<std::uint8_t> bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

/// Waits until `condition` holds, at most 5 s.
template <class F>
bool eventually(F condition) {
  const auto end = Clock::now() + std::chrono::seconds(5);
  while (!condition()) {
    if (Clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

tcp::socket connected(asio::io_context& io, const ViewServer& server) {
  tcp::socket socket(io);
  socket.connect({asio::ip::make_address("127.0.0.1"), server.port()});
  return socket;
}

struct Reply {
  unsigned status = 0;
  std::string body;
  http::fields fields;
};

Reply ask(const ViewServer& server, http::verb method, const std::string& target,
          const std::string& body = "", const std::string& token = "",
          const std::string& host = "127.0.0.1") {
  asio::io_context io;
  beast::tcp_stream stream(connected(io, server));
  http::request<http::string_body> request(method, target, 11);
  request.set(http::field::host, host);
  if (!body.empty()) request.set(http::field::content_type, "application/json");
  if (!token.empty()) request.set(http::field::authorization, "Bearer " + token);
  request.body() = body;
  request.prepare_payload();
  http::write(stream, request);
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(8U << 20U);
  if (method == http::verb::head) parser.skip(true);
  http::read(stream, buffer, parser);
  return {parser.get().result_int(), parser.get().body(), parser.get()};
}

/// The full reply of a connection to raw bytes until it is closed.
std::string answer_to(const ViewServer& server, const std::string& bytes) {
  asio::io_context io;
  tcp::socket socket = connected(io, server);
  beast::error_code error;
  asio::write(socket, asio::buffer(bytes), error);
  socket.shutdown(tcp::socket::shutdown_send, error);
  std::string out;
  asio::read(socket, asio::dynamic_buffer(out), error);
  return out;
}

/// A viewer that speaks the protocol.
class TestViewer {
 public:
  explicit TestViewer(const ViewServer& server, const std::string& protocol = "foxglove.sdk.v1",
                      const std::string& target = "/")
      : ws_(connected(io_, server)) {
    ws_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      request.set(http::field::sec_websocket_protocol, protocol);
    }));
    ws_.read_message_max(64U << 20U);
    websocket::response_type response;
    ws_.handshake(response, fmt::format("127.0.0.1:{}", server.port()), target);
    protocol_ = std::string(response[http::field::sec_websocket_protocol]);
  }

  std::string read() {
    beast::flat_buffer buffer;
    ws_.read(buffer);
    return beast::buffers_to_string(buffer.data());
  }

  void send(const std::string& text) { ws_.write(asio::buffer(text)); }

  void subscribe(int id, int to) {
    send(fmt::format(R"({{"op":"subscribe","subscriptions":[{{"id":{},"channelId":{}}}]}})", id,
                     to));
  }

  [[nodiscard]] const std::string& protocol() const { return protocol_; }

 private:
  asio::io_context io_;
  websocket::stream<tcp::socket> ws_;
  std::string protocol_;
};

TEST(ViewServer, answers_page_health_metrics_and_state) {
  const auto server = started();
  const int state = server->add_channel(channel("/rali/state", true));
  EXPECT_EQ(ask(*server, http::verb::get, "/healthz").status, 503U);
  server->set_health(true, R"({"state":"ok"})");
  server->set_metrics("rali_term 3\n");
  server->publish(state, Time{1}, bytes_of(R"({"schema":1})"));
  EXPECT_EQ(ask(*server, http::verb::get, "/healthz").status, 200U);
  EXPECT_EQ(ask(*server, http::verb::get, "/state?x").body, R"({"schema":1})");
  EXPECT_NE(ask(*server, http::verb::get, "/metrics").body.find("rali_term 3\n"),
            std::string::npos);
  Reply page = ask(*server, http::verb::get, "/");
  EXPECT_NE(page.body.find("<title>RaLI</title>"), std::string::npos);
  EXPECT_EQ(page.fields["Content-Security-Policy"].substr(0, 18), "default-src 'none'");
  Reply head = ask(*server, http::verb::head, "/");
  EXPECT_EQ(head.fields["Content-Length"], std::to_string(page.body.size()));
  EXPECT_TRUE(head.body.empty());
}

TEST(ViewServer, accepts_both_protocol_names_and_sends_subscribed_channels) {
  const auto server = started();
  const int a = server->add_channel(channel("/a"));
  for (const char* name : {"foxglove.websocket.v1", "foxglove.sdk.v1"}) {
    TestViewer viewer(*server, name);
    EXPECT_EQ(viewer.protocol(), name);
    EXPECT_NE(viewer.read().find("\"serverInfo\""), std::string::npos);
    EXPECT_NE(viewer.read().find("\"topic\":\"/a\""), std::string::npos);
    viewer.subscribe(300, a);
    viewer.send("nonsense");  // its error reply shows that the subscription has been read
    EXPECT_NE(viewer.read().find("\"status\""), std::string::npos);
    server->publish(a, Time{0x0102}, bytes_of("hello"));
    const std::string frame = viewer.read();
    EXPECT_EQ(frame, std::string("\x01\x2C\x01\0\0\x02\x01\0\0\0\0\0\0hello", 18));
  }
}

TEST(ViewServer, refuses_a_websocket_of_another_protocol) {
  const auto server = started();
  EXPECT_THROW(TestViewer(*server, "mqtt"), beast::system_error);
}

TEST(ViewServer, advertises_channels_added_later) {
  const auto server = started();
  TestViewer viewer(*server);
  (void)viewer.read();
  (void)server->add_channel(channel("/later"));
  EXPECT_NE(viewer.read().find("\"topic\":\"/later\""), std::string::npos);
}

TEST(ViewServer, gives_a_late_subscriber_the_last_frame) {
  const auto server = started();
  const int kept = server->add_channel(channel("/kept", true));
  server->publish(kept, Time{1}, bytes_of("old"));
  server->publish(kept, Time{2}, bytes_of("new"));
  TestViewer viewer(*server);
  (void)viewer.read();
  (void)viewer.read();
  viewer.subscribe(1, kept);
  EXPECT_EQ(viewer.read().substr(13), "new");
}

TEST(ViewServer, a_stalled_viewer_loses_frames_without_delaying_others) {
  ViewOptions options;
  options.queue_bytes = 1U << 20U;
  const auto server = started(options);
  const int a = server->add_channel(channel("/a"));
  TestViewer slow(*server), quick(*server);
  for (TestViewer* viewer : {&slow, &quick}) {
    (void)viewer->read();
    (void)viewer->read();
    viewer->subscribe(1, a);
    viewer->send("nonsense");
    (void)viewer->read();
  }
  constexpr int kFrames = 200;
  std::vector<std::uint8_t> frame(200'000);
  double longest_s = 0.0;
  for (int i = 1; i <= kFrames; ++i) {  // 40 MB, far beyond the capacity of sockets and queue
    frame[0] = static_cast<std::uint8_t>(i);
    const auto before = Clock::now();
    server->publish(a, Time{i}, frame);
    longest_s = std::max(longest_s, std::chrono::duration<double>(Clock::now() - before).count());
    EXPECT_EQ(static_cast<std::uint8_t>(quick.read()[13]), i) << "the quick one gets each at once";
  }
  EXPECT_LT(longest_s, 0.2) << "publish() copies 200 kB and waits for nobody";
  std::int64_t last = 0;
  int got = 0;
  while (last != kFrames) {
    const std::string data = slow.read();
    const std::int64_t t =
        static_cast<std::uint8_t>(data[5]) + 256 * static_cast<std::uint8_t>(data[6]);
    ASSERT_GT(t, last) << "in order, none twice";
    last = t;
    ++got;
  }
  EXPECT_LT(got, kFrames) << "but the newest has come";
  EXPECT_EQ(
      ask(*server, http::verb::get, "/metrics").body.find("rali_view_frames_dropped_total 0\n"),
      std::string::npos);
}

TEST(ViewServer, returns_each_operator_command_once) {
  const auto server = started();
  EXPECT_EQ(
      ask(*server, http::verb::post, "/operator", R"({"command":"assume-lost","vehicle":"v2"})")
          .status,
      202U);
  EXPECT_EQ(ask(*server, http::verb::post, "/operator", "no").status, 400U);
  const auto orders = server->take_requests();
  ASSERT_EQ(orders.size(), 1U);
  EXPECT_EQ(orders[0].command, "assume-lost");
  EXPECT_EQ(orders[0].vehicle, "v2");
  EXPECT_TRUE(server->take_requests().empty());
}

TEST(ViewServer, a_foreign_host_name_on_loopback_needs_the_token) {
  ViewOptions options;
  options.token = "0123456789abcdef";
  const auto server = started(options);
  EXPECT_EQ(ask(*server, http::verb::get, "/state", "", "", "evil.org").status, 403U);
  EXPECT_EQ(ask(*server, http::verb::get, "/metrics", "", options.token, "robot.lan").status, 200U);
}

TEST(ViewServer, needs_a_valid_token_beyond_loopback) {
  for (const char* token : {"", "short", "0123456789abcde?"}) {
    const auto server = start_view_server(options_of("0.0.0.0", 0, token));
    ASSERT_FALSE(server) << token;
    EXPECT_EQ(server.error().code, ErrorCode::kInput);
    EXPECT_NE(server.error().message().find("token"), std::string::npos);
  }
  EXPECT_TRUE(start_view_server(options_of("0.0.0.0", 0, "0123456789abcdef")));
  const auto named = start_view_server(options_of("robot.lan", 0));
  ASSERT_FALSE(named);
  EXPECT_NE(named.error().message().find("'robot.lan' is no IP address"), std::string::npos);
}

TEST(ViewServer, another_machine_without_the_token_is_refused) {
  // Another address of this machine, if there is one, represents another machine.
  asio::io_context io;
  asio::ip::udp::socket probe(io, asio::ip::udp::v4());
  beast::error_code error;
  probe.connect({asio::ip::make_address("192.0.2.1"), 9}, error);
  const auto own = probe.local_endpoint(error).address();
  if (error || own.is_loopback() || own.is_unspecified()) GTEST_SKIP() << "NO SECOND ADDRESS";
  const auto server = started(options_of("0.0.0.0", 0, "0123456789abcdef"));
  const auto status = [&](const std::string& target) {
    tcp::socket socket(io);
    socket.connect({own, server->port()});
    asio::write(socket, asio::buffer("GET " + target + " HTTP/1.1\r\nHost: x\r\n\r\n"));
    std::string line(12, ' ');
    asio::read(socket, asio::buffer(line));
    return line.substr(9);
  };
  for (const char* target : {"/", "/state", "/metrics", "/healthz", "/operator"}) {
    EXPECT_EQ(status(target), "401") << target;
  }
  EXPECT_EQ(status("/?token=0123456789abcdef"), "200");
}

TEST(ViewServer, a_port_in_use_is_an_error_with_a_remedy) {
  const auto server = started();
  const auto second = start_view_server(options_of("127.0.0.1", server->port()));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kMachine);
  EXPECT_EQ(second.error().message(),
            fmt::format("127.0.0.1:{}: another program listens on this port. Stop it ('ss -ltnp' "
                        "names it) or choose another port; 0 takes any free one.",
                        server->port()));
}

TEST(ViewServer, survives_invalid_http) {
  const auto server = started();
  std::string noise;
  for (int i = 0; i < 3000; ++i) noise += static_cast<char>(i * 7919 >> 3);
  const std::string upgrade =
      "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: upgrade\r\n"
      "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
      "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n";
  for (const std::string& bytes :
       {std::string(), noise, std::string("GET\r\n\r\n"), std::string("\r\n\r\n\r\n"),
        "GET / HTTP/1.1\r\nX: " + std::string(20000, 'a'),
        std::string("POST /operator HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999\r\n\r\n"),
        std::string("POST /operator HTTP/1.1\r\nContent-Length: -1\r\n\r\n"), upgrade + noise,
        upgrade.substr(0, 100)}) {
    const std::string answer = answer_to(*server, bytes);
    EXPECT_EQ(answer.find("HTTP/1.1 2"), std::string::npos) << bytes.substr(0, 60);
  }
  EXPECT_EQ(answer_to(*server, "GET / HTTP/1.1\r\nX: " + std::string(20000, 'a')).substr(0, 12),
            "HTTP/1.1 431");
  EXPECT_EQ(ask(*server, http::verb::get, "/metrics").status, 200U) << "and still answers";
}

TEST(ViewServer, disconnects_viewers_that_send_oversized_or_many_invalid_messages) {
  const auto server = started();
  TestViewer big(*server), silly(*server);
  EXPECT_THROW(
      {
        big.send(std::string(100'000, 'x'));
        for (int i = 0; i < 100; ++i) (void)big.read();
      },
      beast::system_error);
  EXPECT_THROW(
      {
        for (int i = 0; i < 30; ++i) silly.send("nonsense");
        for (int i = 0; i < 100; ++i) (void)silly.read();
      },
      beast::system_error);
  EXPECT_TRUE(eventually([&] { return server->viewers() == 0; }));
}

TEST(ViewServer, serves_a_hundred_connections_of_which_64_are_viewers) {
  const auto server = started();
  std::deque<TestViewer> viewers;
  int refused = 0;
  for (int i = 0; i < 100; ++i) {
    try {
      viewers.emplace_back(*server);
      (void)viewers.back().read();  // the server counts it from here
    } catch (const beast::system_error&) {
      ++refused;
    }
  }
  EXPECT_EQ(server->viewers(), 64);
  EXPECT_EQ(refused, 36);
  EXPECT_EQ(ask(*server, http::verb::get, "/metrics").status, 200U);
  viewers.clear();
  EXPECT_TRUE(eventually([&] { return server->viewers() == 0; }));
  TestViewer again(*server);
  EXPECT_NE(again.read().find("\"serverInfo\""), std::string::npos);
}

TEST(ViewServer, shuts_down_within_2_s_and_closes_connected_viewers_properly) {
  auto server = started();
  TestViewer viewer(*server);
  (void)viewer.read();
  asio::io_context io;
  const tcp::socket idle = connected(io, *server);
  const auto before = Clock::now();
  std::thread end([&] { server.reset(); });
  try {
    (void)viewer.read();
    ADD_FAILURE() << "nothing was sent";
  } catch (const beast::system_error& error) {
    EXPECT_EQ(error.code(), websocket::error::closed);
  }
  end.join();
  EXPECT_LT(Clock::now() - before, std::chrono::seconds(2));
}

}  // namespace
}  // namespace rali::view
