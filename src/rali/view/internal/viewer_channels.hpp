#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rali/view/internal/foxglove.hpp"
#include "rali/view/internal/hub.hpp"

namespace rali::view {

/// A viewer is closed after more than this many invalid messages.
inline constexpr int kBadMessagesMax = 20;

/// Subscriptions and queued frames of one viewer; without sockets, so that it can be tested and
/// fuzzed directly.
class ViewerChannels {
 public:
  explicit ViewerChannels(Hub& hub) : hub_(hub), frames_(hub.queue_bytes()) {}

  /// Processes a message of the viewer. @return texts to send back
  [[nodiscard]] std::vector<std::string> take(std::string_view message, bool binary);

  /// Queues a frame if its channel is subscribed.
  void offer(const FramePtr& frame);

  struct Next {
    FramePtr frame;
    DataHeader header{};
  };

  /// The next frame to send; none: the queue is empty.
  [[nodiscard]] std::optional<Next> next();

  [[nodiscard]] bool too_many_bad() const { return bad_ > kBadMessagesMax; }

  [[nodiscard]] std::size_t subscriptions() const { return id_of_channel_.size(); }

  [[nodiscard]] const FrameQueue& waiting() const { return frames_; }

 private:
  [[nodiscard]] std::string subscribe(const Subscription& subscription);
  void unsubscribe(std::uint32_t id);

  Hub& hub_;
  FrameQueue frames_;
  std::map<std::uint32_t, std::uint32_t> id_of_channel_;
  int bad_ = 0;
};

}  // namespace rali::view
