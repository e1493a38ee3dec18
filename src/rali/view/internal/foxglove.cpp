#include "rali/view/internal/foxglove.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace rali::view {
namespace {

using nlohmann::json;

/// Channel names come from settings: bytes that are not UTF-8 are replaced instead of throwing.
std::string text_of(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string_view trimmed(std::string_view word) {
  const auto first = word.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return word.substr(first, word.find_last_not_of(" \t") - first + 1);
}

tl::unexpected<Error> bad(std::string what) {
  return fail(ErrorCode::kInput, "message of a viewer", std::move(what));
}

bool is_number(const json& value) {
  return value.is_number_unsigned() &&
         value.get<std::uint64_t>() <= std::numeric_limits<std::uint32_t>::max();
}

/// The list behind `key`. Errors: kInput.
Result<const json*> list_of(const json& message, const char* key) {
  const auto found = message.find(key);
  if (found == message.end() || !found->is_array()) {
    return bad(fmt::format("'{}' is missing or no list", key));
  }
  if (found->size() > kSubscriptionsMax) {
    return bad(fmt::format("'{}' has more than {} entries", key, kSubscriptionsMax));
  }
  return &*found;
}

Result<ClientMessage> subscriptions(const json& message) {
  const Result<const json*> list = list_of(message, "subscriptions");
  if (!list) return tl::make_unexpected(list.error());
  ClientMessage out;
  for (const json& entry : **list) {
    if (!entry.is_object() || !entry.contains("id") || !entry.contains("channelId") ||
        !is_number(entry["id"]) || !is_number(entry["channelId"])) {
      return bad("a subscription needs the numbers 'id' and 'channelId'");
    }
    out.subscribe.push_back(
        {entry["id"].get<std::uint32_t>(), entry["channelId"].get<std::uint32_t>()});
  }
  return out;
}

Result<ClientMessage> ended_subscriptions(const json& message) {
  const Result<const json*> list = list_of(message, "subscriptionIds");
  if (!list) return tl::make_unexpected(list.error());
  ClientMessage out;
  for (const json& id : **list) {
    if (!is_number(id)) return bad("'subscriptionIds' holds something that is no number");
    out.unsubscribe.push_back(id.get<std::uint32_t>());
  }
  return out;
}

template <std::size_t N>
void put_little_endian(std::uint8_t* at, std::uint64_t value) {
  for (std::size_t i = 0; i < N; ++i) at[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

}  // namespace

std::string_view choose_subprotocol(std::string_view offered) {
  while (!offered.empty()) {
    const std::size_t comma = std::min(offered.find(','), offered.size());
    const std::string_view word = trimmed(offered.substr(0, comma));
    const auto* ours = std::find(kSubprotocols.begin(), kSubprotocols.end(), word);
    if (ours != kSubprotocols.end()) return *ours;
    offered.remove_prefix(std::min(comma + 1, offered.size()));
  }
  return {};
}

Result<ClientMessage> parse_client_message(std::string_view text) {
  if (text.size() > kClientMessageBytesMax) return bad("it is longer than 64 KiB");
  const json message = json::parse(text, nullptr, false);
  if (!message.is_object()) return bad("it is no JSON object");
  const auto op = message.find("op");
  if (op == message.end() || !op->is_string()) return bad("'op' is missing");
  const auto& name = op->get_ref<const std::string&>();
  if (name == "subscribe") return subscriptions(message);
  if (name == "unsubscribe") return ended_subscriptions(message);
  ClientMessage out;
  out.unsupported = name.substr(0, 40);
  return out;
}

std::string server_info(std::string_view session) {
  return text_of({{"op", "serverInfo"},
                  {"name", "RaLI"},
                  {"capabilities", json::array()},
                  {"supportedEncodings", json::array()},
                  {"metadata", json::object()},
                  {"sessionId", session}});
}

std::string advertise(std::span<const NumberedChannel> channels) {
  json list = json::array();
  for (const NumberedChannel& c : channels) {
    list.push_back({{"id", c.id},
                    {"topic", c.channel.topic},
                    {"encoding", c.channel.encoding},
                    {"schemaName", c.channel.schema_name},
                    {"schemaEncoding", c.channel.schema_encoding},
                    {"schema", c.channel.schema}});
  }
  return text_of({{"op", "advertise"}, {"channels", std::move(list)}});
}

std::string status_message(StatusLevel level, std::string_view text) {
  return text_of({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", text}});
}

DataHeader data_header(std::uint32_t subscription, Time t) {
  DataHeader header{};
  header[0] = 0x01;
  put_little_endian<4>(&header[1], subscription);
  put_little_endian<8>(&header[5], static_cast<std::uint64_t>(t.ns));
  return header;
}

}  // namespace rali::view
