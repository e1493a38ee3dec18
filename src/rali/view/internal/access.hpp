#pragma once

#include <string>
#include <string_view>

namespace rali::view {

/// What decides whether a request is answered.
struct AccessRequest {
  bool from_loopback = false;  ///< address of the peer
  bool websocket = false;
  std::string_view target = {};         ///< "/state?token=..."
  std::string_view authorization = {};  ///< "Bearer ..."
  std::string_view host = {};           ///< "127.0.0.1:8765"; may be empty
  std::string_view origin = {};  ///< of the page that asks; empty: no browser, or its own page
};

enum class Access {
  kGranted,
  kNoToken,      ///< from another machine without the token, or with a wrong one
  kForeignHost,  ///< a name of somebody else that leads to loopback (DNS rebinding)
  kForeignPage   ///< a page of somebody else in the browser of this machine
};

/// Whoever has the token may ask. From loopback no token is needed, but then no page of another
/// site may ask in the user's name; Foxglove may look (WebSocket), nothing more.
[[nodiscard]] Access access_of(const AccessRequest& request, std::string_view token);

/// The sentence for who is refused.
[[nodiscard]] std::string_view refusal_words(Access access);

/// Path of a target, without what follows '?'.
[[nodiscard]] std::string_view path_of(std::string_view target);

}  // namespace rali::view
