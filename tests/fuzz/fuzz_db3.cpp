// Any bytes as a rosbag2 database: the reader must terminate, within its limits, without a fault.
#include <cstddef>
#include <cstdint>
#include <span>

#include "rali/io/containers/db3_reader.hpp"
#include "rali/io/containers/rosbag2_folder.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rali::io;
  const auto bytes = std::as_bytes(std::span(data, size));
  // The same bytes as text: trying them as a damaged metadata.yaml costs nothing.
  (void)parse_rosbag2_metadata({reinterpret_cast<const char*>(data), size});
  ReadLimits limits;
  limits.chunk_bytes = 4U << 20;
  auto database = SqlDatabase::open_bytes(bytes, limits.chunk_bytes);
  if (!database) return 0;
  auto source = open_db3(std::move(*database), "fuzz", size, {}, limits);
  if (!source) return 0;
  RawMessage message;
  std::size_t sum = 0;
  while ((*source)->next(message).value_or(false)) {
    for (const std::byte b : message.data) sum += std::to_integer<std::size_t>(b);
    if (message.topic >= (*source)->topics().size()) __builtin_trap();
  }
  if ((*source)->progress() != 1.0 || sum == static_cast<std::size_t>(-1)) __builtin_trap();
  return 0;
}
