#pragma once

#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "rali/odometry/augmented_filter.hpp"
#include "rali/ranging/anchor_finder.hpp"
#include "rali/ranging/excess_watch.hpp"
#include "rali/ranging/landmark_mixture.hpp"
#include "rali/ranging/range_link.hpp"
#include "rali/ranging/range_sanity.hpp"
#include "rali/ranging/range_thinning.hpp"
#include "rali/ranging/sight_turn.hpp"
#include "rali/vehicle/event.hpp"
#include "rali/vehicle/peer_places.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// Effect of the ranges on the pose since the last scan.
struct RangeEffect {
  double shift_m = 0.0;  ///< sum of the lengths of all shifts
  std::optional<VehicleId> from;
};

/// Ranges to peers at standstill as measurements of the odometry's filter (algorithms 4.3, 5.3):
/// each raw range once, at its own time. The landmark, the pair's bias and the offset of the stamps
/// are augmented states of the filter. Every range handed in comes out as one RangeUse.
class RangeStage {
 public:
  RangeStage(VehicleId self, const VehicleSettings& settings);

  /// Queues the range until the scan that covers its time arrives.
  void add(const sensor::RangeSample& sample, OutputList& out);
  void on(const PeerStatus& status);

  /// Uses the ranges measured up to `t_end`, the end of the next scan.
  /// @param filter may be null: then every range is without effect
  /// @param g_odom_mps2 gravity as estimated by the odometry
  /// @param first_pose pose of the first scan, if there was one: priors refer to it
  RangeEffect run(Time t_end, odometry::AugmentedFilter* filter, const geometry::Vec3& g_odom_mps2,
                  const std::optional<geometry::SE3>& first_pose, OutputList& out);

  /// Every sane range of the last run(), used or not, for the joint estimate of the fleet.
  [[nodiscard]] const std::vector<fleet::RangeEntry>& entries() const { return entries_; }

  /// Antennas of peers in odom whose position at `t` is known to sigma_max_m: from ranges for peers
  /// at standstill, from their reports for peers in motion. The covariance includes the uncertainty
  /// of the position of this vehicle.
  [[nodiscard]] std::vector<KnownLandmark> places(const odometry::AugmentedFilter& filter, Time t,
                                                  double sigma_max_m) const;

  /// Peers with a recent range whose position at `t` is not known that well: only their range.
  [[nodiscard]] std::vector<ReceivedPeer> unplaced(const odometry::AugmentedFilter& filter, Time t,
                                                   double sigma_max_m) const;

  /// The walls beside the first antenna, in odom, if the vehicle is in a passage and sees both.
  /// Empty if there is no peer to report them to.
  [[nodiscard]] std::optional<ranging::PassageWalls> walls(const odometry::AugmentedFilter& filter,
                                                           const geometry::SE3& T_odom_body) const;

  /// Positions of all landmarks relative to the body, in odom axes.
  [[nodiscard]] std::vector<SeenPeer> seen(const odometry::AugmentedFilter& filter,
                                           const geometry::SE3& T_odom_body) const;

  /// Index of the augmented state of the stamps' offset; -1 before the first range is used.
  [[nodiscard]] int stamp_offset_state() const { return tau_; }

  /// At the end of the data: reports the remaining ranges, which can no longer be used.
  void flush(OutputList& out);

 private:
  /// (own antenna, peer, peer's antenna)
  using PairKey = std::tuple<std::uint8_t, VehicleId, std::uint8_t>;
  /// (peer, peer's antenna)
  using LandmarkKey = std::tuple<VehicleId, std::uint8_t>;

  /// Prediction of a range that the ExcessWatch has seen.
  struct Watched {
    Time t;
    double distance_m = 0.0;
    double rate_mps = 0.0;
  };

  /// State of one pair of antennas.
  struct Pair {
    Pair(const ranging::RangingSettings& r, double bias_given_m, double bias_given_sigma_m)
        : sanity(r.limits, r.sanity),
          link(r.gate, r.link),
          thinning(r.slow),
          excess(r.excess),
          finder(r.finder, bias_given_m, bias_given_sigma_m),
          bias_m(bias_given_m),
          bias_sigma_m(bias_given_sigma_m) {}

    ranging::RangeSanity sanity;
    ranging::RangeLink link;
    ranging::RangeThinning thinning;
    ranging::ExcessWatch excess;
    ranging::AnchorFinder finder;
    ranging::SightTurn sight_turn;
    std::optional<Watched> watched;  ///< the last one
    double R_m2 = 0.0;               ///< last value from the gate
    int bias = -1;                   ///< index of the augmented state
    Time t_bias;
    double bias_m = 0.0, bias_sigma_m = 0.0;  ///< before it is an augmented state
    std::optional<Time> t_received;
    std::optional<std::pair<Time, double>> received;  ///< last sane range [m]
    std::optional<Time> t_fit;  ///< of the last range used, or of the first one after silence
    // Result of the last line-of-sight check.
    std::optional<Time> t_sight;
    geometry::Vec3 p_sight_m = geometry::Vec3::Zero();
    bool blocked = false;
  };

  /// Exists while the vehicle is in a passage and the lateral position of the peer is open.
  struct Passage {
    ranging::LandmarkMixture mixture;
    std::vector<PairKey> pairs;     ///< in the order of the mixture's biases
    geometry::Vec3 axis_odom;       ///< degenerate direction of the LiDAR, unit
    Time t;                         ///< of the last range
    Time t_degenerate;              ///< last time with a degenerate direction
    double reported_at_m = 0.0;     ///< range at the last bound on the lateral position
    double nearest_m = 0.0;         ///< shortest range so far
    std::optional<double> ahead_m;  ///< along the mixture's axis, at the first range
  };

  struct Place {
    int state_index = -1;  ///< index of the first of three augmented states
    geometry::Vec3 along = geometry::Vec3::Zero();  ///< line of sight at the first range, unit
    std::optional<Passage> passage;
    bool passed = false;  ///< the lateral position is no longer estimated
    /// Sigma of the lateral offset at the last use of the walls.
    double lateral_sigma_m = std::numeric_limits<double>::infinity();
  };

  struct Prediction {
    odometry::AugmentedMeasurement measurement;
    int place = -1;              ///< index of the first of three augmented states
    Passage* passage = nullptr;  ///< set if predicted by the slices of the mixture
    ranging::MixtureSight sight;
    int mixture_bias = -1;
    double variance_m2 = 0.0;  ///< of the prediction
    bool at_rest = false;
    double predicted_m = 0.0;
    double bias_m = 0.0;
    double rate_mps = 0.0;
    double bent_sigma_m = 0.0;  ///< of the second-order term that linearisation omits
    geometry::Vec3 p_odom_antenna_m = geometry::Vec3::Zero();
    geometry::Vec3 p_odom_peer_m = geometry::Vec3::Zero();
    geometry::Mat3 P_between_m2 = geometry::Mat3::Zero();  ///< of the vector between the antennas
  };

  [[nodiscard]] Pair& pair_of(const PairKey& key);
  [[nodiscard]] bool understand(const sensor::RangeSample& sample, PairKey& key) const;
  void use(const sensor::RangeSample& sample, odometry::AugmentedFilter& filter,
           RangeEffect& effect, ranging::RangeUse& use);
  [[nodiscard]] std::map<LandmarkKey, KnownLandmark> known(const odometry::AugmentedFilter& filter,
                                                           Time t, double sigma_max_m) const;
  void forget_moved(odometry::AugmentedFilter& filter);
  void forget_unfit(const LandmarkKey& key, Pair& pair, Time t, bool fits,
                    odometry::AugmentedFilter& filter);
  void remove_states(int first, int n, odometry::AugmentedFilter& filter);
  [[nodiscard]] bool place_from_prior(const LandmarkKey& key, odometry::AugmentedFilter& filter);
  void initialise_landmark(const PairKey& key, const odometry::Moment& now,
                           const sensor::RangeSample& sample, double sigma_m,
                           odometry::AugmentedFilter& filter);
  [[nodiscard]] bool initialise_by_lateral_offset(const PairKey& key, const odometry::Moment& now,
                                                  const sensor::RangeSample& sample, double sigma_m,
                                                  odometry::AugmentedFilter& filter);
  [[nodiscard]] bool initialise_from_peer(const PairKey& key, const odometry::Moment& now,
                                          const sensor::RangeSample& sample, double sigma_m,
                                          odometry::AugmentedFilter& filter);
  [[nodiscard]] std::optional<KnownLandmark> place_as_seen(const LandmarkKey& key,
                                                           const geometry::SE3& T_odom_body) const;
  [[nodiscard]] geometry::Mat3 start_of(const PeerWatch& peer) const;
  [[nodiscard]] static odometry::AugmentedRowList own_position(
      const odometry::AugmentedFilter& filter);
  [[nodiscard]] bool agrees(const Pair& pair, const sensor::RangeSample& sample,
                            double speed_mps) const;
  [[nodiscard]] ranging::FinderSample finder_sample(const PairKey& key, const odometry::Moment& now,
                                                    const sensor::RangeSample& sample,
                                                    double sigma_m,
                                                    const odometry::AugmentedFilter& filter) const;
  [[nodiscard]] double height_of(const PairKey& key) const;

  /// Distance ahead or lateral offset of the peer, by its report or by a range.
  struct Reported {
    double value_m = 0.0;
    double variance_m2 = 0.0;
  };

  [[nodiscard]] std::optional<ranging::LateralOffset> lateral_as_reported(
      const Reported& reported, const ranging::LateralOffset& passage) const;
  [[nodiscard]] std::optional<ranging::PassageWalls> walls_beside(
      const geometry::Vec3& p_odom_m, const geometry::Vec3& axis_odom,
      const odometry::AugmentedFilter& filter) const;
  [[nodiscard]] std::optional<ranging::PassageWalls> walls_of(const LandmarkKey& key) const;
  [[nodiscard]] double lateral_sigma_m(const ranging::FinderSample& seen) const;
  void measure_lateral_offset(const PairKey& key, Place& place, const odometry::Moment& now,
                              odometry::AugmentedFilter& filter) const;
  [[nodiscard]] std::optional<ranging::LateralOffset> lateral_offset_by_walls(
      const LandmarkKey& key, const geometry::Vec3& p_odom_m, const geometry::Vec3& axis_odom,
      const odometry::AugmentedFilter& filter) const;
  [[nodiscard]] bool shows_side(const Reported& reported, const Reported& there) const;
  [[nodiscard]] bool add_found(const LandmarkKey& key, const ranging::FoundAnchor& found,
                               Pair& pair, Time t, odometry::AugmentedFilter& filter);
  [[nodiscard]] bool add_place(const LandmarkKey& key, const geometry::Vec3& p_odom_m,
                               const geometry::Mat3& covariance_m2,
                               const odometry::AugmentedRowList& from,
                               odometry::AugmentedFilter& filter);
  [[nodiscard]] geometry::Mat3 between(const Place& place,
                                       const odometry::AugmentedFilter& filter) const;
  [[nodiscard]] std::optional<Prediction> predict_known(const odometry::Moment& now,
                                                        const PairKey& key, Pair& pair,
                                                        const sensor::RangeSample& sample,
                                                        double sigma_m,
                                                        odometry::AugmentedFilter& filter);
  void judge(Pair& pair, const sensor::RangeSample& sample, Prediction& prediction, double sigma_m,
             bool clear, odometry::AugmentedFilter& filter, ranging::RangeUse& use);
  void add_pair_states(Pair& pair, Time t, odometry::AugmentedFilter& filter);
  void walk(Pair& pair, Time t, odometry::AugmentedFilter& filter);
  [[nodiscard]] std::optional<Prediction> predict(const odometry::Moment& now, const PairKey& key,
                                                  const Pair& pair, const Place& place,
                                                  const odometry::AugmentedFilter& filter) const;
  void enter_passage(Place& place, const geometry::Mat3& P_between_m2, const odometry::Moment& now,
                     odometry::AugmentedFilter& filter);
  [[nodiscard]] odometry::AugmentedRowList rows_of(const Place& place,
                                                   const odometry::AugmentedFilter& filter) const;
  void predict_in_passage(const PairKey& key, Place& place, const odometry::Moment& now,
                          odometry::AugmentedFilter& filter, Prediction& prediction);
  [[nodiscard]] geometry::Vec3 update_in_passage(const LandmarkKey& key,
                                                 const Prediction& prediction, double R_m2,
                                                 odometry::AugmentedFilter& filter);
  [[nodiscard]] bool is_excess(Pair& pair, const sensor::RangeSample& sample,
                               const Prediction& prediction, double sigma_m, double pose_sigma_m,
                               odometry::AugmentedFilter& filter) const;
  [[nodiscard]] bool blocked(Pair& pair, Time t, const Prediction& prediction,
                             const odometry::AugmentedFilter& filter) const;
  [[nodiscard]] bool leaves_seen_space(const geometry::Vec3& p_odom_m,
                                       const geometry::Vec3& q_odom_m,
                                       const odometry::AugmentedFilter& filter) const;
  void remember_place(const geometry::Vec3& p_odom_m);

  VehicleId self_;
  VehicleSettings settings_;
  std::map<VehicleId, PeerWatch> peers_;
  std::map<PairKey, Pair> pairs_;
  std::map<LandmarkKey, Place> places_;
  std::set<LandmarkKey> lost_;  ///< landmarks that only ranges may initialise again
  bool posed_ = false;  ///< the filter is initialised: a time that it refuses from then on is late
  int tau_ = -1;        ///< index of the augmented state
  Time t_tau_;
  std::deque<sensor::RangeSample> waiting_;
  geometry::Vec3 up_odom_ = geometry::Vec3::UnitZ();
  std::vector<geometry::Vec3> been_odom_m_;  ///< where the vehicle has been, oldest first
  std::optional<geometry::SE3> first_pose_;
  std::vector<fleet::RangeEntry> entries_;
};

}  // namespace rali::vehicle
