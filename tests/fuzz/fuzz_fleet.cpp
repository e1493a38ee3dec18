// Any bytes as a message between vehicles. A decoded message must be encodable, and encoding it
// again must give the same bytes. The checksum is corrected; otherwise no message would pass it.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "message_bytes.hpp"
#include "rali/wire/fleet/codec.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rali::wire;
  const Bytes bytes = rali::fuzz::with_checksum(std::as_bytes(std::span(data, size)));
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
