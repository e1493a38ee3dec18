#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rali/wire/messages.hpp"

namespace rali::wire {

/// What a stream of bytes held.
struct LinktrackStreamTally {
  std::uint64_t frames = 0;        ///< of ranges
  std::uint64_t other_frames = 0;  ///< of the protocol, without ranges that are used
  std::uint64_t bad_checksums = 0;
  std::uint64_t bytes_skipped = 0;  ///< between frames
};

/// Frames out of the bytes of a LinkTrack radio's serial port (NLink protocol: Nodeframe2, 3, 5 and
/// Tagframe0), cut anywhere. After damage it starts again at the next byte that begins a frame of a
/// length that fits its own list of nodes and a checksum that fits its bytes.
class LinktrackStream {
 public:
  void push(std::span<const std::byte> bytes);

  /// The next frame of ranges; nothing until more bytes come. The stamp is zero.
  /// @param ended no more bytes will come: what is incomplete is passed over
  [[nodiscard]] std::optional<LinktrackFrame> next(bool ended = false);

  [[nodiscard]] const LinktrackStreamTally& tally() const { return tally_; }

 private:
  [[nodiscard]] std::span<const std::byte> rest() const {
    return std::span<const std::byte>(buffer_).subspan(at_);
  }

  void skip_byte();

  std::vector<std::byte> buffer_;
  std::size_t at_ = 0;  ///< what lies before is done
  LinktrackStreamTally tally_;
};

}  // namespace rali::wire
