#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rali/wire/messages.hpp"

namespace rali::wire {

/// Counts of a stream's content.
struct LinktrackStreamTally {
  std::uint64_t frames = 0;        ///< of ranges
  std::uint64_t other_frames = 0;  ///< of the protocol, without ranges
  std::uint64_t bad_checksums = 0;
  std::uint64_t bytes_skipped = 0;  ///< between frames
};

/// Extracts frames from the bytes of a LinkTrack radio's serial port (NLink protocol: Nodeframe2,
/// 3, 5 and Tagframe0), split anywhere. After damage it resumes at the next byte that starts a
/// frame whose length matches its own list of nodes and whose checksum matches its bytes.
class LinktrackStream {
 public:
  void push(std::span<const std::byte> bytes);

  /// The next frame of ranges; nothing until more bytes come. The stamp is zero.
  /// @param ended no more bytes will come: incomplete frames are skipped
  [[nodiscard]] std::optional<LinktrackFrame> next(bool ended = false);

  [[nodiscard]] const LinktrackStreamTally& tally() const { return tally_; }

 private:
  [[nodiscard]] std::span<const std::byte> rest() const {
    return std::span<const std::byte>(buffer_).subspan(at_);
  }

  void skip_byte();

  std::vector<std::byte> buffer_;
  std::size_t at_ = 0;  ///< bytes before this are processed
  LinktrackStreamTally tally_;
};

}  // namespace rali::wire
