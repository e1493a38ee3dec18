#pragma once

#include <deque>
#include <optional>

#include "rali/base/time.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// What a step in the residuals of one pair means.
enum class ExcessVerdict {
  kNone,     ///< no step: the range may be used
  kWaiting,  ///< may be the first of a step: not used until the next ones decide
  kExcess,   ///< the signal path is longer than the line of sight: not used
  kRelieved  ///< stepped down: earlier ranges were too long, and the pose followed them
};

/// Detects steps in measured less predicted (algorithms 4.3, "decision over windows").
///
/// When a person or a vehicle blocks the first path, a range becomes longer from one sample to the
/// next and stays so for a second or more. A gate passes it where the pose is as uncertain, and
/// with independent weights twenty such ranges a second shift the pose. A vehicle cannot jump:
/// between two samples the residual changes by noise alone. So a step up starts an excess, which
/// ends with a step down. One that lasts longer than any obstacle is accepted as distance. A step
/// down without a step up before means that the track started with an excess.
class ExcessWatch {
 public:
  explicit ExcessWatch(const ExcessSettings& settings) : settings_(settings) {}

  /// @param nu_m residual of the range against the pose, or its own change less the predicted one:
  /// then corrections of the pose are no steps
  /// @param sigma_m of one range in line of sight
  /// @param pose_sigma_m of the prediction: how far the level may have drifted unobserved
  /// @param turn_sigma_m turn of the line of sight over the last ranges, times the sigma of the
  /// pose: near the other antenna an error of the pose looks like a step
  [[nodiscard]] ExcessVerdict look(Time t, double nu_m, double sigma_m, double pose_sigma_m,
                                   double turn_sigma_m);

  /// Size of the last step that look() reported [m].
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
  std::deque<double> pending_m_;  ///< residuals of a possible step
  std::optional<Time> t_last_;
  std::optional<Time> t_excess_;
  double step_m_ = 0.0;
};

}  // namespace rali::ranging
