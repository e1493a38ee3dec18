#include "rali/view/internal/hub.hpp"

namespace rali::view {

void Hub::take_over() {
  std::vector<NumberedChannel> added;
  std::vector<FramePtr> frames;
  {
    const std::lock_guard lock(exchange_.mutex);
    exchange_.woken = false;
    added.swap(exchange_.new_channels);
    while (std::optional<FramePtr> frame = exchange_.inbox.pop()) frames.push_back(*frame);
  }
  for (const NumberedChannel& c : added) channels_[c.id] = {c.channel, nullptr};
  if (!added.empty()) {
    const std::string text = advertise(added);
    for (FrameSink* viewer : viewers_) viewer->send_text(text);
  }
  for (const FramePtr& frame : frames) {
    Known& known = channels_.at(frame->channel);
    if (known.channel.keep_last) known.last = frame;
    for (FrameSink* viewer : viewers_) viewer->offer(frame);
  }
}

void Hub::add(FrameSink& viewer, std::string_view session) {
  viewers_.insert(&viewer);
  std::vector<NumberedChannel> all;
  for (const auto& [id, known] : channels_) all.push_back({id, known.channel});
  viewer.send_text(server_info(session));
  if (!all.empty()) viewer.send_text(advertise(all));
  const std::lock_guard lock(exchange_.mutex);
  exchange_.published.viewers = static_cast<int>(viewers_.size());
}

void Hub::remove(FrameSink& viewer) {
  viewers_.erase(&viewer);
  const std::lock_guard lock(exchange_.mutex);
  exchange_.published.viewers = static_cast<int>(viewers_.size());
}

FramePtr Hub::last_of(std::uint32_t channel) const {
  const auto found = channels_.find(channel);
  return found == channels_.end() ? nullptr : found->second.last;
}

void Hub::count_dropped(std::size_t frames) {
  if (frames == 0) return;
  const std::lock_guard lock(exchange_.mutex);
  exchange_.published.frames_dropped += frames;
}

void Hub::close_all() {
  for (FrameSink* viewer : viewers_) viewer->close();
}

}  // namespace rali::view
