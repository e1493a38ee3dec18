#pragma once

// Included by beast_server.cpp alone: Beast costs 22 s of compilation.
#include <fmt/format.h>

#include "rali/view/internal/access.hpp"
#include "rali/view/internal/viewer.hpp"

namespace rali::view {

inline constexpr std::uint32_t kHeaderBytesMax = 8192;
inline constexpr std::uint64_t kBodyBytesMax = 4096;

/// The page may load nothing from elsewhere and may not be framed.
inline constexpr std::string_view kPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: "
    "blob:; "
    "connect-src 'self' ws: wss:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

inline std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

inline bool is_loopback(const asio::ip::address& address) {
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).is_loopback();
  }
  return address.is_loopback();
}

/// An HTTP connection: requests one after another, until one asks for the WebSocket.
class HttpSession final : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(asio::ip::tcp::socket socket, Hub& hub, std::shared_ptr<Connection> connection,
              std::string session)
      : connection_(std::move(connection)),
        hub_(hub),
        session_(std::move(session)),
        stream_(std::move(socket)) {
    beast::error_code error;
    const auto peer = stream_.socket().remote_endpoint(error);
    from_loopback_ = !error && is_loopback(peer.address());
  }

  void read() {
    parser_.emplace();
    parser_->header_limit(kHeaderBytesMax);
    parser_->body_limit(kBodyBytesMax);
    stream_.expires_after(std::chrono::seconds(10));
    http::async_read(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](beast::error_code error, std::size_t) { self->take(error); });
  }

 private:
  void take(beast::error_code error) {
    if (error == http::error::header_limit) return refuse(431, "The header is too long.");
    if (error == http::error::body_limit) return refuse(413, "The body is too long.");
    if (error.category() == http::make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message) {
      return refuse(400, "This is no HTTP request.");
    }
    if (error) return;
    request_ = parser_->release();
    const bool websocket = websocket::is_upgrade(request_);
    const Access access = access_of({.from_loopback = from_loopback_,
                                     .websocket = websocket,
                                     .target = view_of(request_.target()),
                                     .authorization = view_of(request_[http::field::authorization]),
                                     .host = view_of(request_[http::field::host]),
                                     .origin = view_of(request_[http::field::origin])},
                                    hub_.token());
    if (access != Access::kGranted) {
      return send(refusal(access == Access::kNoToken ? 401 : 403, refusal_words(access)));
    }
    if (websocket) return upgrade();
    send(answer_now());
  }

  [[nodiscard]] HttpAnswer answer_now() {
    Exchange& exchange = hub_.exchange();
    const std::lock_guard lock(exchange.mutex);
    return answer({.method = view_of(request_.method_string()),
                   .path = path_of(view_of(request_.target())),
                   .content_type = view_of(request_[http::field::content_type]),
                   .body = request_.body()},
                  exchange.published);
  }

  void upgrade() {
    const std::string_view name =
        choose_subprotocol(view_of(request_[http::field::sec_websocket_protocol]));
    if (name.empty()) {
      return send(refusal(400,
                          "The WebSocket here speaks foxglove.websocket.v1 or "
                          "foxglove.sdk.v1."));
    }
    if (!hub_.has_room()) return send(refusal(503, "There are enough viewers. Close another one."));
    // A viewer's stream has its own time limits, and short kernel buffers so that waiting frames
    // can still be dropped.
    stream_.expires_never();
    beast::error_code ignored;
    stream_.socket().set_option(asio::ip::tcp::no_delay(true), ignored);
    stream_.socket().set_option(asio::socket_base::send_buffer_size(256 << 10), ignored);
    std::make_shared<Viewer>(std::move(stream_), hub_, connection_)
        ->accept(request_, name, session_);
  }

  void refuse(int status, std::string_view sentence) {
    request_ = {};
    request_.keep_alive(false);
    send(refusal(status, sentence));
  }

  void send(HttpAnswer answer) {
    answer_ = std::move(answer);
    response_ = {};
    response_.version(11);
    response_.result(static_cast<unsigned>(answer_.status));
    const auto set = [this](auto field, std::string_view value) {
      response_.set(field, beast::string_view(value.data(), value.size()));
    };
    set(http::field::content_type, answer_.content_type);
    set(http::field::cache_control, "no-store");
    set("Referrer-Policy", "no-referrer");  // the address may hold the token
    set("X-Content-Type-Options", "nosniff");
    set("Content-Security-Policy", kPolicy);
    if (answer_.status == 401) set(http::field::www_authenticate, "Bearer");
    if (!answer_.allow.empty()) set(http::field::allow, answer_.allow);
    response_.keep_alive(request_.keep_alive());
    response_.content_length(answer_.body->size());
    if (request_.method() != http::verb::head) {
      response_.body() = beast::span<const char>(answer_.body->data(), answer_.body->size());
    }
    stream_.expires_after(std::chrono::seconds(60));  // for loading the page over a slow radio
    http::async_write(
        stream_, response_,
        [self = shared_from_this()](beast::error_code error, std::size_t) { self->sent(error); });
  }

  void sent(beast::error_code error) {
    if (error) return;
    if (response_.keep_alive()) return read();
    stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, error);
  }

  std::shared_ptr<Connection> connection_;
  Hub& hub_;
  std::string session_;
  beast::tcp_stream stream_;
  bool from_loopback_ = false;
  beast::flat_buffer buffer_{kHeaderBytesMax + kBodyBytesMax};
  std::optional<http::request_parser<http::string_body>> parser_;
  HttpMessage request_;
  HttpAnswer answer_;
  http::response<http::span_body<const char>> response_;
};

}  // namespace rali::view
