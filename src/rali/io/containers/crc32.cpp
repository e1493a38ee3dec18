#include "rali/io/containers/crc32.hpp"

#include <libdeflate.h>

namespace rali::io {

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before) {
  if (bytes.empty()) return before;  // the library treats a null pointer as a reset
  return libdeflate_crc32(before, bytes.data(), bytes.size());
}

}  // namespace rali::io
