#include "rali/drive/offset/clock_offset.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "rali/ranging/stamp_offset.hpp"

namespace rali::drive {
namespace {

using ranging::StandWindow;
using ranging::TrackPoint;

/// A window is as long as the vehicle stands: one position explains all its ranges. By inertial
/// data alone the speed of the other is wrong by a constant for a shorter time.
constexpr double kWindowMax_s = 40.0, kDegenerateWindow_s = 12.0, kWindowGrowth_s = 1.0;
constexpr double kStanding_m = 0.05;  ///< a window must not reach into the next drive
constexpr double kDriven_m = 1.0;
constexpr double kTrackMargin_s = 1.0;
/// The second search, from the result of the first: fewer windows are lost at their ends.
constexpr double kRefine_s = 0.3;
constexpr double kLatencySigma_s = 0.02;  ///< prior, as ranging.bias.tau_sigma_s
/// By inertial data alone the speed along a tunnel is wrong by so much after half a minute.
constexpr double kDegenerateSpeed_mps = 1.0;

/// A vehicle's antenna: index of the vehicle, and of the antenna.
using Antenna = std::pair<std::size_t, std::size_t>;

/// How one vehicle's clock differs from that of some ranges.
struct Difference {
  std::size_t clock, mover;
  ranging::StampOffset offset;
};

/// Windows of the ranges on one clock along the motion of one vehicle.
struct MoverWindows {
  std::vector<StandWindow> windows;
  ranging::NoOffset why = ranging::NoOffset::kTooLittle;
};

class ClockStudy {
 public:
  ClockStudy(std::span<const ClockEvidence> vehicles, std::span<const sensor::RangeSample> ranges,
             const ClockSearch& search)
      : vehicles_(vehicles), search_(search) {
    collect(ranges);
  }

  /// One difference for each clock and mover that the motion determines.
  [[nodiscard]] std::vector<Difference> differences() {
    std::vector<Difference> found;
    for (auto& [key, mover] : movers_) {
      const auto [clock, vehicle] = key;
      thin(mover.windows);
      const auto offset =
          ranging::find_stamp_offset(mover.windows, search_of(clock, vehicle), &mover.why);
      if (offset) found.push_back({clock, vehicle, *offset});
    }
    return found;
  }

  /// Why ranges of other clocks do not determine the clock of this vehicle.
  [[nodiscard]] ranging::NoOffset why_not(std::size_t vehicle) const {
    for (const auto& [key, mover] : movers_) {
      if (key.second == vehicle && key.first != vehicle) return mover.why;
    }
    return ranging::NoOffset::kTooLittle;
  }

 private:
  /// Clock and the two antennas of a range.
  using Link = std::tuple<std::size_t, Antenna, Antenna>;

  void collect(std::span<const sensor::RangeSample> ranges) {
    std::map<Link, std::vector<ranging::TimedRange>> links;
    for (const sensor::RangeSample& s : ranges) {
      const Antenna from{s.from.value, s.from_antenna}, to{s.to.value, s.to_antenna};
      const bool usable = exists(from) && exists(to) && from.first != to.first &&
                          s.clock.value < vehicles_.size() && std::isfinite(s.range_m);
      if (!usable) continue;
      links[{s.clock.value, std::min(from, to), std::max(from, to)}].push_back({s.t, s.range_m});
    }
    for (auto& [link, timed] : links) {
      std::stable_sort(timed.begin(), timed.end(),
                       [](const auto& a, const auto& b) { return a.t < b.t; });
      const auto& [clock, a, b] = link;
      add_windows(clock, a, b, timed);
      add_windows(clock, b, a, timed);
    }
  }

  [[nodiscard]] bool exists(const Antenna& antenna) const {
    return antenna.first < vehicles_.size() &&
           antenna.second < vehicles_[antenna.first].antennas_body_m.size();
  }

  /// How far the clock of a vehicle may be from another: its own is off by the latency only.
  [[nodiscard]] double search_of(std::size_t clock, std::size_t vehicle) const {
    return clock == vehicle ? kRefine_s : search_.half_s;
  }

  void add_windows(std::size_t clock, const Antenna& standing, const Antenna& mover,
                   const std::vector<ranging::TimedRange>& ranges) {
    if (ranges.size() < ranging::PeerFit::kRangesMin) return;
    const Duration margin = Duration::from_s(search_of(clock, standing.first));
    for (std::size_t begin = 0; begin < ranges.size();) {
      const std::size_t end = end_of_stand(standing, mover, ranges, begin, margin);
      if (end - begin >= ranging::PeerFit::kRangesMin)
        add_window(clock, mover, {ranges.data() + begin, end - begin});
      begin = std::max(end, begin + 1);
    }
  }

  /// The first range after the longest window from `begin` on.
  [[nodiscard]] std::size_t end_of_stand(const Antenna& standing, const Antenna& mover,
                                         const std::vector<ranging::TimedRange>& ranges,
                                         std::size_t begin, Duration margin) {
    const Time t = ranges[begin].t;
    std::size_t end = begin;
    for (double length_s = kWindowGrowth_s; length_s <= kWindowMax_s; length_s += kWindowGrowth_s) {
      const Time until = t + Duration::from_s(length_s);
      if (!stands(standing, t - margin, until + margin)) break;
      if (length_s > kDegenerateWindow_s && is_degenerate(mover, t - margin, until + margin)) break;
      while (end < ranges.size() && ranges[end].t < until) ++end;
      if (end == ranges.size()) break;
    }
    return end;
  }

  [[nodiscard]] bool is_degenerate(const Antenna& antenna, Time from, Time to) {
    const ranging::Track track = part(track_of(antenna), from, to);
    return std::any_of(track.begin(), track.end(),
                       [](const TrackPoint& p) { return p.speed_sigma_mps > 0.0; });
  }

  void add_window(std::size_t clock, const Antenna& mover,
                  std::span<const ranging::TimedRange> ranges) {
    const Duration margin = Duration::from_s(search_of(clock, mover.first) + kTrackMargin_s);
    const ranging::Track track =
        part(track_of(mover), ranges.front().t - margin, ranges.back().t + margin);
    if (ranging::extent_m(track) < kDriven_m) return;
    StandWindow window{track, {}};
    const std::size_t step = (ranges.size() + search_.ranges_max - 1) / search_.ranges_max;
    for (std::size_t i = 0; i < ranges.size(); i += step) window.ranges.push_back(ranges[i]);
    movers_[{clock, mover.first}].windows.push_back(std::move(window));
  }

  [[nodiscard]] bool stands(const Antenna& antenna, Time from, Time to) {
    const ranging::Track track = part(track_of(antenna), from, to);
    return !track.empty() && ranging::extent_m(track) < kStanding_m &&
           track.front().piece == track.back().piece;
  }

  [[nodiscard]] static ranging::Track part(ranging::Track track, Time from, Time to) {
    const auto before = [](const TrackPoint& p, Time t) { return p.t < t; };
    const auto begin = std::lower_bound(track.begin(), track.end(), from, before);
    const auto end = std::lower_bound(begin, track.end(), to, before);
    return track.subspan(static_cast<std::size_t>(begin - track.begin()),
                         static_cast<std::size_t>(end - begin));
  }

  [[nodiscard]] ranging::Track track_of(const Antenna& antenna) {
    std::vector<TrackPoint>& track = tracks_[antenna];
    if (!track.empty()) return track;
    const ClockEvidence& vehicle = vehicles_[antenna.first];
    const geometry::Vec3& lever = vehicle.antennas_body_m[antenna.second];
    track.reserve(vehicle.poses.size());
    for (const ClockPose& pose : vehicle.poses) {
      track.push_back({pose.t, pose.T_odom_body * lever, pose.piece,
                       pose.degenerate ? kDegenerateSpeed_mps : 0.0});
    }
    return track;
  }

  /// Keeps windows evenly over the whole recording.
  void thin(std::vector<StandWindow>& windows) const {
    const std::size_t step = (windows.size() + search_.windows_max - 1) / search_.windows_max;
    std::vector<StandWindow> kept;
    for (std::size_t i = 0; i < windows.size(); i += step) kept.push_back(std::move(windows[i]));
    windows = std::move(kept);
  }

  std::span<const ClockEvidence> vehicles_;
  ClockSearch search_;
  std::map<Antenna, std::vector<TrackPoint>> tracks_;  ///< its addresses are those of the windows
  std::map<std::pair<std::size_t, std::size_t>, MoverWindows> movers_;  ///< by clock and mover
};

const char* reason(ranging::NoOffset why) {
  switch (why) {
    case ranging::NoOffset::kTooLittle:
      return "too few ranges while it drove and the other vehicle stood";
    case ranging::NoOffset::kNoMotion:
      return "the ranges fit its motion at any time";
    case ranging::NoOffset::kSeveral:
      return "several offsets fit its motion alike";
    case ranging::NoOffset::kBeyond:
      break;
  }
  return "none within the search fits its motion";
}

/// Joint estimate of all clocks and of the latency of the ranges.
struct ClockSolution {
  Eigen::VectorXd value_s, sigma_s;  ///< of each vehicle; at last the latency
  std::vector<std::size_t> used;     ///< ranges of each mover on other clocks
  std::vector<const char*> reasons;  ///< of each vehicle

  [[nodiscard]] bool is_within(std::size_t vehicle, double sigma_max_s) const {
    const auto i = static_cast<Eigen::Index>(vehicle);
    return sigma_s[i] <= sigma_max_s && std::isfinite(value_s[i]);
  }

  [[nodiscard]] std::string why_not(std::size_t vehicle) const {
    constexpr double kObserved_s = 1.0;  // beyond it no range has observed it
    if (!is_within(vehicle, kObserved_s)) return fmt::format("not found: {}", reasons[vehicle]);
    return fmt::format("not found: known to {:.0f} ms only (1 sigma)",
                       1e3 * sigma_s[static_cast<Eigen::Index>(vehicle)]);
  }
};

ClockSolution solve(std::span<const ClockEvidence> vehicles,
                    std::span<const sensor::RangeSample> ranges, const ClockSearch& search) {
  constexpr double kNothing = 1e-12, kCertain = 1e12;
  const auto count = static_cast<Eigen::Index>(vehicles.size());
  Eigen::MatrixXd H = kNothing * Eigen::MatrixXd::Identity(count + 1, count + 1);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(count + 1);
  for (Eigen::Index i = 0; i < count; ++i) {
    if (i == 0 || vehicles[static_cast<std::size_t>(i)].known) H(i, i) = kCertain;
  }
  H(count, count) = search.latency_known ? kCertain : 1.0 / (kLatencySigma_s * kLatencySigma_s);
  ClockSolution out;
  out.used.assign(vehicles.size(), 0);
  ClockStudy study(vehicles, ranges, search);
  for (const Difference& d : study.differences()) {
    // Stamps of the clock minus those of the mover, at one moment.
    Eigen::VectorXd J = Eigen::VectorXd::Zero(count + 1);
    J[static_cast<Eigen::Index>(d.mover)] += 1.0;
    J[static_cast<Eigen::Index>(d.clock)] -= 1.0;
    J[count] = 1.0;
    const double information = 1.0 / (d.offset.sigma_s * d.offset.sigma_s);
    H += information * J * J.transpose();
    b += information * d.offset.value_s * J;
    out.used[d.mover] += d.clock == d.mover ? 0 : d.offset.ranges;
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(H);
  out.value_s = solver.solve(b);
  const Eigen::MatrixXd P = solver.solve(Eigen::MatrixXd::Identity(count + 1, count + 1));
  out.sigma_s = P.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (std::size_t v = 0; v < vehicles.size(); ++v) out.reasons.push_back(reason(study.why_not(v)));
  return out;
}

}  // namespace

void ClockEvidence::add(Time t, const geometry::SE3& T_odom_body, vehicle::PoseQuality quality,
                        bool degenerate) {
  if (quality == vehicle::PoseQuality::kDiverged) {
    ++piece;
  } else {
    poses.push_back({t, T_odom_body, piece, degenerate});
  }
}

std::vector<ClockOffset> judge_clock_offsets(std::span<const ClockEvidence> vehicles,
                                             std::span<const sensor::RangeSample> ranges,
                                             const ClockSearch& search) {
  const ClockSolution first = solve(vehicles, ranges, search);
  std::vector<Duration> shifts(vehicles.size());
  std::vector<bool> found(vehicles.size());
  for (std::size_t v = 0; v < vehicles.size(); ++v) {
    found[v] = first.is_within(v, 0.5 * kRefine_s);
    if (found[v]) shifts[v] = Duration::from_s(first.value_s[static_cast<Eigen::Index>(v)]);
  }
  std::vector<ClockEvidence> shifted(vehicles.begin(), vehicles.end());
  for (std::size_t v = 0; v < shifted.size(); ++v) {
    for (ClockPose& pose : shifted[v].poses) pose.t = pose.t + shifts[v];
  }
  std::vector<sensor::RangeSample> shifted_ranges(ranges.begin(), ranges.end());
  for (sensor::RangeSample& s : shifted_ranges) {
    if (s.clock.value < shifts.size()) s.t = s.t + shifts[s.clock.value];
  }
  ClockSearch refine = search;
  refine.half_s = kRefine_s;
  const ClockSolution second = solve(shifted, shifted_ranges, refine);
  std::vector<ClockOffset> out(vehicles.size());
  for (std::size_t v = 0; v < vehicles.size(); ++v) {
    if (v == 0 || vehicles[v].known) continue;
    if (!found[v] || !second.is_within(v, kClockSigmaMax_s)) {
      out[v].origin = (found[v] ? second : first).why_not(v);
      continue;
    }
    const auto i = static_cast<Eigen::Index>(v);
    const double value_s = shifts[v].s() + second.value_s[i];
    out[v].value_s = std::round(value_s * 1e4) * 1e-4;
    out[v].sigma_s = second.sigma_s[i];
    out[v].origin = fmt::format("by {} ranges to vehicles that stood, sigma {:.1f} ms",
                                second.used[v], 1e3 * second.sigma_s[i]);
  }
  return out;
}

}  // namespace rali::drive
