#pragma once

#include <memory>

#include "rali/drive/event_source.hpp"

namespace rali::drive {

/// Reads and decodes on a thread of its own while the vehicle works. The events and their order are
/// those of `source`; at most kScans scans wait, so memory stays bounded. The destructor stops the
/// thread; `source` must outlive this object and must not be used meanwhile.
class ReadAhead final : public EventSource {
 public:
  static constexpr std::size_t kScans = 8;

  explicit ReadAhead(EventSource& source);
  ~ReadAhead() override;

  [[nodiscard]] Result<std::optional<vehicle::Event>> next() override;
  /// Of the events returned, not of those read ahead.
  [[nodiscard]] double progress() const override;

 private:
  class Queue;
  std::unique_ptr<Queue> queue_;
  double progress_ = 0.0;
};

}  // namespace rali::drive
