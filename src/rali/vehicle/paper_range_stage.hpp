#pragma once

#include <array>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "rali/degeneracy/paper_degree.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/ranging/anchor_finder.hpp"
#include "rali/ranging/pair_calibration.hpp"
#include "rali/ranging/paper_smoother.hpp"
#include "rali/ranging/range_correction.hpp"
#include "rali/ranging/range_sanity.hpp"
#include "rali/vehicle/event.hpp"
#include "rali/vehicle/paper_window.hpp"
#include "rali/vehicle/peer_places.hpp"
#include "rali/vehicle/range_stage.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// The paper's use of ranges (section "Range Constraints for Degenerate Correction"; algorithms
/// 4.2, 5.2, 6.1). Ranges to a peer at standstill are smoothed. At a keyframe where the paper's
/// detector finds a degenerate direction and the range disagrees, the pose is moved along that
/// direction onto the circle of the range. The smoothed range then becomes a factor of the local
/// graph. Where the own position is observable without it, a smoothed range instead calibrates its
/// pair's constant error and the peer's position. Every range handed in comes out as one RangeUse.
class PaperRangeStage final : public odometry::KeyframeCorrector {
 public:
  PaperRangeStage(VehicleId self, const VehicleSettings& settings);

  /// Queues the range until the scan that covers its time arrives.
  void add(const sensor::RangeSample& sample, OutputList& out);
  void on(const PeerStatus& status);

  /// Smooths the ranges measured up to `t_end`, the end of the scan that is processed next.
  void before_scan(Time t_end, OutputList& out);

  [[nodiscard]] std::optional<geometry::Vec3> degenerate_direction(
      std::span<const geometry::Vec3> normals_body, const geometry::Vec3& up_body) const override;

  std::optional<odometry::KeyframeMove> at_keyframe(
      const odometry::ScanResult& scan, const odometry::KeyframeInertia& inertia) override;

  /// Reports the outcome of ranges and keyframes, and initialises peers of unknown position.
  RangeEffect after_scan(const odometry::ScanResult& result, OutputList& out);

  /// At the end of the data: reports the remaining ranges, which can no longer be used, and a
  /// summary of the corrections.
  void flush(OutputList& out);

 private:
  /// (own antenna, peer, peer's antenna)
  using PairKey = std::tuple<std::uint8_t, VehicleId, std::uint8_t>;

  /// A smoothed range whose outcome is not reported yet.
  struct Pending {
    ranging::RangeUse use;
    bool decided = false;
  };

  struct Pair {
    Pair(const ranging::RangingSettings& r, const ranging::PaperRangeSettings& paper,
         double given_m)
        : bias_m(given_m),
          sanity(r.limits, r.sanity),
          smoother(paper),
          finder(r.finder, given_m, r.bias.sigma_m) {}

    double bias_m;  ///< given by the user, subtracted from each range
    ranging::RangeSanity sanity;
    ranging::PaperRangeSmoother smoother;
    ranging::AnchorFinder finder;
    std::optional<ranging::SmoothedRange> newest;
    std::optional<geometry::Vec3> p_odom_peer_m;  ///< of antenna or body, by setting range_point
    geometry::Mat3 place_covariance_m2 = geometry::Mat3::Zero();
    /// Of the constant error and the peer's position; empty if no start pose was measured.
    std::optional<ranging::PairCalibration> calibration;
    std::optional<Time> t_unclear;  ///< of the last range whose signal shows an obstacle
    std::deque<Pending> pending;
    std::vector<sensor::RangeSample> sought;  ///< of this scan, to locate the peer

    /// The newest smoothed range less the pair's constant error. Requires `newest`.
    [[nodiscard]] double smoothed_m() const {
      return newest->range_m - (calibration ? calibration->constant_m() : 0.0);
    }
  };

  /// A pair whose smoothed range can be compared with the pose at a keyframe.
  struct Candidate {
    Pair* pair = nullptr;
    VehicleId peer;
    geometry::Vec3 p_body_m = geometry::Vec3::Zero();  ///< own end at the time of the range
    geometry::Vec3 p_odom_m = geometry::Vec3::Zero();  ///< the same in odom
    double along = 0.0;  ///< cosine between line of sight and degenerate direction, without sign
  };

  [[nodiscard]] std::optional<PairKey> understand(const sensor::RangeSample& sample) const;
  [[nodiscard]] Pair& pair_of(const PairKey& key);
  void forget_landmark(Pair& pair);
  void take(const sensor::RangeSample& sample, OutputList& out);
  void fix_landmark(const PairKey& key, Pair& pair);
  void calibrate(const PairKey& key, Pair& pair, const odometry::ScanResult& result,
                 const geometry::SE3& T_end);
  [[nodiscard]] geometry::Vec3 own_end(const PairKey& key) const;
  [[nodiscard]] geometry::Vec3 peers_end(const PairKey& key) const;
  [[nodiscard]] degeneracy::PaperDegree degree_of(const odometry::ScanResult& scan) const;
  [[nodiscard]] degeneracy::PaperDegree degree_until(const odometry::ScanResult& scan) const;
  [[nodiscard]] PaperWindow::Node node_of(std::uint32_t seq, const odometry::ScanResult& scan,
                                          const odometry::KeyframeInertia& inertia) const;
  [[nodiscard]] std::optional<Candidate> candidate_of(const PairKey& key, Pair& pair,
                                                      const odometry::ScanResult& scan) const;
  [[nodiscard]] std::optional<Candidate> best_candidate(const odometry::ScanResult& scan,
                                                        const geometry::Vec3& e3_odom);
  [[nodiscard]] ranging::Correction correct(const Candidate& candidate,
                                            const odometry::ScanResult& scan,
                                            const degeneracy::PaperDegree& degree,
                                            const geometry::SE3& T_odom_body_predicted) const;
  [[nodiscard]] bool wants_factor(const ranging::Correction& done, bool degenerate,
                                  double along) const;
  [[nodiscard]] bool apply(const ranging::Correction& done, const Candidate& candidate,
                           bool factor);
  void count(const ranging::Correction& done);
  void judge(ranging::CorrectionOutcome outcome, bool used, Pair& pair) const;
  [[nodiscard]] odometry::KeyframeMove move_of_window() const;
  [[nodiscard]] odometry::KnownAlong known_along(const Candidate& candidate,
                                                 const geometry::Vec3& e3_odom,
                                                 const geometry::Vec3& shift_odom_m) const;
  [[nodiscard]] geometry::SE3 pose_at(Time t, Time t_end, const geometry::SE3& T_end) const;
  void seek(const PairKey& key, Pair& pair, const odometry::ScanResult& result,
            const geometry::SE3& T_end);
  void predict(const PairKey& key, Pair& pair, Time t_end, const geometry::SE3& T_end) const;
  void report_ranges(Pair& pair, Time now, OutputList& out) const;
  void report_keyframes(OutputList& out);
  [[nodiscard]] Finding summary() const;

  VehicleId self_;
  VehicleSettings settings_;
  ranging::PaperRangeSettings paper_;
  degeneracy::PaperDegreeSettings degree_;
  bool literal_;  ///< as in the paper: no calibration, ranges correct steps in all directions
  std::map<VehicleId, PeerWatch> peers_;
  std::map<PairKey, Pair> pairs_;
  std::deque<sensor::RangeSample> waiting_;
  PaperWindow window_;
  std::map<std::uint32_t, geometry::SE3> reported_;  ///< keyframes of the window as last reported
  std::uint32_t next_seq_ = 0;

  std::optional<geometry::SE3> first_pose_;
  std::optional<geometry::Vec3> passage_odom_;     ///< degenerate direction of the last keyframe
  std::optional<geometry::Vec3> degenerate_odom_;  ///< the same of the last scan
  geometry::Mat3 covariance_m2_ = geometry::Mat3::Zero();  ///< of the last position
  Time t_last_;
  geometry::SE3 T_last_;
  std::optional<geometry::SE3> T_uncorrected_;  ///< of this scan, if it was moved
  RangeEffect effect_;                          ///< of this scan

  std::array<std::uint64_t, ranging::kCorrectionOutcomeNames.size()> outcomes_{};
  std::uint64_t closest_ = 0;
  double longest_m_ = 0.0;
};

}  // namespace rali::vehicle
