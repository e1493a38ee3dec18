#pragma once

// Included by beast_server.cpp alone: Beast costs 22 s of compilation.
#include <array>
#include <chrono>
#include <deque>
#include <memory>
#include <string>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "rali/view/internal/viewer_channels.hpp"

namespace rali::view {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

/// Counts a connection while it lives; the last one of a stopping server ends its loop.
class Connection {
 public:
  Connection(Hub& hub, asio::io_context& io, const bool& stopping)
      : hub_(hub), io_(io), stopping_(stopping) {
    ++hub_.connections;
  }

  ~Connection() {
    if (--hub_.connections == 0 && stopping_) io_.stop();
  }

  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

 private:
  Hub& hub_;
  asio::io_context& io_;
  const bool& stopping_;
};

using HttpMessage = http::request<http::string_body>;

/// A WebSocket connection. One frame is in transit at a time; the others wait in a queue that can
/// drop them.
class Viewer final : public FrameSink, public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(beast::tcp_stream stream, Hub& hub, std::shared_ptr<Connection> connection)
      : connection_(std::move(connection)), hub_(hub), channels_(hub), ws_(std::move(stream)) {}

  ~Viewer() override {
    if (added_) hub_.remove(*this);
  }

  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  void accept(const HttpMessage& request, std::string_view subprotocol, std::string session) {
    // A viewer that is silent for this long is closed. A ping may also wait behind a large frame.
    ws_.set_option(
        websocket::stream_base::timeout{std::chrono::seconds(10), std::chrono::seconds(60), true});
    ws_.set_option(websocket::stream_base::decorator(
        [name = std::string(subprotocol)](websocket::response_type& answer) {
          answer.set(http::field::sec_websocket_protocol, name);
        }));
    ws_.read_message_max(kClientMessageBytesMax);
    ws_.auto_fragment(false);  // otherwise a frame of 1 MB is written in pieces of 4 kB
    ws_.async_accept(request, [self = shared_from_this(),
                               session = std::move(session)](beast::error_code error) {
      if (!error) self->start(session);
    });
  }

  void offer(const FramePtr& frame) override {
    channels_.offer(frame);
    write_next();
  }

  void send_text(std::string text) override {
    // A viewer that does not read its replies is closed.
    if (texts_.size() >= kTextsMax) return close();
    texts_.push_back(std::move(text));
    write_next();
  }

  void close() override { end(websocket::close_code::going_away); }

 private:
  static constexpr std::size_t kTextsMax = 64;

  void start(std::string_view session) {
    if (!hub_.has_room()) return end(websocket::close_code::try_again_later);
    added_ = true;
    hub_.add(*this, session);
    read();
  }

  void read() {
    ws_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (!error) self->take_message();
    });
  }

  void take_message() {
    const std::string message = beast::buffers_to_string(buffer_.data());
    buffer_.consume(buffer_.size());
    for (std::string& text : channels_.take(message, ws_.got_binary())) {
      send_text(std::move(text));
    }
    if (channels_.too_many_bad()) return end(websocket::close_code::policy_error);
    write_next();
    read();
  }

  void write_next() {
    if (writing_ || closing_) return;
    const auto done = [self = shared_from_this()](beast::error_code error, std::size_t) {
      self->writing_ = false;
      if (!error) self->write_next();
    };
    if (!texts_.empty()) {
      text_ = std::move(texts_.front());
      texts_.pop_front();
      writing_ = true;
      ws_.text(true);
      ws_.async_write(asio::buffer(text_), done);
      return;
    }
    std::optional<ViewerChannels::Next> next = channels_.next();
    if (!next) return;
    on_its_way_ = std::move(*next);
    writing_ = true;
    ws_.binary(true);
    ws_.async_write(std::array<asio::const_buffer, 2>{asio::buffer(on_its_way_.header),
                                                      asio::buffer(on_its_way_.frame->bytes)},
                    done);
  }

  void end(websocket::close_code code) {
    if (closing_) return;
    closing_ = true;
    ws_.async_close(code, [self = shared_from_this()](beast::error_code) {});
  }

  std::shared_ptr<Connection> connection_;
  Hub& hub_;
  ViewerChannels channels_;
  websocket::stream<beast::tcp_stream> ws_;
  beast::flat_buffer buffer_;
  std::deque<std::string> texts_;
  std::string text_;  ///< in transit
  ViewerChannels::Next on_its_way_;
  bool added_ = false, writing_ = false, closing_ = false;
};

}  // namespace rali::view
