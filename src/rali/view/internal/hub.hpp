#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "rali/view/internal/answers.hpp"
#include "rali/view/internal/foxglove.hpp"
#include "rali/view/internal/frame_queue.hpp"

namespace rali::view {

/// Limits on connections; more are refused.
inline constexpr int kConnectionsMax = 256;
inline constexpr std::size_t kViewersMax = 64;

/// A connected viewer as the hub uses it.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  virtual void offer(const FramePtr& frame) = 0;
  virtual void send_text(std::string text) = 0;
  virtual void close() = 0;
};

/// Data passed from the host's thread to the server's thread. Both hold `mutex` only briefly.
struct Exchange {
  explicit Exchange(std::size_t queue_bytes) : inbox(queue_bytes) {}

  std::mutex mutex;
  Published published;
  FrameQueue inbox;  ///< bounded like the viewers' queues: the server's thread may get no CPU
  std::vector<NumberedChannel> new_channels;
  bool woken = false;  ///< the server's thread has been asked to check for input
};

/// Channels, their last frames and subscribed viewers. Used by the server's thread alone.
class Hub {
 public:
  Hub(Exchange& exchange, std::string token, std::size_t queue_bytes)
      : exchange_(exchange), token_(std::move(token)), queue_bytes_(queue_bytes) {}

  /// Takes the data from the host's thread and offers it to the viewers.
  void take_over();

  /// False: the maximum number of viewers is reached.
  [[nodiscard]] bool has_room() const { return viewers_.size() < kViewersMax; }

  /// Adds a viewer and sends it the channels.
  void add(FrameSink& viewer, std::string_view session);
  void remove(FrameSink& viewer);

  [[nodiscard]] bool has_channel(std::uint32_t id) const { return channels_.contains(id); }

  /// The last frame of a channel with keep_last; nullptr: none.
  [[nodiscard]] FramePtr last_of(std::uint32_t channel) const;

  void count_dropped(std::size_t frames);
  void close_all();

  [[nodiscard]] Exchange& exchange() { return exchange_; }

  [[nodiscard]] const std::string& token() const { return token_; }

  [[nodiscard]] std::size_t queue_bytes() const { return queue_bytes_; }

  int connections = 0;  ///< HTTP and viewers

 private:
  struct Known {
    ViewChannel channel;
    FramePtr last;
  };

  Exchange& exchange_;
  std::string token_;
  std::size_t queue_bytes_;
  std::map<std::uint32_t, Known> channels_;
  std::set<FrameSink*> viewers_;
};

}  // namespace rali::view
