#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/net/fleet_link.hpp"

namespace rali::net {

/// The newest message of one kind accepted from another vehicle. It is kept on disk to detect old
/// messages after a restart. Otherwise recorded messages of a vehicle's present epoch could be
/// replayed.
struct SeenCounter {
  VehicleId from;
  bool to_all = false;
  Urgency urgency = Urgency::kRole;
  std::uint32_t epoch = 0;
  std::uint64_t counter = 0;
  bool operator==(const SeenCounter&) const = default;
};

/// As many as fit into one slot on disk are kept, in their order.
[[nodiscard]] std::vector<std::byte> encode_seen(std::span<const SeenCounter> seen);

/// Nothing for bytes that encode_seen() did not make.
[[nodiscard]] std::optional<std::vector<SeenCounter>> decode_seen(std::span<const std::byte> bytes);

}  // namespace rali::net
