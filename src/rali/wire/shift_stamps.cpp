#include "rali/wire/shift_stamps.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "rali/wire/byte_reader.hpp"
#include "rali/wire/decode.hpp"

namespace rali::wire {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;

template <class T>
void store(std::byte* at, T value, bool big_endian) {
  if (big_endian != (std::endian::native == std::endian::big)) value = byte_swapped(value);
  std::memcpy(at, &value, sizeof(T));
}

/// int32 seconds, uint32 nanoseconds.
void shift_time(std::byte* at, Duration shift, bool big_endian) {
  const auto seconds = static_cast<std::int32_t>(load<std::uint32_t>(at, big_endian));
  const auto rest = load<std::uint32_t>(at + 4, big_endian);
  const std::int64_t ns = std::int64_t{seconds} * kNsPerS + rest + shift.ns;
  std::int64_t whole = ns / kNsPerS;
  if (ns % kNsPerS < 0) --whole;
  store(at, static_cast<std::uint32_t>(static_cast<std::uint64_t>(whole)), big_endian);
  store(at + 4, static_cast<std::uint32_t>(ns - whole * kNsPerS), big_endian);
}

/// Offsets of the stamps of all transforms; empty for a truncated message.
std::vector<std::size_t> transform_stamps(ByteReader& in) {
  std::vector<std::size_t> found;
  const std::uint32_t count = in.sequence(1);
  for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
    in.align(4);
    found.push_back(in.offset());
    static_cast<void>(in.header());
    static_cast<void>(in.string());
    static_cast<void>(in.get_array<double, 7>());
  }
  if (!in.ok()) found.clear();
  return found;
}

}  // namespace

bool shift_stamps(MessageKind kind, std::string_view type_name, Duration shift,
                  std::span<std::byte> cdr) {
  ByteReader in(cdr, Encoding::kCdr);
  const bool big_endian = in.big_endian();
  if (kind == MessageKind::kTf) {
    const std::vector<std::size_t> stamps = transform_stamps(in);
    for (const std::size_t at : stamps) shift_time(cdr.data() + at, shift, big_endian);
    return !stamps.empty();
  }
  if (kind == MessageKind::kLinktrack) {
    const auto frame = decode_linktrack(type_name, cdr, Encoding::kCdr);
    if (!frame || frame->stamp.ns == 0) return false;
  } else if (!is_cloud(kind) && kind != MessageKind::kImu && kind != MessageKind::kRaliRange &&
             kind != MessageKind::kPoseStamped) {
    return false;
  }
  const std::size_t at = in.offset();
  static_cast<void>(in.header());
  if (kind == MessageKind::kLivoxCustom) {
    const auto timebase = in.get<std::uint64_t>();
    const std::size_t end = in.offset();
    if (!in.ok()) return false;
    store(cdr.data() + end - sizeof(timebase), timebase + static_cast<std::uint64_t>(shift.ns),
          big_endian);
  }
  if (!in.ok()) return false;
  shift_time(cdr.data() + at, shift, big_endian);
  return true;
}

}  // namespace rali::wire
