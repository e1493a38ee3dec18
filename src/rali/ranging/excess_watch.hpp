#pragma once

#include <deque>
#include <optional>

#include "rali/base/time.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// What a step in the residuals of one pair means.
enum class ExcessVerdict {
  kNone,     ///< no step: the range may be used
  kWaiting,  ///< may be the first of a step: not used until the next ones tell
  kExcess,   ///< the way has become longer than the straight one: not used
  kRelieved  ///< stepped down: what was used before was too long, and the pose followed it
};

/// Looks for steps in measured less predicted (algorithms 4.3, "decision over windows").
///
/// When the first path is missed, by a person or a vehicle in the way, a range becomes longer from
/// one sample to the next and stays so for a second or more. A gate does not see it where the pose
/// is doubtful by as much, and independent weights let twenty such ranges a second pull the pose
/// over. A vehicle cannot jump: between two samples the residual changes by noise alone. So a step
/// up begins an excess, which ends with a step down; one that lasts longer than any obstacle is
/// believed. A step down without a step up before means that the track began with an excess.
class ExcessWatch {
 public:
  explicit ExcessWatch(const ExcessSettings& settings) : settings_(settings) {}

  /// @param nu_m residual of the range, against the pose or against its own change by the predicted
  /// rate: corrections of the pose are no steps then
  /// @param sigma_m of one range in line of sight
  /// @param pose_sigma_m of the prediction: how far the level may have wandered unseen
  /// @param turn_sigma_m by how much the line of sight has turned over the last ranges, times the
  /// doubt about the pose: near the other antenna an error of the pose looks like a step
  [[nodiscard]] ExcessVerdict look(Time t, double nu_m, double sigma_m, double pose_sigma_m,
                                   double turn_sigma_m);

  /// How large the step was that look() last told of [m].
  [[nodiscard]] double step_m() const { return step_m_; }

  void reset();

 private:
  [[nodiscard]] double level() const;
  [[nodiscard]] double limit(double sigma_m) const;
  ExcessVerdict in_excess(Time t, double nu_m, double limit_m, double pose_sigma_m);
  ExcessVerdict pending(Time t, double nu_m, double limit_m);
  void follow(double nu_m);

  ExcessSettings settings_;
  std::deque<double> recent_m_;   ///< residuals since the last step
  std::deque<double> steps_m_;    ///< changes from sample to sample, for the noise
  std::deque<double> pending_m_;  ///< a step in doubt
  std::optional<Time> t_last_;
  std::optional<Time> t_excess_;
  double step_m_ = 0.0;
};

}  // namespace rali::ranging
