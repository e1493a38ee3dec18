#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/input/imu_check.hpp"
#include "rali/drive/input/recording_chain.hpp"
#include "rali/drive/input/stamp_repair.hpp"
#include "rali/drive/input/tf_tree.hpp"

namespace rali::drive {

/// A message kept until the decisions are made.
struct StoredMessage {
  wire::MessageKind kind = wire::MessageKind::kOther;
  std::string topic;
  std::string type;
  wire::Encoding encoding = wire::Encoding::kOther;
  Time t_record;
  std::vector<std::byte> data;
  std::uint64_t offset = 0;
  std::size_t file = 0;
};

/// The first seconds of a recording and the decisions from them.
struct RecordingProbe {
  std::deque<StoredMessage> messages;  ///< everything read so far, to be passed on again
  TopicChoice topics;
  wire::CloudFormat format;
  ImuUnits units;
  StampRule lidar_stamps = StampRule::kHeader;
  StampRule imu_stamps = StampRule::kHeader;
  Duration clock_ahead;  ///< stamps of the sensors minus those of the recorder; 0 on one clock
};

/// Ten clouds and this many seconds of messages suffice for the decisions.
inline constexpr std::size_t kProbeClouds = 10;
inline constexpr double kProbe_s = 3.0;

/// Decides from the first messages how to read the rest; writes the decisions into `report`.
/// @param topics all topics of the messages  @param where for error messages
/// Errors: kInput, as open_recording_events.
[[nodiscard]] Result<RecordingProbe> decide_probe(std::deque<StoredMessage> messages,
                                                  std::span<const TopicCount> topics,
                                                  const std::string& where,
                                                  const InputOptions& options, InputReport& report);

/// Reads until there are ten scans and three seconds of data (at most kProbeBytes) and decides how
/// to read the rest; writes the decisions into `report`.
/// Errors: kInput, as open_recording_events.
[[nodiscard]] Result<RecordingProbe> probe_recording(RecordingChain& chain,
                                                     const InputOptions& options,
                                                     InputReport& report);

inline constexpr std::size_t kProbeBytes = 256U << 20;

/// Decides T_body_lidar: settings, /tf_static, the manufacturer's value, else identity, turned
/// upright by the ground if that is clear; checks a given one against gravity. Shared with folders
/// of scans.
/// @param imu raw samples of the first seconds
[[nodiscard]] Status decide_extrinsics(const InputOptions& options, const TfTree& tf,
                                       std::span<const sensor::LidarScan> scans,
                                       std::span<const sensor::ImuSample> imu,
                                       const ImuUnits& units, InputReport& report);

}  // namespace rali::drive
