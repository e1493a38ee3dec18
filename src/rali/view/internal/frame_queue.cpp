#include "rali/view/internal/frame_queue.hpp"

namespace rali::view {

std::size_t FrameQueue::push(FramePtr frame) {
  bytes_ += frame->bytes.size();
  ++waiting_[frame->channel];
  frames_.push_back(std::move(frame));
  return bytes_ > bytes_max_ ? drop_superseded() : 0;
}

std::size_t FrameQueue::drop_superseded() {
  std::deque<FramePtr> kept;
  std::size_t dropped = 0;
  for (FramePtr& frame : frames_) {
    std::size_t& of_channel = waiting_[frame->channel];
    if (bytes_ > bytes_max_ && of_channel > 1) {
      --of_channel;
      bytes_ -= frame->bytes.size();
      ++dropped;
    } else {
      kept.push_back(std::move(frame));
    }
  }
  frames_ = std::move(kept);
  return dropped;
}

std::optional<FramePtr> FrameQueue::pop() {
  if (frames_.empty()) return std::nullopt;
  FramePtr frame = std::move(frames_.front());
  frames_.pop_front();
  bytes_ -= frame->bytes.size();
  if (--waiting_[frame->channel] == 0) waiting_.erase(frame->channel);
  return frame;
}

void FrameQueue::erase_channel(std::uint32_t channel) {
  std::erase_if(frames_, [&](const FramePtr& frame) {
    if (frame->channel != channel) return false;
    bytes_ -= frame->bytes.size();
    return true;
  });
  waiting_.erase(channel);
}

}  // namespace rali::view
