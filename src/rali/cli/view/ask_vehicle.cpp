#include "rali/cli/view/ask_vehicle.hpp"

#include <cstdlib>

#include <fmt/format.h>

#include "rali/cli/session.hpp"
#include "rali/view/view_client.hpp"

namespace rali::cli {
namespace {

/// First line of the vehicle's reply, without its full stop.
std::string reason_of(const view::ViewReply& reply) {
  std::string line = printable(reply.body.substr(0, reply.body.find('\n')));
  while (!line.empty() && (line.back() == '.' || line.back() == '\r')) line.pop_back();
  return line.empty() ? fmt::format("the vehicle answers with HTTP status {}", reply.status) : line;
}

}  // namespace

Result<std::string> ask_vehicle(const std::string& url, const std::string& token,
                                const std::string& target, const std::string& body) {
  Result<view::ViewAddress> address = view::parse_view_address(url);
  if (!address) return tl::make_unexpected(address.error());
  if (!token.empty()) address->token = token;
  const char* variable = std::getenv("RALI_TOKEN");
  if (address->token.empty() && variable != nullptr) address->token = variable;
  Result<view::ViewReply> reply = view::ask_view(*address, target, body);
  if (!reply) return tl::make_unexpected(reply.error());
  if (reply->status / 100 == 2) return std::move(reply->body);
  return fail(ErrorCode::kInput, address->text(), reason_of(*reply),
              reply->status == 401 ? "Give it by --token or in the variable RALI_TOKEN." : "");
}

}  // namespace rali::cli
