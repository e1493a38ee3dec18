#pragma once

#include "rali/base/settings.hpp"
#include "rali/odometry/imu_noise.hpp"
#include "rali/odometry/paper/settings.hpp"
#include "rali/odometry/robust/settings.hpp"

namespace rali::odometry {

enum class Preset { kRobust, kPaper };
inline constexpr ChoiceNames<2> kPresetNames{"robust", "paper"};

struct OdometrySettings {
  Preset preset = Preset::kRobust;
  ImuNoiseSettings imu_noise;
  RobustSettings robust;
  PaperSettings paper;

  template <class V>
  void visit(V& v) {
    v.choice("preset", preset, kPresetNames, "which odometry");
    v.group("imu_noise", imu_noise, "noise of the inertial sensor");
    v.group("robust", robust, "preset robust: filter over voxel planes");
    v.group("paper", paper, "preset paper: as printed, each open point a setting");
  }
};

}  // namespace rali::odometry
