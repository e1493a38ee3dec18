#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/drive/input/stamp_repair.hpp"
#include "rali/drive/offset/lidar_turning.hpp"
#include "rali/inspect/cloud_study.hpp"
#include "rali/inspect/doctor.hpp"

namespace rali::inspect {

/// Collects statistics of a recording and evaluates them at the end. Memory is bounded: stamps and
/// inertial samples of the examined seconds are kept, clouds are not (except the first few until
/// their format is decided).
class Examination {
 public:
  Examination(const DoctorOptions& options, Executor& executor);

  /// One cloud of the LiDAR's topic; `message` owns the data of the view.
  void add_cloud(std::vector<std::byte> message, wire::CloudView view, Time t_record);
  void add_undecodable(const std::string& topic, const std::string& reason);
  void add_imu(const sensor::ImuSample& raw, Time t_record);

  [[nodiscard]] std::size_t clouds() const { return cloud_stamps_.size(); }

  /// Usable points of all examined scans.
  [[nodiscard]] double points() const {
    return clouds_.points_per_scan() * static_cast<double>(clouds_.scans());
  }

  /// Evaluates everything; fills the report except the caller's fields (path, topics, file damage).
  void finish(DoctorReport& report);

 private:
  struct Waiting {
    std::vector<std::byte> message;
    wire::CloudView view;
  };

  void decide_format();
  void decode(const wire::CloudView& view);
  void track(const sensor::LidarScan& scan);
  void judge_rates(const DoctorReport& report, FindingList& out) const;
  void judge_rotations(DoctorReport& report, FindingList& out);

  DoctorOptions options_;
  Executor& executor_;
  std::vector<Waiting> waiting_;
  std::optional<wire::CloudFormat> format_;
  std::string format_error_, format_remedy_;
  std::uint64_t undecodable_ = 0;
  std::string undecodable_topic_, undecodable_reason_;
  sensor::LidarScan scan_;
  std::vector<drive::StampPair> cloud_stamps_, imu_stamps_;
  std::vector<sensor::ImuSample> imu_;
  drive::LidarTurning turning_;
  std::optional<geometry::Vec3> up_lidar_;
  CloudStudy clouds_;
};

}  // namespace rali::inspect
