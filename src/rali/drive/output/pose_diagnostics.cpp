#include "rali/drive/output/pose_diagnostics.hpp"

#include <cmath>

#include <fmt/format.h>

namespace rali::drive {

wire::DiagnosticStatus degeneracy_status(const std::string& vehicle, const PoseRecord& pose) {
  wire::DiagnosticStatus status;
  status.level = pose.degenerate ? wire::DiagnosticStatus::kWarn : wire::DiagnosticStatus::kOk;
  status.name = vehicle + "/degeneracy";
  status.message =
      pose.degenerate ? "degenerate along one direction" : "all directions are observed";
  status.hardware_id = vehicle;
  if (pose.degree) status.values.emplace_back("degree", fmt::format("{:.6f}", *pose.degree));
  if (std::isfinite(pose.sigma_degenerate_m)) {
    status.values.emplace_back("sigma_degenerate_m",
                               fmt::format("{:.6f}", pose.sigma_degenerate_m));
  }
  for (int axis = 0; axis < 3; ++axis) {
    const char* names[] = {"dir_odom_x", "dir_odom_y", "dir_odom_z"};
    status.values.emplace_back(names[axis], fmt::format("{:.6f}", pose.degenerate_odom[axis]));
  }
  return status;
}

wire::DiagnosticStatus pose_status(const std::string& vehicle, const PoseRecord& pose) {
  using vehicle::PoseQuality;
  wire::DiagnosticStatus status;
  status.name = vehicle + "/odometry";
  status.hardware_id = vehicle;
  switch (pose.quality) {
    case PoseQuality::kGood:
      status.level = wire::DiagnosticStatus::kOk;
      status.message = "scan registered";
      break;
    case PoseQuality::kWeak:
      status.level = wire::DiagnosticStatus::kWarn;
      status.message = "scan registered by few points";
      break;
    case PoseQuality::kPredicted:
      status.level = wire::DiagnosticStatus::kWarn;
      status.message = "scan not registered: pose predicted";
      break;
    case PoseQuality::kDiverged:
      status.level = wire::DiagnosticStatus::kError;
      status.message = "diverged: pose not used";
      break;
  }
  status.values.emplace_back("sigma_m", fmt::format("{:.6f}", position_sigma_m(pose)));
  status.values.emplace_back("correction_by_ranges_m", fmt::format("{:.6f}", pose.correction_m));
  return status;
}

}  // namespace rali::drive
