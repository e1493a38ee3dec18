#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rali/cloud/voxel_sampler.hpp"
#include "rali/vehicle/event.hpp"
#include "rali/vehicle/path_recorder.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// Numbers the permanent facts that a vehicle sends to the others.
class FactWriter {
 public:
  FactWriter(VehicleId self, const VehicleSettings& settings);

  /// Call after each scan. @param ranges the sane ones since the last scan, by time
  void add(Time t, const std::optional<PathNode>& node, const odometry::Keyframe* keyframe,
           const std::vector<fleet::RangeEntry>& ranges, OutputList& out);

  /// Writes what is still queued at the end of the data.
  void flush(OutputList& out);

 private:
  void write(Time t, fleet::FactBody body, OutputList& out);
  void write_ranges(OutputList& out);
  [[nodiscard]] fleet::KeyframePoints points_of(std::uint32_t number,
                                                const odometry::Keyframe& keyframe);

  VehicleId self_;
  FactSettings settings_;
  fleet::EpochStart start_;
  fleet::RangeBlock ranges_;
  cloud::VoxelSampler sampler_;
  std::uint32_t next_ = 0;
};

}  // namespace rali::vehicle
