#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/input/recording_chain.hpp"
#include "rali/drive/ranges/radio_stamps.hpp"
#include "rali/drive/ranges/range_options.hpp"
#include "rali/sensor/range_sample.hpp"
#include "rali/wire/messages.hpp"

namespace rali::drive {

/// Extracts ranges from the messages of one vehicle's recordings: LinkTrack frames and
/// rali_msgs/Range. An end that belongs to no vehicle becomes a stranger; limits are not applied
/// here.
class RangeTopics {
 public:
  /// @param self owner of the recordings: a radio in no list is its first antenna
  /// @param clock_ahead stamps of the sensors minus those of the recorder, added to stamps by the
  /// recorder or by arrival
  RangeTopics(std::shared_ptr<const RangeOptions> options, VehicleId self, Duration clock_ahead)
      : options_(std::move(options)), self_(self), clock_ahead_(clock_ahead) {}

  /// True for messages of topics that a source of the fleet names.
  [[nodiscard]] bool wants(const RecordedMessage& message) const;

  /// Appends the ranges of one message, in its order. Errors: kInput (undecodable).
  [[nodiscard]] Status take(const RecordedMessage& message, std::vector<sensor::RangeSample>& out);

 private:
  [[nodiscard]] Time stamp_of(Time header, const wire::LinktrackFrame& frame,
                              const RecordedMessage& message);
  void take_linktrack(const RangeTopic& source, const wire::LinktrackFrame& frame,
                      const RecordedMessage& message, std::vector<sensor::RangeSample>& out);
  void take_range(const wire::RangeMessage& range, const RecordedMessage& message,
                  std::vector<sensor::RangeSample>& out) const;

  std::shared_ptr<const RangeOptions> options_;
  VehicleId self_;
  Duration clock_ahead_;
  std::map<std::string, RadioStamps, std::less<>> stamps_;  ///< one clock per topic
};

}  // namespace rali::drive
