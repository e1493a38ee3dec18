#pragma once

#include <string>
#include <string_view>

namespace rali::view {

/// Properties of a request that determine its access.
struct AccessRequest {
  bool from_loopback = false;  ///< address of the peer
  bool websocket = false;
  std::string_view target = {};         ///< "/state?token=..."
  std::string_view authorization = {};  ///< "Bearer ..."
  std::string_view host = {};           ///< "127.0.0.1:8765"; may be empty
  std::string_view origin = {};  ///< of the requesting page; empty: no browser, or its own page
};

enum class Access {
  kGranted,
  kNoToken,      ///< from another machine without the token, or with a wrong one
  kForeignHost,  ///< a foreign name that resolves to loopback (DNS rebinding)
  kForeignPage   ///< a foreign page in the browser of this machine
};

/// Requests with the token are allowed. From loopback no token is needed, but then pages of other
/// sites are refused, because they would act in the user's name. Foxglove may only view
/// (WebSocket).
[[nodiscard]] Access access_of(const AccessRequest& request, std::string_view token);

/// The sentence for a refused client.
[[nodiscard]] std::string_view refusal_words(Access access);

/// Path of a target, without the part from '?' on.
[[nodiscard]] std::string_view path_of(std::string_view target);

}  // namespace rali::view
