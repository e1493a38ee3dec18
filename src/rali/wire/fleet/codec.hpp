#pragma once

#include <cstddef>
#include <span>

#include "rali/base/result.hpp"
#include "rali/fleet/messages/kind.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/wire/byte_writer.hpp"

/// Messages between vehicles as bytes (middleware 4.2; layout in README.md).
namespace rali::wire {

inline constexpr std::uint8_t kEnvelopeVersion = 1;
inline constexpr std::size_t kBodyMax = std::size_t{1} << 20;

/// A fact is encoded as fleet::quantised() rounds it: decode(encode(f)) == quantised(f), bit by
/// bit. encode(decode(b)) == b for the output of this function, even if a newer program wrote b.
/// Errors (kInput): those of quantised(); a body beyond kBodyMax.
[[nodiscard]] Result<Bytes> encode_envelope(const fleet::Envelope& envelope);

/// Errors: kInput for damaged (checksum), truncated or contradictory bytes; kNoAnswer for another
/// envelope version or an unknown kind that is no fact: valid, but to be dropped. A fact of an
/// unknown kind is fleet::UnreadBody. Memory is at most 50 times the bytes plus 3 MB.
[[nodiscard]] Result<fleet::Envelope> decode_envelope(std::span<const std::byte> bytes);

/// Kind of an encoded message without decoding it, for statistics.
[[nodiscard]] fleet::Kind envelope_kind(std::span<const std::byte> bytes);

}  // namespace rali::wire
