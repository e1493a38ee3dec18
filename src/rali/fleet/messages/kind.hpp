#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "rali/fleet/messages/messages.hpp"

namespace rali::fleet {

/// Kinds of messages; the numbers are those on the wire. Below 16 are facts: one of an unknown kind
/// is stored and forwarded.
enum class Kind : std::uint8_t {
  kCoarsePoints = 1,
  kFinePoints = 2,
  kIncrement = 3,
  kRanges = 4,
  kLoop = 6,
  kEpochStart = 7,
  kInventory = 16,
  kRequest = 17,
  kTable = 18,
  kRole = 19,
  kStatus = 20,
  kGoals = 21,
  kWithheld = 22,
  kSeparator = 23,
  kPeer = 24
};

inline constexpr std::uint8_t kFactKinds = 16;     ///< a kind below is a fact
inline constexpr std::uint8_t kMessageKinds = 32;  ///< all kinds are below

[[nodiscard]] Kind kind_of(const Fact& fact);
[[nodiscard]] Kind kind_of(const Message& message);

/// "points", "increment"; "kind" for an unknown one.
[[nodiscard]] std::string_view name_of(Kind kind);

/// Number of messages and bytes of each kind.
struct TrafficCount {
  struct Row {
    std::uint64_t messages = 0, bytes = 0;
    bool operator==(const Row&) const = default;
  };

  std::array<Row, kMessageKinds> of_kind{};

  void add(Kind kind, std::size_t bytes);
  void add(const TrafficCount& other);

  [[nodiscard]] const Row& operator[](Kind kind) const {
    return of_kind[static_cast<std::size_t>(kind) % kMessageKinds];
  }

  [[nodiscard]] Row total() const;

  bool operator==(const TrafficCount&) const = default;
};

}  // namespace rali::fleet
