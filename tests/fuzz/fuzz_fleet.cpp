// Any bytes as a message between vehicles. What is read must be writable, and from then on the same
// bytes for ever. The checksum is put right, else nothing would come past it.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "rali/wire/fleet/codec.hpp"
#include "rali/wire/fleet/crc32c.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rali::wire;
  const auto raw = std::as_bytes(std::span(data, size));
  Bytes bytes(raw.begin(), raw.end());
  constexpr std::size_t kSumAt = 6, kSumEnd = 10;
  if (size >= kSumEnd) {
    const std::span<const std::byte> all(bytes);
    const std::uint32_t sum = crc32c(all.subspan(kSumEnd), crc32c(all.first(kSumAt)));
    for (std::size_t k = 0; k < kSumEnd - kSumAt; ++k) {
      bytes[kSumAt + k] = static_cast<std::byte>(sum >> (8 * k) & 0xFFU);
    }
  }
  const auto read = decode_envelope(bytes);
  if (!read) return 0;
  const auto once = encode_envelope(*read);
  if (!once) std::abort();
  const auto again = decode_envelope(*once);
  if (!again) std::abort();
  const auto twice = encode_envelope(*again);
  if (!twice || *twice != *once) std::abort();
  return 0;
}
