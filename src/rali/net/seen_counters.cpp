#include "rali/net/seen_counters.hpp"

#include <algorithm>

namespace rali::net {
namespace {

constexpr std::uint8_t kVersion = 1;
/// vehicle u16, to all u8, urgency u8, epoch u32, counter u64, little endian.
constexpr std::size_t kRowBytes = 16;
constexpr std::size_t kRowsMax = 254;  ///< 4 KiB minus the heads of slot and list

void put(std::vector<std::byte>& out, std::uint64_t value, std::size_t bytes) {
  for (std::size_t k = 0; k < bytes; ++k) {
    out.push_back(static_cast<std::byte>(value >> (8 * k) & 0xFFU));
  }
}

std::uint64_t get(std::span<const std::byte> bytes) {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    value |= std::to_integer<std::uint64_t>(bytes[k]) << (8 * k);
  }
  return value;
}

}  // namespace

std::vector<SeenCounter> FleetLink::seen() const { return {}; }

std::vector<std::byte> encode_seen(std::span<const SeenCounter> seen) {
  std::vector<std::byte> out;
  put(out, kVersion, 1);
  for (const SeenCounter& one : seen.first(std::min(seen.size(), kRowsMax))) {
    put(out, one.from.value, 2);
    put(out, one.to_all ? 1 : 0, 1);
    put(out, static_cast<std::uint64_t>(one.urgency), 1);
    put(out, one.epoch, 4);
    put(out, one.counter, 8);
  }
  return out;
}

std::optional<std::vector<SeenCounter>> decode_seen(std::span<const std::byte> bytes) {
  if (bytes.empty() || std::to_integer<std::uint8_t>(bytes[0]) != kVersion) return std::nullopt;
  bytes = bytes.subspan(1);
  if (bytes.size() % kRowBytes != 0) return std::nullopt;
  std::vector<SeenCounter> seen;
  for (; !bytes.empty(); bytes = bytes.subspan(kRowBytes)) {
    SeenCounter one;
    one.from.value = static_cast<std::uint16_t>(get(bytes.first(2)));
    one.to_all = get(bytes.subspan(2, 1)) != 0;
    const std::uint64_t urgency = get(bytes.subspan(3, 1));
    if (urgency > static_cast<std::uint64_t>(Urgency::kBulk)) return std::nullopt;
    one.urgency = static_cast<Urgency>(urgency);
    one.epoch = static_cast<std::uint32_t>(get(bytes.subspan(4, 4)));
    one.counter = get(bytes.subspan(8, 8));
    seen.push_back(one);
  }
  return seen;
}

}  // namespace rali::net
