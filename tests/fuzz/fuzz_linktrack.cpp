// Bytes of a LinkTrack radio's serial port, with any content and cut anywhere: no crash, no hang,
// and every byte is part of one frame or skipped.
#include <algorithm>
#include <cstdint>
#include <span>

#include "rali/base/assert.hpp"
#include "rali/wire/linktrack_serial.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto bytes = std::as_bytes(std::span(data, size));
  const std::size_t step = 1 + data[0];
  rali::wire::LinktrackStream stream;
  std::uint64_t frames = 0;
  for (std::size_t i = 0; i < size; i += step) {
    stream.push(bytes.subspan(i, std::min(step, size - i)));
    while (stream.next()) ++frames;
  }
  while (const auto frame = stream.next(true)) {
    ++frames;
    RALI_ASSERT(frame->nodes.size() <= 255);
  }
  RALI_ASSERT(frames == stream.tally().frames);
  RALI_ASSERT(stream.tally().bytes_skipped <= size);
  return 0;
}
