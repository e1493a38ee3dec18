#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>

#include "rali/base/settings.hpp"

namespace rali::fleet {

/// When a frame is accepted.
enum class CommitRule {
  kCertain,  ///< when no rival is left (algorithms_fleet 7.4)
  kAtSize    ///< when the local map has so many keyframes (paper, "Dynamical Initialization")
};
inline constexpr ChoiceNames<2> kCommitRuleNames = {"certain", "at_size"};

/// How the alignment of a scan with a map is weighted.
enum class ScanWeight {
  kRegistration,  ///< by the covariance of the registration
  kFixed          ///< by a given sigma per point, as the paper seems to do
};
inline constexpr ChoiceNames<2> kScanWeightNames = {"registration", "fixed"};

/// A start pose that the user gives.
struct PriorSettings {
  double xyz_m = 0.5;
  double yaw_deg = 5.0;
  double wrong_chi2 = 30.0;
  /// Number of path segments that contradict a prior, if none fits. In each both vehicles should
  /// observe the same, but one has solid surfaces where rays of the other passed.
  int contradicted_by = 3;

  template <class V>
  void visit(V& v) {
    v("xyz_m", xyz_m, 1e-3, 1e3, "sigma of a given start place, each axis");
    v("yaw_deg", yaw_deg, 1e-2, 180.0, "sigma of a given start heading");
    v("wrong_chi2", wrong_chi2, 0.0, 1e6,
      "largest chi2 of a prior that contradicts everything else");
    v("contradicted_by", contradicted_by, 0, 1000,
      "comparisons of scans that must contradict a prior, if none fits; 0: none ever does");
  }
};

struct ScanToMapSettings {
  ScanWeight weight = ScanWeight::kRegistration;
  double sigma_m = 0.05;
  double wrong_chi2 = 16.0;

  template <class V>
  void visit(V& v) {
    v.choice("weight", weight, kScanWeightNames, "weight of an alignment of scans");
    v("sigma_m", sigma_m, 1e-3, 10.0, "sigma of a point, where weight is fixed");
    v("wrong_chi2", wrong_chi2, 0.0, 1e6,
      "largest chi2 of an alignment that contradicts everything else");
  }
};

/// Which ranges are independent of each other (7.3).
struct TrackSettings {
  double spacing_m = 0.5;
  double still_m = 0.05;
  int samples_max = 160;

  template <class V>
  void visit(V& v) {
    v("spacing_m", spacing_m, 0.0, 100.0,
      "distance travelled by both ends between ranges that are used");
    v("standstill_m", still_m, 0.0, 1.0,
      "motion below which an end is at standstill: its ranges count as one");
    v("samples_max", samples_max, 8, 2000,
      "ranges kept per pair, those that change the direction most");
  }
};

/// Error model of odometry along the path.
struct DriftSettings {
  double scale = 0.005;
  double yaw_deg_per_sqrt_m = 0.05;
  double tilt_deg = 0.5;
  int segments = 6;

  template <class V>
  void visit(V& v) {
    v("scale", scale, 0.0, 0.5, "sigma of the scale of a path");
    v("yaw_deg_per_sqrt_m", yaw_deg_per_sqrt_m, 0.0, 10.0, "random walk of the heading");
    v("tilt_deg", tilt_deg, 0.0, 45.0, "sigma of roll and pitch of an odom frame; large: 6 dof");
    v("segments", segments, 1, 32, "segments of a path, each with its own error of heading");
  }
};

struct SearchSettings {
  double yaw_step_deg = 15.0;
  int iterations = 40;
  int samples_max = 64;
  double huber = 2.5;
  double merge_m = 0.5;
  double merge_deg = 6.0;
  int starts_max = 48;
  int hypotheses_max = 8;
  double stand_m = 0.1;

  template <class V>
  void visit(V& v) {
    v("yaw_step_deg", yaw_step_deg, 1.0, 90.0, "step of the first grid of headings");
    v("iterations", iterations, 1, 1000, "of each refinement, at most");
    v("samples_max", samples_max, 8, 1000, "ranges of which the search makes use");
    v("huber", huber, 0.5, 100.0, "knee of the loss of a range, in sigma");
    v("merge_m", merge_m, 0.0, 100.0, "hypotheses nearer than this ...");
    v("merge_deg", merge_deg, 0.0, 180.0, "... and this are one");
    v("starts_max", starts_max, 8, 10000,
      "refined with all errors of paths; more are sifted first");
    v("hypotheses_max", hypotheses_max, 2, 64, "kept");
    v("standstill_m", stand_m, 0.0, 10.0,
      "extent of a path below which a vehicle is at standstill");
  }
};

/// Whether two poses at this distance and angle are one hypothesis; within this fraction of the
/// merge limits. @param turn_rad wrapped
[[nodiscard]] inline bool one_place(double apart_m, double turn_rad, const SearchSettings& settings,
                                    double fraction = 1.0) {
  return apart_m < fraction * settings.merge_m &&
         std::abs(turn_rad) < fraction * settings.merge_deg * std::numbers::pi / 180.0;
}

struct CommitSettings {
  CommitRule rule = CommitRule::kCertain;
  int min_keyframes = 0;
  int min_ranges = 5;
  double gap_chi2 = 13.8;
  int evaluations = 3;
  double spacing_s = 2.0;
  int new_ranges = 5;
  double fit_min = 0.0;
  double fit_max = 2.0;
  double information_min = 0.25;
  double yaw_unit_deg = 1.0;
  double place_unit_m = 0.1;
  int views_min = 2;
  double view_apart_m = 8.0;
  double z_sigma_max_m = 0.5;
  double yaw_sigma_max_deg = 10.0;
  double place_sigma_max_m = 1.0;

  template <class V>
  void visit(V& v) {
    v.choice("rule", rule, kCommitRuleNames, "when a frame is accepted");
    v("min_keyframes", min_keyframes, 0, 100000, "of the local map");
    v("min_ranges", min_ranges, 0, 1000, "below: waiting for ranges");
    v("gap_chi2", gap_chi2, 0.0, 1e6, "by so much the best must beat the second (992 to 1)");
    v("evaluations", evaluations, 1, 100, "in a row that must agree");
    v("spacing_s", spacing_s, 0.0, 3600.0, "shortest time between two evaluations");
    v("new_ranges", new_ranges, 1, 1000, "ranges after which the hypotheses are searched again");
    v("fit_min", fit_min, 0.0, 1.0,
      "least chi2 per degree of freedom of the best; 0: sigmas may be too large");
    v("fit_max", fit_max, 1.0, 100.0, "largest chi2 per degree of freedom of the best");
    v("information_min", information_min, 0.0, 100.0,
      "least eigenvalue in the units below, were odometry exact");
    v("yaw_unit_deg", yaw_unit_deg, 0.01, 180.0, "unit of heading for it");
    v("place_unit_m", place_unit_m, 0.001, 100.0, "unit of place for it");
    v("views_min", views_min, 1, 1000,
      "unambiguous matches without ranges; every contradicting match requires one more agreeing "
      "match");
    v("view_apart_m", view_apart_m, 0.0, 1000.0, "smallest distance between two of them");
    v("z_sigma_max_m", z_sigma_max_m, 0.001, 100.0, "largest sigma of the height of a frame");
    v("yaw_sigma_max_deg", yaw_sigma_max_deg, 0.01, 180.0,
      "largest sigma of its heading, drift of odometry included");
    v("place_sigma_max_m", place_sigma_max_m, 0.001, 100.0, "and of its place, the worse axis");
  }
};

/// Frames between vehicles (`init.*`, algorithms_fleet 7.1). The defaults are those of `robust`.
struct InitSettings {
  double bias_sigma_m = 0.15;
  double z_sigma_m = 0.3;
  bool freeze = false;
  PriorSettings prior;
  ScanToMapSettings scan2map;
  TrackSettings track;
  DriftSettings drift;
  SearchSettings search;
  CommitSettings commit;

  template <class V>
  void visit(V& v) {
    v("bias_sigma_m", bias_sigma_m, 0.0, 10.0, "sigma of the offset of a pair of radios; 0: none");
    v("z_sigma_m", z_sigma_m, 1e-3, 1e3, "sigma of the height between start places: one floor");
    v("freeze", freeze, "a frame keeps its first solution");
    v.group("prior", prior, "start poses given by the user");
    v.group("scan2map", scan2map, "scans in the other's map");
    v.group("track", track, "which ranges are independent");
    v.group("drift", drift, "errors of odometry along the path");
    v.group("search", search, "search of all solutions");
    v.group("commit", commit, "when a frame is accepted");
  }
};

}  // namespace rali::fleet
