#include "rali/io/files/lzf.hpp"

#include <cstring>

namespace rali::io {

std::optional<std::size_t> lzf_decompress(std::span<const std::byte> in, std::span<std::byte> out) {
  std::size_t i = 0;
  std::size_t o = 0;
  while (i < in.size()) {
    const std::size_t start = i;
    const auto control = std::to_integer<std::size_t>(in[i++]);
    if (control < 32) {
      const std::size_t n = control + 1;
      if (n > in.size() - i || n > out.size() - o) return start;
      std::memcpy(out.data() + o, in.data() + i, n);
      i += n;
      o += n;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (i == in.size()) return start;
      length += std::to_integer<std::size_t>(in[i++]);
    }
    length += 2;
    if (i == in.size()) return start;
    const std::size_t distance = ((control & 31) << 8) + std::to_integer<std::size_t>(in[i++]) + 1;
    if (distance > o || length > out.size() - o) return start;
    // Byte by byte: source and target may overlap, which encodes runs.
    for (std::size_t k = 0; k < length; ++k, ++o) out[o] = out[o - distance];
  }
  if (o != out.size()) return in.size();
  return std::nullopt;
}

}  // namespace rali::io
