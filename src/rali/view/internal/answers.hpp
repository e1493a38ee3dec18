#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/view/view_server.hpp"

namespace rali::view {

inline constexpr std::size_t kOrdersMax = 64;  ///< pending for the host
inline constexpr std::size_t kVehicleNameMax = 64;

struct HttpRequest {
  std::string_view method, path, content_type, body;
};

/// An answer of the server; `body` is shared, because the page is large.
struct HttpAnswer {
  int status = 200;
  std::string_view content_type = "text/plain; charset=utf-8";
  std::shared_ptr<const std::string> body;
  std::string_view allow;  ///< methods, with status 405
};

/// Input of the answers, as set by the host.
struct Published {
  bool healthy = false;
  std::string health = R"({"state":"starting"})";
  std::string metrics;
  std::string state;  ///< last message of /rali/state; empty: none yet
  std::vector<OperatorRequest> orders;
  int viewers = 0;
  std::uint64_t frames_dropped = 0;  ///< for slow viewers
};

/// Answers a request of an authorised client; an order is added to `published.orders`.
[[nodiscard]] HttpAnswer answer(const HttpRequest& request, Published& published);

/// An answer with one sentence.
[[nodiscard]] HttpAnswer refusal(int status, std::string_view sentence);

/// Reads the body of an order. Errors: kInput.
[[nodiscard]] Result<OperatorRequest> parse_order(std::string_view body);

/// The live page: one HTML with script and style inside.
[[nodiscard]] const std::shared_ptr<const std::string>& live_page();

}  // namespace rali::view
