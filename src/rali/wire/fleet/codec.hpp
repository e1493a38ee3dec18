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

/// A fact goes out as fleet::told() rounds it: decode(encode(f)) == told(f), bit by bit, and
/// encode(decode(b)) == b for what this function made, also if a newer program wrote b.
/// Errors (kInput): those of told(); a body beyond kBodyMax.
[[nodiscard]] Result<Bytes> encode_envelope(const fleet::Envelope& envelope);

/// Errors: kInput for damaged (checksum), cut or contradictory bytes; kNoAnswer for another
/// envelope version or a kind that is no fact and unknown: nothing is wrong with it, drop it.
/// A fact of an unknown kind is fleet::UnreadBody. Never takes more memory than 50 times the bytes
/// and 3 MB explain.
[[nodiscard]] Result<fleet::Envelope> decode_envelope(std::span<const std::byte> bytes);

/// Kind of an encoded message without decoding it, for counting.
[[nodiscard]] fleet::Kind envelope_kind(std::span<const std::byte> bytes);

}  // namespace rali::wire
