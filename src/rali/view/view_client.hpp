#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "rali/base/result.hpp"

namespace rali::view {

/// Address of a view.
struct ViewAddress {
  std::string host = "127.0.0.1";
  std::uint16_t port = 8765;
  std::string token;  ///< empty: none

  /// "http://127.0.0.1:8765", without the token.
  [[nodiscard]] std::string text() const;
};

/// Reads "http://host[:port][/][?token=...]"; "http://" may be missing. Errors: kUsage.
[[nodiscard]] Result<ViewAddress> parse_view_address(std::string_view url);

struct ViewReply {
  unsigned status = 0;
  std::string body;
};

/// Sends GET, or POST if `body` is not empty (JSON). Waits 5 s at most. Any status is a reply.
/// Errors: kMachine (no reply; with a remedy).
[[nodiscard]] Result<ViewReply> ask_view(const ViewAddress& address, const std::string& target,
                                         const std::string& body = {});

}  // namespace rali::view
