#include "rali/view/internal/viewer_channels.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace rali::view {

std::vector<std::string> ViewerChannels::take(std::string_view message, bool binary) {
  const auto complain = [&](const std::string& what) {
    ++bad_;
    return std::vector<std::string>{status_message(StatusLevel::kError, what)};
  };
  if (binary) return complain("Binary messages of a viewer are not read: this view is read-only.");
  const Result<ClientMessage> parsed = parse_client_message(message);
  if (!parsed) return complain(parsed.error().message() + '.');
  if (!parsed->unsupported.empty()) {
    return complain(
        fmt::format("'{}' is not supported: this view is read-only.", parsed->unsupported));
  }
  std::vector<std::string> answers;
  for (const std::uint32_t id : parsed->unsubscribe) unsubscribe(id);
  for (const Subscription& subscription : parsed->subscribe) {
    const std::string wrong = subscribe(subscription);
    if (wrong.empty()) continue;
    ++bad_;
    if (answers.empty()) answers.push_back(status_message(StatusLevel::kError, wrong));
  }
  return answers;
}

std::string ViewerChannels::subscribe(const Subscription& subscription) {
  if (!hub_.has_channel(subscription.channel)) {
    return fmt::format("There is no channel {}.", subscription.channel);
  }
  if (id_of_channel_.contains(subscription.channel)) {
    return fmt::format("Channel {} is subscribed to already.", subscription.channel);
  }
  const bool used = std::any_of(id_of_channel_.begin(), id_of_channel_.end(),
                                [&](const auto& s) { return s.second == subscription.id; });
  if (used) return fmt::format("Subscription {} exists already.", subscription.id);
  if (id_of_channel_.size() >= kSubscriptionsMax) return "Too many subscriptions.";
  id_of_channel_[subscription.channel] = subscription.id;
  if (const FramePtr last = hub_.last_of(subscription.channel)) offer(last);
  return {};
}

void ViewerChannels::unsubscribe(std::uint32_t id) {
  const auto found = std::find_if(id_of_channel_.begin(), id_of_channel_.end(),
                                  [&](const auto& s) { return s.second == id; });
  if (found == id_of_channel_.end()) return;
  frames_.erase_channel(found->first);
  id_of_channel_.erase(found);
}

void ViewerChannels::offer(const FramePtr& frame) {
  if (id_of_channel_.contains(frame->channel)) hub_.count_dropped(frames_.push(frame));
}

std::optional<ViewerChannels::Next> ViewerChannels::next() {
  std::optional<FramePtr> frame = frames_.pop();
  if (!frame) return std::nullopt;
  const DataHeader header = data_header(id_of_channel_.at((*frame)->channel), (*frame)->t);
  return Next{std::move(*frame), header};
}

}  // namespace rali::view
