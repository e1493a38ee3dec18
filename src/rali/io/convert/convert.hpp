#pragma once

#include <functional>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"

namespace rali::io {

/// Result of a conversion.
struct Conversion {
  std::string done;               ///< "1204 messages of 5 topics"
  std::vector<std::string> lost;  ///< content that the target cannot hold, one sentence each
  FindingList findings;           ///< damage of the input
  bool gaps = false;              ///< part of the input is missing in the target
};

struct ConvertOptions {
  std::string to;     ///< kind of the target as in kConvertTargets; empty: by the extension of OUT
  std::string times;  ///< file of stamps, one a line, for trajectories without stamps (KITTI)
  /// Called with the fraction of a recording read so far; false stops the conversion.
  std::function<bool(double)> go_on = [](double) { return true; };
};

/// Kinds of targets: recording, clouds, trajectories.
[[nodiscard]] const std::vector<std::string>& convert_targets();

/// Writes `in` as `out`, whole or not at all. The content of `in` and the extension of `out`
/// determine their kinds. Recordings are streamed; clouds and trajectories are read whole.
/// Errors: kUsage (unknown target), kInput, kMachine, kInterrupted.
[[nodiscard]] Result<Conversion> convert(const std::string& in, const std::string& out,
                                         const ConvertOptions& options = {});

/// A recording to MCAP. Livox CustomMsg becomes PointCloud2, all else keeps its bytes.
[[nodiscard]] Result<Conversion> convert_recording(const std::string& in, const std::string& out,
                                                   const ConvertOptions& options);

/// A cloud to pcd, ply, las or bin.
[[nodiscard]] Result<Conversion> convert_cloud(const std::string& in, const std::string& out,
                                               const std::string& to);

/// A trajectory to tum, kitti, euroc or csv.
[[nodiscard]] Result<Conversion> convert_trajectory(const std::string& in, const std::string& out,
                                                    const std::string& to,
                                                    const std::string& times);

}  // namespace rali::io
