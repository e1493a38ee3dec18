#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rali/drive/input/event_outlet.hpp"
#include "rali/drive/input/imu_intake.hpp"
#include "rali/drive/input/recording_probe.hpp"
#include "rali/drive/ranges/range_topics.hpp"

namespace rali::drive {

/// Converts the messages of one vehicle's sensors to events with usable stamps and SI units, by the
/// decisions made on the first messages. Shared by recordings and live sensors.
class MessageReader {
 public:
  /// Names a message in findings: "file:offset 17", or empty.
  using PlaceOf = std::function<std::string(const RecordedMessage&)>;

  /// @param probe its messages are not used
  MessageReader(const RecordingProbe& probe, const InputOptions& options, PlaceOf place);

  /// Puts the contents of the message into `sink`. Damage is noted in `report`.
  void take(const RecordedMessage& message, EventSink& sink, InputReport& report);

  /// The first stamps of a new file need not follow the last ones smoothly; see StampRepair.
  void start_file(bool clock_was_set);

 private:
  void take_cloud(const RecordedMessage& message, EventSink& sink, InputReport& report);
  void take_imu(const RecordedMessage& message, EventSink& sink, InputReport& report);
  void take_ranges(const RecordedMessage& message, EventSink& sink, InputReport& report);
  [[nodiscard]] std::optional<Time> repair(StampRepair& repair, StampPair stamps,
                                           const RecordedMessage& message, InputReport& report);
  void damaged(const RecordedMessage& message, const Error& error, InputReport& report) const;

  TopicChoice topics_;
  wire::CloudFormat format_;
  InputOptions options_;
  Duration clock_offset_;
  PlaceOf place_;
  std::shared_ptr<ClockShifts> shifts_ = std::make_shared<ClockShifts>();
  StampRepair lidar_stamps_, imu_stamps_;
  ImuIntake intake_;
  RangeTopics range_topics_;
  std::vector<sensor::RangeSample> ranges_;  ///< of one message
};

}  // namespace rali::drive
