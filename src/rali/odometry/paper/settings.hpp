#pragma once

#include <array>

#include "rali/base/settings.hpp"

namespace rali::odometry {

enum class PaperDeskew { kRotation, kNone, kFull };
inline constexpr ChoiceNames<3> kPaperDeskewNames{"rotation", "none", "full"};

enum class PaperNormalSign { kSensor, kRaw };
inline constexpr ChoiceNames<2> kPaperNormalSignNames{"sensor", "raw"};

enum class KinematicPoint { kUnit, kRaw };
inline constexpr ChoiceNames<2> kKinematicPointNames{"unit", "raw"};

enum class KinematicScale { kMetre, kQuartile, kNone };
inline constexpr ChoiceNames<3> kKinematicScaleNames{"metre", "quartile", "none"};

enum class RotationAngle { kFull, kHalf };
inline constexpr ChoiceNames<2> kRotationAngleNames{"full", "half"};

enum class PaperBackEnd { kGraph, kObserver };
inline constexpr ChoiceNames<2> kPaperBackEndNames{"graph", "observer"};

/// Source of the pose along the degenerate direction, before ranges are used.
enum class PaperDegenerateStep {
  kPredicted,  ///< from the prediction: noise of normals must not count as information
  kRegistered  ///< from the registration, as printed
};
inline constexpr ChoiceNames<2> kPaperDegenerateStepNames{"predicted", "registered"};

enum class WeightPlace { kInside, kOutside };
inline constexpr ChoiceNames<2> kWeightPlaceNames{"inside", "outside"};

/// Settings of preset `paper`: every ambiguity of the text (algorithms.md table 0.2) and the values
/// that the text needs but does not state.
struct PaperSettings {
  bool literal = false;

  double downsample_m = 0.4;
  double theta_planar_deg = 10.0;
  PaperNormalSign normal_sign = PaperNormalSign::kSensor;
  PaperDeskew deskew = PaperDeskew::kFull;

  KinematicPoint kin_point = KinematicPoint::kUnit;
  bool kin_abs = true;
  KinematicScale kin_scale = KinematicScale::kMetre;
  RotationAngle rot_angle = RotationAngle::kFull;
  double theta_th_deg = 5.0;
  std::array<double, 3> eta{0.5, 0.2, 0.3};
  int n_neighbor = 8;
  WeightPlace weight_place = WeightPlace::kInside;
  double huber_m = 0.1;
  double map_normal_max_deg = 30.0;

  double keyframe_overlap = 0.9;
  double keyframe_s = 1.0;
  PaperDegenerateStep degenerate_step = PaperDegenerateStep::kPredicted;
  double lost_m = 1.0;
  int n_kf = 20;

  int iterations_max = 10;
  double damping = 0.01;
  PaperBackEnd back_end = PaperBackEnd::kGraph;
  double registration_fraction = 0.05;
  double velocity_gain = 0.5;
  double bias_gain = 0.01;
  int matches_min = 20;
  int keyframes_kept_max = 4000;

  template <class V>
  void visit(V& v) {
    v("literal", literal,
      "as printed: kin_point raw, kin_abs false, rot_angle half, degenerate_step registered, "
      "keyframe_s 0; of vehicle.paper_degree: l2_l3 below 3, e3_xy; of ranging.paper: range_point "
      "body, range_2d flat, range_time keyframe, factor always, share none, no max_s_m, no "
      "max_sensitivity");
    v("downsample_m", downsample_m, 0.02, 5.0, "one point per cube of this edge");
    v("theta_planar_deg", theta_planar_deg, 0.1, 90.0, "largest angle of n_G and n_O");
    v.choice("normal_sign", normal_sign, kPaperNormalSignNames,
             "sign of the normals given to the detector: to the sensor, or as the cross product");
    v.choice("deskew", deskew, kPaperDeskewNames, "undistortion of a scan by the motion within it");
    v.choice("kin_point", kin_point, kKinematicPointNames, "p in the kinematic weight");
    v("kin_abs", kin_abs, "kinematic weight does not depend on the sign of the normal");
    v.choice("kin_scale", kin_scale, kKinematicScaleNames, "factor r of the kinematic weight");
    v.choice("rot_angle", rot_angle, kRotationAngleNames, "rotation angle from the quaternion");
    v("theta_th_deg", theta_th_deg, 0.0, 180.0, "rotation per scan that starts the weight");
    v("eta", eta, 0.0, 1.0, "weights of range, neighbours, motion");
    v("n_neighbor", n_neighbor, 1, 10000, "neighbours that give the full neighbour weight");
    v.choice("weight_place", weight_place, kWeightPlaceNames, "weight inside or outside of rho");
    v("huber_m", huber_m, 1e-4, 100.0, "knee of the Huber loss");
    v("map_normal_max_deg", map_normal_max_deg, 1.0, 180.0,
      "largest angle between the normals of a feature and of a map point; 180: no limit");
    v("keyframe_overlap", keyframe_overlap, 0.0, 1.0, "less overlap makes a keyframe");
    v("keyframe_s", keyframe_s, 0.0, 600.0,
      "time between keyframes while degenerate and moving: overlap hardly falls there; 0: never");
    v.choice("degenerate_step", degenerate_step, kPaperDegenerateStepNames,
             "the pose along the degenerate direction, before ranges");
    v("lost_m", lost_m, 0.01, 1e6, "a position sigma above this is reported as lost");
    v("n_kf", n_kf, 1, 1000, "keyframes of the submap");
    v("iterations_max", iterations_max, 1, 100, "iterations of one registration");
    v("damping", damping, 1e-9, 1.0,
      "pull to the initial guess, as a fraction of the largest information");
    v.choice("back_end", back_end, kPaperBackEndNames,
             "registration and IMU joined by the local graph, or registration alone");
    v("registration_fraction", registration_fraction, 1e-4, 1.0,
      "fraction of a registration's information in the graph: matches have common errors");
    v("velocity_gain", velocity_gain, 0.0, 1.0,
      "observer: fraction of the registered velocity in the state");
    v("bias_gain", bias_gain, 0.0, 1.0,
      "observer: fraction of each scan's inertial error given to the biases");
    v("matches_min", matches_min, 6, 10000, "with fewer matches the prediction is kept");
    v("keyframes_kept_max", keyframes_kept_max, 2, 1000000, "older keyframes leave the memory");
  }

  /// The settings with `literal` replaced by the readings that it selects.
  [[nodiscard]] PaperSettings resolved() const {
    PaperSettings out = *this;
    if (!literal) return out;
    out.kin_point = KinematicPoint::kRaw;
    out.kin_abs = false;
    out.rot_angle = RotationAngle::kHalf;
    out.degenerate_step = PaperDegenerateStep::kRegistered;
    out.keyframe_s = 0.0;
    return out;
  }
};

}  // namespace rali::odometry
