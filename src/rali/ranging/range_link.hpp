#pragma once

#include <deque>
#include <optional>

#include "rali/base/time.hpp"
#include "rali/ranging/range_gate.hpp"
#include "rali/ranging/range_use.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// State of the link of one pair.
enum class LinkState {
  kGood,
  kSuspect,  ///< most recent ranges did not pass the gate: none is used
  kLost      ///< silent
};

/// Advice to the caller besides the use of a range.
enum class LinkAdvice {
  kNone,
  kWeAreWrong,  ///< the ranges agree with each other: multiply the pose's covariance
  kAlarm        ///< that was done as often as allowed and did not help: notify the user
};

/// One range as input of the gate.
struct LinkSample {
  Time t;
  double nu_m = 0.0;     ///< measured less predicted, bias included
  double S_m2 = 0.0;     ///< its variance as predicted, sigma^2 included
  double sigma_m = 0.0;  ///< of the range, as raised by signal and map
  bool clear = true;     ///< neither signal nor map indicate an obstacle
};

struct LinkDecision {
  bool use = false;
  RangeReason reason = RangeReason::kUsed;
  GateDecision gate;  ///< R to update with
  LinkState state = LinkState::kGood;
  LinkAdvice advice = LinkAdvice::kNone;
  double widen_factor = 1.0;  ///< on the covariance, if kWeAreWrong
};

/// Steps 4 to 6 of algorithms 4.3 for one pair: the gate, and the state of the link by its results.
///
/// GOOD to SUSPECT: more than half of the last 20 ranges failed the gate. SUSPECT to GOOD: 10 in a
/// row passed it. In SUSPECT, 20 ranges with one common offset and no sign of an obstacle mean that
/// the pose is wrong and not the link: kWeAreWrong, at most 3 times, then kAlarm once. For ranges
/// that are too long this holds only after `longer_s`, since no obstacle lasts that long. A silent
/// link is LOST. With its next range it returns to its earlier state, but its window starts anew.
class RangeLink {
 public:
  RangeLink(const GateSettings& gate, const LinkSettings& settings);

  /// Judges the next range. One that is not finite is refused as out of limits and changes nothing.
  [[nodiscard]] LinkDecision decide(const LinkSample& sample);

  /// State as of `now`, which may be LOST without any call of decide().
  [[nodiscard]] LinkState state(Time now) const;

 private:
  struct Seen {
    double nu_m, sigma_m;
    bool inside, clear;
  };

  void remember(const LinkSample& sample, bool inside);
  void enter(LinkState state);
  [[nodiscard]] bool mostly_rejected() const;
  [[nodiscard]] bool miss_by_one_offset(Time now) const;
  [[nodiscard]] LinkAdvice advise();

  GateSettings gate_;
  LinkSettings settings_;
  LinkState state_ = LinkState::kGood;
  std::optional<Time> last_;
  std::deque<Seen> window_;
  Time t_suspect_;  ///< when it became suspect
  int inside_in_row_ = 0;
  int widened_ = 0;
  bool alarmed_ = false;
};

}  // namespace rali::ranging
