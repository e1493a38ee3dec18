#pragma once

#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <vector>

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

/// Ranges this near in time: the distance has changed by the mean speed. Over more the speed
/// changes.
inline constexpr double kSteadySpeed_s = 0.5;

/// One range of a pair for the ExcessWatch.
struct ExcessSample {
  Time t;
  double range_m = 0.0;
  double change_m = 0.0;         ///< of the distance since the pair's last range, by motion alone
  double sigma_m = 0.0;          ///< of one range in line of sight
  double speed_sigma_mps = 0.0;  ///< of that motion along the line of sight
  /// Measured less predicted by a pose of which this is the sigma, if there is one: ranges that fit
  /// such a pose have no excess.
  double residual_m = 0.0;
  double pose_sigma_m = std::numeric_limits<double>::infinity();
  /// Turn of the line of sight over the last ranges, times the sigma of the pose: near the other
  /// antenna an error of the pose looks like a step.
  double turn_sigma_m = 0.0;
};

/// Detects steps of the ranges that no motion explains (algorithms 4.3, "decision over windows").
///
/// When a person or a vehicle blocks the first path, a range becomes longer from one sample to the
/// next and stays so for a second or more. A gate passes it where the pose is as uncertain, and
/// with independent weights twenty such ranges a second shift the pose. A vehicle cannot jump:
/// between two samples the range, less the motion, changes by noise alone. So a step up starts an
/// excess, which ends with a step down. How uncertain the pose has become meanwhile says nothing
/// about the obstacle: ranges are compared with each other, not with the pose. An obstacle that
/// comes gradually, or while ranges are missing, makes a step against the ranges of some seconds
/// before; there it must exceed what the motion leaves open. For the same reason an excess outlasts
/// missing ranges: it also ends when several ranges fit the pose, or are back at the level before
/// it. Between people who walk in the
/// way single ranges pass: meanwhile those at the level before are used. A step
/// down without a step up before means that the track started with an excess.
class ExcessWatch {
 public:
  explicit ExcessWatch(const ExcessSettings& settings) : settings_(settings) {}

  /// Ranges of one pair in the order of time.
  [[nodiscard]] ExcessVerdict look(const ExcessSample& sample);

  /// Size of the last step that look() reported [m]; that of the excess while there is one.
  [[nodiscard]] double step_m() const { return step_m_; }

  [[nodiscard]] bool in_excess() const { return t_excess_.has_value(); }

  void reset();

 private:
  /// Sum of the range changes that motion does not explain, at the time of a range.
  struct Seen {
    Time t;
    double unexplained_m;
  };

  /// Of a range against earlier ones.
  struct Change {
    double size_m = 0.0;
    double noise_m = 0.0;  ///< what noise may explain, of one range
    double open_m = 0.0;   ///< what motion may explain
    bool sudden = false;   ///< against the last ranges, and from one to the next

    [[nodiscard]] bool far() const { return std::abs(size_m) > std::hypot(noise_m, open_m); }
  };

  struct Pending {
    Seen seen;
    Change change;
  };

  [[nodiscard]] double limit(double sigma_m) const;
  [[nodiscard]] Seen level_before(std::deque<Seen>::const_iterator end) const;
  [[nodiscard]] std::optional<Change> change(const Seen& now, const ExcessSample& sample) const;
  [[nodiscard]] bool confirmed(const Seen& now, const std::optional<Change>& change,
                               double sigma_m);
  [[nodiscard]] double pending_m() const;
  [[nodiscard]] bool fits_again(const ExcessSample& sample);
  [[nodiscard]] bool has_returned(const ExcessSample& sample) const;
  [[nodiscard]] bool passes(const Seen& now);
  void drop_pending();
  void restart_at_pending();
  void follow(const Seen& now);

  ExcessSettings settings_;
  std::optional<Seen> last_;
  double last_range_m_ = 0.0;
  std::deque<Seen> seen_;         ///< since the last step
  std::deque<double> changes_m_;  ///< from sample to sample, for the noise
  std::vector<Pending> pending_;  ///< of a possible step
  std::optional<Time> t_excess_;
  double step_m_ = 0.0;
  Seen before_{};              ///< the level before the excess
  int fitting_ = 0;            ///< in a row, while there is an excess
  std::vector<Seen> passing_;  ///< the last ones, in a row, that were not too long
};

}  // namespace rali::ranging
