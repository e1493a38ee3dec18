// Any bytes as a ROS 1 bag: the reader must terminate, within its limits, without a fault.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rali/io/containers/bag_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rali::io;
  const auto bytes = std::as_bytes(std::span(data, size));
  ReadLimits limits;
  limits.chunk_bytes = 4U << 20;
  limits.definition_bytes = 1U << 20;
  auto source =
      open_bag(memory_bytes(std::vector<std::byte>(bytes.begin(), bytes.end()), "fuzz"), limits);
  if (!source) return 0;
  RawMessage message;
  std::size_t sum = 0;
  while ((*source)->next(message).value_or(false)) {
    // Reads the bytes, so that a dangling span is detected.
    for (const std::byte b : message.data) sum += std::to_integer<std::size_t>(b);
    if (message.topic >= (*source)->topics().size()) __builtin_trap();
  }
  if ((*source)->progress() != 1.0 || sum == static_cast<std::size_t>(-1)) __builtin_trap();
  return 0;
}
