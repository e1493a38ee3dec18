#pragma once

#include <vector>

#include <Eigen/Core>

#include "rali/fleet/frames/frame_problem.hpp"

namespace rali::fleet {

/// Residual of an alternative at given values: yaw, then position in b.
[[nodiscard]] Vec4 evidence_residual(const FrameProblem& problem, const FrameValues& v,
                                     const EvidenceGroup& group, std::size_t k);

/// Normal equations of a problem at given values.
class FrameNormal {
 public:
  explicit FrameNormal(const FrameProblem& problem);

  /// Values after applying step d.
  [[nodiscard]] FrameValues moved(const FrameValues& v, const Eigen::VectorXd& d) const;

  /// @param holds accepted alternative per group of evidence
  /// @return cost: sum of the robust squares
  double build(const FrameValues& v, const std::vector<int>& holds);

  /// Adds only the terms of the evidence. @return their cost
  double build_evidence(const FrameValues& v, const std::vector<int>& holds);

  /// Exchanges the equations with those of the same problem at other values.
  void swap(FrameNormal& other);

  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double beyond_fit = 0.0;  ///< part of the cost that the fit test excludes
  double obstructed = 0.0;  ///< part of the cost that obstructed lines of sight would explain

 private:
  /// Ranges of one pair: they depend on the same unknowns.
  struct Run {
    std::size_t first = 0, last = 0;  ///< of problem.ranges; the last is excluded
    std::vector<Eigen::Index> at;     ///< unknowns, in the order of a row
  };

  /// A frame at the values, with its sine and cosine, which every range needs.
  struct Placed {
    double cos_yaw = 1.0, sin_yaw = 0.0;
    geometry::Vec3 t_m = geometry::Vec3::Zero();
    geometry::Vec3 pivot_m = geometry::Vec3::Zero();  ///< in the first frame
  };

  [[nodiscard]] std::vector<Run> runs() const;
  void set_frames(const FrameValues& v);
  double add_priors(const FrameValues& v);
  double add_run(const FrameValues& v, const Run& run);
  [[nodiscard]] bool is_too_long(std::size_t k) const;
  double limit_rows(const Run& run);
  double write_row(const FrameValues& v, const RangeTerm& r, Eigen::Index row);
  [[nodiscard]] geometry::Vec3 place_of(const FrameValues& v, std::size_t f,
                                        const geometry::Vec3& x,
                                        const Eigen::Matrix3Xd& drift) const;
  double* write_end(std::size_t f, const geometry::Vec3& place_m, const Eigen::Matrix3Xd& drift,
                    const geometry::Vec3& u, double* out) const;
  double add_evidence(const FrameValues& v, const EvidenceGroup& group, std::size_t k);
  [[nodiscard]] std::vector<Eigen::Index> evidence_unknowns(const EvidenceGroup& group,
                                                            std::size_t k) const;
  [[nodiscard]] Eigen::Matrix4Xd evidence_slope(const FrameValues& v, const EvidenceGroup& group,
                                                std::size_t k) const;

  const FrameProblem& p_;
  std::vector<Eigen::Index> drift_at_;
  std::vector<Run> runs_;
  std::vector<Placed> frames_;
  Eigen::MatrixXd rows_;       ///< unknowns x ranges of a run, whitened
  Eigen::VectorXd residuals_;  ///< whitened
  std::vector<double> costs_;  ///< of the ranges of a run
  Eigen::MatrixXd squares_;    ///< rows_ rows_^T, lower half
  Eigen::VectorXd slope_;
};

}  // namespace rali::fleet
