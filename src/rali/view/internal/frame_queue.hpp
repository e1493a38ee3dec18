#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "rali/base/time.hpp"

namespace rali::view {

/// The bytes of one message, shared by all viewers for which it is queued.
struct Frame {
  std::uint32_t channel = 0;
  Time t;
  std::vector<std::uint8_t> bytes;
};

using FramePtr = std::shared_ptr<const Frame>;

/// Frames queued for a slow receiver. Beyond `bytes_max` it drops the oldest ones whose channel has
/// a newer one; so the newest of each channel always stays, even if these alone exceed the limit.
class FrameQueue {
 public:
  explicit FrameQueue(std::size_t bytes_max) : bytes_max_(bytes_max) {}

  /// @return number of frames dropped
  std::size_t push(FramePtr frame);

  /// The oldest frame; none: the queue is empty.
  [[nodiscard]] std::optional<FramePtr> pop();

  /// Removes the queued frames of a channel.
  void erase_channel(std::uint32_t channel);

  [[nodiscard]] std::size_t bytes() const { return bytes_; }

  [[nodiscard]] std::size_t size() const { return frames_.size(); }

 private:
  std::size_t drop_superseded();

  std::size_t bytes_max_;
  std::size_t bytes_ = 0;
  std::deque<FramePtr> frames_;
  std::map<std::uint32_t, std::size_t> waiting_;  ///< frames per channel
};

}  // namespace rali::view
