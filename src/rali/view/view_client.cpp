#include "rali/view/view_client.hpp"

#include <charconv>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <fmt/format.h>

namespace rali::view {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

constexpr std::chrono::seconds kWait{5};
constexpr std::uint64_t kReplyBytesMax = 16U << 20U;

tl::unexpected<Error> bad_address(std::string_view url, std::string what) {
  return fail(ErrorCode::kUsage, std::string(url.substr(0, 80)), std::move(what),
              "Write it as http://127.0.0.1:8765.");
}

/// One request and its reply; each step starts the next.
class Call {
 public:
  Call(const ViewAddress& address, const std::string& target, const std::string& body)
      : address_(address) {
    request_ = {body.empty() ? http::verb::get : http::verb::post, target, 11, body};
    request_.set(http::field::host, fmt::format("{}:{}", address.host, address.port));
    request_.set(http::field::connection, "close");
    if (!body.empty()) request_.set(http::field::content_type, "application/json");
    if (!address.token.empty()) request_.set(http::field::authorization, "Bearer " + address.token);
    request_.prepare_payload();
    parser_.body_limit(kReplyBytesMax);
  }

  Result<ViewReply> run() {
    resolver_.async_resolve(address_.host, std::to_string(address_.port),
                            [this](beast::error_code error, const auto& found) {
                              if (failed(error)) return;
                              connect(found);
                            });
    io_.run_for(2 * kWait);  // the resolver has no time limit of its own
    if (!done_) {
      const std::string why = error_ ? error_.message() : "no answer in time";
      return fail(ErrorCode::kMachine, address_.text(), "no vehicle answers here (" + why + ")",
                  "Is `rali run` going on that vehicle, and is this its address and port?");
    }
    return ViewReply{parser_.get().result_int(), parser_.get().body()};
  }

 private:
  [[nodiscard]] bool failed(beast::error_code error) {
    error_ = error;
    return bool(error);
  }

  void connect(const asio::ip::tcp::resolver::results_type& found) {
    stream_.expires_after(kWait);
    stream_.async_connect(found, [this](beast::error_code error, const auto&) {
      if (failed(error)) return;
      http::async_write(stream_, request_, [this](beast::error_code wrong, std::size_t) {
        if (failed(wrong)) return;
        read();
      });
    });
  }

  void read() {
    http::async_read(stream_, buffer_, parser_,
                     [this](beast::error_code error, std::size_t) { done_ = !failed(error); });
  }

  ViewAddress address_;
  asio::io_context io_{1};
  asio::ip::tcp::resolver resolver_{io_};
  beast::tcp_stream stream_{io_};
  http::request<http::string_body> request_;
  http::response_parser<http::string_body> parser_;
  beast::flat_buffer buffer_;
  beast::error_code error_;
  bool done_ = false;
};

}  // namespace

std::string ViewAddress::text() const { return fmt::format("http://{}:{}", host, port); }

Result<ViewAddress> parse_view_address(std::string_view url) {
  constexpr std::string_view kScheme = "http://";
  std::string_view rest = url;
  if (rest.substr(0, kScheme.size()) == kScheme) rest.remove_prefix(kScheme.size());
  if (rest.find("://") != std::string_view::npos)
    return bad_address(url, "only http is spoken here");
  ViewAddress out;
  const std::size_t query = rest.find('?');
  if (query != std::string_view::npos) {
    constexpr std::string_view kToken = "token=";
    const std::string_view field = rest.substr(query + 1);
    if (field.substr(0, kToken.size()) != kToken)
      return bad_address(url, "unknown word behind '?'");
    out.token = field.substr(kToken.size());
    rest = rest.substr(0, query);
  }
  if (!rest.empty() && rest.back() == '/') rest.remove_suffix(1);
  const std::size_t colon = rest.rfind(':');
  const bool has_port = colon != std::string_view::npos && rest.find(']', colon) == rest.npos;
  if (has_port) {
    const std::string_view text = rest.substr(colon + 1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out.port);
    if (error != std::errc() || end != text.data() + text.size() || out.port == 0) {
      return bad_address(url, "the port is no number from 1 to 65535");
    }
    rest = rest.substr(0, colon);
  }
  if (rest.size() > 2 && rest.front() == '[' && rest.back() == ']') {
    rest = rest.substr(1, rest.size() - 2);  // an IPv6 address
  }
  if (rest.empty() || rest.find_first_of("/ @[]") != rest.npos) {
    return bad_address(url, "this is no address of a view");
  }
  out.host = rest;
  return out;
}

Result<ViewReply> ask_view(const ViewAddress& address, const std::string& target,
                           const std::string& body) {
  return Call(address, target, body).run();
}

}  // namespace rali::view
