#pragma once

#include <cstdint>

#include "rali/base/result.hpp"
#include "rali/fleet/facts/facts.hpp"

namespace rali::fleet {

/// The fact as all others receive it, quantised to its wire resolution (rounding.hpp). The author
/// must use this one as well, or its map differs from theirs. quantised(quantised(f)) ==
/// quantised(f), bit by bit.
///
/// Positions are kept as doubles, rotations within 1e-9 rad, points within 5 mm per axis and
/// reordered, ranges within 0.05 mm, covariances to 1e-7, information to 1e-11.
///
/// Errors (kInput): a value that is not a number or out of all bounds, lists of unequal length or
/// beyond kPointsMax, kRangesMax, kAntennasMax, a name beyond kNameMax.
[[nodiscard]] Result<Fact> quantised(const Fact& fact);

inline constexpr std::size_t kPointsMax = 200000;
inline constexpr std::size_t kRangesMax = 20000;
inline constexpr std::size_t kAntennasMax = 16;
inline constexpr std::size_t kNameMax = 64;

/// Distinguishes different contents under one key: a hash of all values, the key included.
[[nodiscard]] std::uint64_t content_hash(const Fact& fact);

/// Approximate size of a fact in a message in bytes (within a factor of two): for queues and
/// credit.
[[nodiscard]] std::size_t bytes_about(const Fact& fact);

/// "vehicle 2, epoch 1, number 17".
[[nodiscard]] std::string text_of(const FactKey& key);

}  // namespace rali::fleet
