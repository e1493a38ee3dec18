#include "rali/view/internal/access.hpp"

#include <algorithm>
#include <array>

namespace rali::view {
namespace {

/// The pages of Foxglove; its desktop program has the origin "file://".
constexpr std::array<std::string_view, 3> kViewers = {"https://app.foxglove.dev",
                                                      "https://studio.foxglove.dev", "file://"};

/// Constant time for tokens of the same length, so that timing does not reveal a matching prefix.
bool equal_slowly(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differs = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    differs |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return differs == 0;
}

std::string_view bearer_of(std::string_view authorization) {
  constexpr std::string_view kScheme = "Bearer ";
  return authorization.substr(0, kScheme.size()) == kScheme ? authorization.substr(kScheme.size())
                                                            : std::string_view();
}

/// Value of `token` after the '?'. A token has no character that a browser would escape.
std::string_view token_of(std::string_view target) {
  constexpr std::string_view kName = "token=";
  std::string_view query = target.substr(std::min(path_of(target).size() + 1, target.size()));
  while (!query.empty()) {
    const std::size_t end = std::min(query.find('&'), query.size());
    const std::string_view field = query.substr(0, end);
    if (field.substr(0, kName.size()) == kName) return field.substr(kName.size());
    query.remove_prefix(std::min(end + 1, query.size()));
  }
  return {};
}

/// Whether a Host, without its port, can only mean this machine.
bool is_loopback_host(std::string_view host) {
  if (host.substr(0, 5) == "[::1]") return host.size() == 5 || host[5] == ':';
  host = host.substr(0, host.find(':'));
  if (host == "localhost") return true;
  if (host.substr(0, 4) != "127.") return false;
  return host.find_first_not_of("0123456789.") ==
         std::string_view::npos;  // "127.evil.org" is a name
}

bool is_own_page(std::string_view origin, std::string_view host) {
  constexpr std::string_view kScheme = "http://";
  return origin.empty() || (!host.empty() && origin.substr(0, kScheme.size()) == kScheme &&
                            origin.substr(kScheme.size()) == host);
}

}  // namespace

Access access_of(const AccessRequest& request, std::string_view token) {
  if (!token.empty()) {
    if (equal_slowly(bearer_of(request.authorization), token)) return Access::kGranted;
    if (equal_slowly(token_of(request.target), token)) return Access::kGranted;
  }
  if (!request.from_loopback) return Access::kNoToken;
  if (!request.host.empty() && !is_loopback_host(request.host)) return Access::kForeignHost;
  if (is_own_page(request.origin, request.host)) return Access::kGranted;
  const bool viewer = std::find(kViewers.begin(), kViewers.end(), request.origin) != kViewers.end();
  return request.websocket && viewer ? Access::kGranted : Access::kForeignPage;
}

std::string_view refusal_words(Access access) {
  switch (access) {
    case Access::kGranted:
      return "granted";
    case Access::kNoToken:
      return "This vehicle wants its token: open http://HOST:PORT/?token=TOKEN, or send the header "
             "'Authorization: Bearer TOKEN'.";
    case Access::kForeignHost:
      return "This address is answered under localhost or 127.0.0.1 only.";
    case Access::kForeignPage:
      return "A page of another site may not ask here without the token.";
  }
  return "";
}

std::string_view path_of(std::string_view target) { return target.substr(0, target.find('?')); }

}  // namespace rali::view
