#include "rali/io/containers/damage_search.hpp"

#include <algorithm>
#include <cstring>

namespace rali::io {
namespace {

bool all_zero(std::span<const std::byte> bytes) {
  return bytes.empty() || (bytes.front() == std::byte{0} &&
                           std::memcmp(bytes.data(), bytes.data() + 1, bytes.size() - 1) == 0);
}

}  // namespace

Result<std::optional<DamageSearch::Block>> DamageSearch::next(ByteSource& source,
                                                              ByteWindow& window,
                                                              std::uint64_t from) {
  while (true) {
    from = source.next_data(from);
    if (from >= source.size()) return std::nullopt;
    if (bytes_left_ == 0) {
      gave_up_ = true;
      return std::nullopt;
    }
    const auto bytes = window.view(from, kBlockBytes);
    if (!bytes) return tl::make_unexpected(bytes.error());
    bytes_left_ -= std::min<std::uint64_t>(bytes_left_, bytes->size());
    if (!all_zero(*bytes)) return Block{from, *bytes};
    from += bytes->size();
  }
}

Result<std::optional<std::uint64_t>> end_of_zeros(ByteSource& source, ByteWindow& window,
                                                  std::uint64_t from, std::uint64_t bytes_max) {
  DamageSearch search(bytes_max);
  const auto block = search.next(source, window, from);
  if (!block) return tl::make_unexpected(block.error());
  if (search.gave_up()) return std::nullopt;
  if (!*block) return source.size();
  const auto& bytes = (*block)->bytes;
  const auto found =
      std::find_if(bytes.begin(), bytes.end(), [](std::byte b) { return b != std::byte{0}; });
  return (*block)->offset + static_cast<std::uint64_t>(found - bytes.begin());
}

}  // namespace rali::io
