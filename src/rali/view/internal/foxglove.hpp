#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/view/view_server.hpp"

/// The part of the Foxglove WebSocket protocol that a read-only server needs: values to text and
/// back, without sockets. Source: specification of foxglove/ws-protocol, 2023.
namespace rali::view {

/// Both names have the same messages here; each client supports one or the other.
inline constexpr std::array<std::string_view, 2> kSubprotocols = {"foxglove.websocket.v1",
                                                                  "foxglove.sdk.v1"};

/// A client's message is a list of subscriptions; longer ones are refused.
inline constexpr std::size_t kClientMessageBytesMax = 64U << 10U;
inline constexpr std::size_t kSubscriptionsMax = 256;

/// The first supported one in the client's list ("a, b"); empty: none.
[[nodiscard]] std::string_view choose_subprotocol(std::string_view offered);

struct Subscription {
  std::uint32_t id = 0;       ///< chosen by the client
  std::uint32_t channel = 0;  ///< of ours

  auto operator<=>(const Subscription&) const = default;
};

/// Requests of a client.
struct ClientMessage {
  std::vector<Subscription> subscribe;
  std::vector<std::uint32_t> unsubscribe;
  std::string unsupported;  ///< an operation of the protocol that a read-only server does not
                            ///< support
};

/// Reads a text message of a client. Errors: kInput if it is no JSON object, lacks a field, or has
/// more than kSubscriptionsMax entries.
[[nodiscard]] Result<ClientMessage> parse_client_message(std::string_view text);

[[nodiscard]] std::string server_info(std::string_view session);

struct NumberedChannel {
  std::uint32_t id = 0;
  ViewChannel channel;
};

[[nodiscard]] std::string advertise(std::span<const NumberedChannel> channels);

enum class StatusLevel { kInfo = 0, kWarning = 1, kError = 2 };

[[nodiscard]] std::string status_message(StatusLevel level, std::string_view text);

/// Opcode 0x01, subscription (u32), time (u64, ns), all little endian; the payload follows.
using DataHeader = std::array<std::uint8_t, 13>;

[[nodiscard]] DataHeader data_header(std::uint32_t subscription, Time t);

}  // namespace rali::view
