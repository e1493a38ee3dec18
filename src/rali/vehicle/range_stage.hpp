#pragma once

#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "rali/odometry/side_filter.hpp"
#include "rali/ranging/anchor_finder.hpp"
#include "rali/ranging/excess_watch.hpp"
#include "rali/ranging/place_mixture.hpp"
#include "rali/ranging/range_link.hpp"
#include "rali/ranging/range_sanity.hpp"
#include "rali/ranging/range_thinning.hpp"
#include "rali/vehicle/event.hpp"
#include "rali/vehicle/peer_places.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// What ranges did to the pose since the last sweep.
struct RangeEffect {
  double shift_m = 0.0;  ///< sum of the shifts' lengths along the way they went
  std::optional<VehicleId> from;
};

/// Ranges to peers that stand, as measurements of the odometry's filter (algorithms 4.3, 5.3): each
/// raw range once, at its own time. Its place, the pair's bias and the stamps' offset are side
/// states of the filter. Every range handed in comes out as one RangeUse.
class RangeStage {
 public:
  RangeStage(VehicleId self, const VehicleSettings& settings);

  /// Waits until the sweep that covers its time is there.
  void add(const sensor::RangeSample& sample, OutputList& out);
  void on(const PeerStatus& status);

  /// Uses what was measured up to `t_end`, the end of the next sweep.
  /// @param filter may be null: then every range is without effect
  /// @param g_odom_mps2 gravity as the odometry knows it
  /// @param first_pose pose of the first sweep, if there was one: priors refer to it
  RangeEffect run(Time t_end, odometry::SideFilter* filter, const geometry::Vec3& g_odom_mps2,
                  const std::optional<geometry::SE3>& first_pose, OutputList& out);

  /// Every sane range of the last run(), whatever became of it: for the fleet's joint estimate.
  [[nodiscard]] const std::vector<fleet::RangeEntry>& entries() const { return entries_; }

  /// Antennas of peers whose place at `t` is known to sigma_max_m, in odom: of those that stand by
  /// ranges, of those that drive by what they say. The doubt about this vehicle's place is in it.
  [[nodiscard]] std::vector<KnownPlace> places(const odometry::SideFilter& filter, Time t,
                                               double sigma_max_m) const;

  /// Peers heard lately whose place at `t` is not known that well: only how far away they are.
  [[nodiscard]] std::vector<HeardPeer> unplaced(const odometry::SideFilter& filter, Time t,
                                                double sigma_max_m) const;

  /// The walls beside the first antenna, in odom, where the vehicle is in a passage and sees both;
  /// nothing without anybody to tell.
  [[nodiscard]] std::optional<ranging::PassageWalls> walls(const odometry::SideFilter& filter,
                                                           const geometry::SE3& T_odom_body) const;

  /// Where those stand whose place is known: from the body, in odom axes.
  [[nodiscard]] std::vector<SeenPeer> seen(const odometry::SideFilter& filter,
                                           const geometry::SE3& T_odom_body) const;

  /// The side state that is the offset of the ranges' stamps; -1 before the first range is used.
  [[nodiscard]] int stamp_offset_state() const { return tau_; }

  /// What is left at the end of the data cannot be used any more.
  void flush(OutputList& out);

 private:
  /// (own antenna, peer, peer's antenna)
  using PairKey = std::tuple<std::uint8_t, VehicleId, std::uint8_t>;
  /// (peer, peer's antenna)
  using PlaceKey = std::tuple<VehicleId, std::uint8_t>;

  /// What is remembered of one pair of antennas.
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
    std::deque<std::pair<Time, geometry::Vec3>> sights;  ///< lines of sight lately, unit
    std::optional<sensor::RangeSample> glide;            ///< the last range, for steps
    double glide_m = 0.0;  ///< sum of the ranges' changes less those predicted
    double R_m2 = 0.0;     ///< as the gate said last
    int bias = -1;         ///< side state
    Time t_bias;
    double bias_m = 0.0, bias_sigma_m = 0.0;  ///< before it is a side state
    std::optional<Time> t_heard;
    std::optional<std::pair<Time, double>> heard;  ///< last range that a radio may measure [m]
    std::optional<Time> t_fit;  ///< of the last range used, or of the first that was not
    // Line of sight, as asked last.
    std::optional<Time> t_sight;
    geometry::Vec3 p_sight_m = geometry::Vec3::Zero();
    bool blocked = false;
  };

  /// While the vehicle is in a passage and where across it the other stands is open.
  struct Passage {
    ranging::PlaceMixture mixture;
    std::vector<PairKey> pairs;     ///< in the order of the mixture's biases
    geometry::Vec3 axis_odom;       ///< along which the LiDAR is blind, unit
    Time t;                         ///< of the last range
    Time t_blind;                   ///< when it was blind last
    double said_at_m = 0.0;         ///< range when it was said last how wide the passage is
    double nearest_m = 0.0;         ///< shortest range so far
    std::optional<double> ahead_m;  ///< along the mixture's axis, at the first range
  };

  struct Place {
    int side = -1;                                  ///< first of three side states
    geometry::Vec3 along = geometry::Vec3::Zero();  ///< line of sight when first heard, unit
    std::optional<Passage> passage;
    bool passed = false;  ///< nothing more is learned about the place across
    /// As well as walls have said how far aside it is.
    double aside_sigma_m = std::numeric_limits<double>::infinity();
  };

  struct Prediction {
    odometry::SideMeasurement measurement;
    int place = -1;              ///< first of three side states
    Passage* passage = nullptr;  ///< if it was predicted by its slices
    ranging::MixtureSight sight;
    int mixture_bias = -1;
    double variance_m2 = 0.0;  ///< of the prediction
    bool at_rest = false;
    double predicted_m = 0.0;
    double bias_m = 0.0;
    double rate_mps = 0.0;
    double bent_sigma_m = 0.0;  ///< of what a linear prediction leaves out
    geometry::Vec3 p_odom_antenna_m = geometry::Vec3::Zero();
    geometry::Vec3 p_odom_peer_m = geometry::Vec3::Zero();
    geometry::Mat3 P_between_m2 = geometry::Mat3::Zero();  ///< of the two antennas' distance
  };

  [[nodiscard]] Pair& pair_of(const PairKey& key);
  [[nodiscard]] bool understand(const sensor::RangeSample& sample, PairKey& key) const;
  void use(const sensor::RangeSample& sample, odometry::SideFilter& filter, RangeEffect& effect,
           ranging::RangeUse& use);
  [[nodiscard]] std::map<PlaceKey, KnownPlace> known(const odometry::SideFilter& filter, Time t,
                                                     double sigma_max_m) const;
  void forget_moved(odometry::SideFilter& filter);
  void forget_unfit(const PlaceKey& key, Pair& pair, Time t, bool fits,
                    odometry::SideFilter& filter);
  void remove_states(int first, int n, odometry::SideFilter& filter);
  [[nodiscard]] bool place_from_prior(const PlaceKey& key, odometry::SideFilter& filter);
  void seek_place(const PairKey& key, const odometry::Moment& now,
                  const sensor::RangeSample& sample, double sigma_m, odometry::SideFilter& filter);
  [[nodiscard]] bool place_by_side(const PairKey& key, const odometry::Moment& now,
                                   const sensor::RangeSample& sample, double sigma_m,
                                   odometry::SideFilter& filter);
  [[nodiscard]] bool place_by_other(const PairKey& key, const odometry::Moment& now,
                                    const sensor::RangeSample& sample, double sigma_m,
                                    odometry::SideFilter& filter);
  [[nodiscard]] std::optional<KnownPlace> place_as_seen(const PlaceKey& key,
                                                        const geometry::SE3& T_odom_body) const;
  [[nodiscard]] geometry::Mat3 start_of(const PeerWatch& peer) const;
  [[nodiscard]] static odometry::SideRowList own_position(const odometry::SideFilter& filter);
  [[nodiscard]] bool agrees(const Pair& pair, const sensor::RangeSample& sample,
                            double speed_mps) const;
  [[nodiscard]] ranging::FinderSample finder_sample(const PairKey& key, const odometry::Moment& now,
                                                    const sensor::RangeSample& sample,
                                                    double sigma_m,
                                                    const odometry::SideFilter& filter) const;
  [[nodiscard]] double height_of(const PairKey& key) const;

  /// How far ahead, or aside, the other is by its word, or by a range.
  struct Told {
    double value_m = 0.0;
    double variance_m2 = 0.0;
  };

  [[nodiscard]] std::optional<ranging::Aside> aside_as_told(const Told& told,
                                                            const ranging::Aside& passage) const;
  [[nodiscard]] std::optional<ranging::PassageWalls> walls_beside(
      const geometry::Vec3& p_odom_m, const geometry::Vec3& axis_odom,
      const odometry::SideFilter& filter) const;
  [[nodiscard]] std::optional<ranging::PassageWalls> walls_of(const PlaceKey& key) const;
  [[nodiscard]] double aside_sigma_m(const ranging::FinderSample& seen) const;
  void measure_aside(const PairKey& key, Place& place, const odometry::Moment& now,
                     odometry::SideFilter& filter) const;
  [[nodiscard]] std::optional<ranging::Aside> aside_by_walls(
      const PlaceKey& key, const geometry::Vec3& p_odom_m, const geometry::Vec3& axis_odom,
      const odometry::SideFilter& filter) const;
  [[nodiscard]] bool tells_side(const Told& told, const Told& there) const;
  [[nodiscard]] bool add_found(const PlaceKey& key, const ranging::FoundAnchor& found, Pair& pair,
                               Time t, odometry::SideFilter& filter);
  [[nodiscard]] bool add_place(const PlaceKey& key, const geometry::Vec3& p_odom_m,
                               const geometry::Mat3& covariance_m2,
                               const odometry::SideRowList& from, odometry::SideFilter& filter);
  [[nodiscard]] geometry::Mat3 between(const Place& place,
                                       const odometry::SideFilter& filter) const;
  [[nodiscard]] std::optional<Prediction> predict_known(const odometry::Moment& now,
                                                        const PairKey& key, Pair& pair,
                                                        const sensor::RangeSample& sample,
                                                        double sigma_m,
                                                        odometry::SideFilter& filter);
  void judge(Pair& pair, const sensor::RangeSample& sample, Prediction& prediction, double sigma_m,
             bool clear, odometry::SideFilter& filter, ranging::RangeUse& use);
  void add_pair_states(Pair& pair, Time t, odometry::SideFilter& filter);
  void walk(Pair& pair, Time t, odometry::SideFilter& filter);
  [[nodiscard]] std::optional<Prediction> predict(const odometry::Moment& now, const PairKey& key,
                                                  const Pair& pair, const Place& place,
                                                  const odometry::SideFilter& filter) const;
  void enter_passage(Place& place, const geometry::Mat3& P_between_m2, const odometry::Moment& now,
                     odometry::SideFilter& filter);
  [[nodiscard]] odometry::SideRowList rows_of(const Place& place,
                                              const odometry::SideFilter& filter) const;
  void predict_in_passage(const PairKey& key, Place& place, const odometry::Moment& now,
                          odometry::SideFilter& filter, Prediction& prediction);
  [[nodiscard]] geometry::Vec3 update_in_passage(const PlaceKey& key, const Prediction& prediction,
                                                 double R_m2, odometry::SideFilter& filter);
  [[nodiscard]] bool is_excess(Pair& pair, const sensor::RangeSample& sample,
                               const Prediction& prediction, double sigma_m, double pose_sigma_m,
                               odometry::SideFilter& filter) const;
  [[nodiscard]] bool blocked(Pair& pair, Time t, const Prediction& prediction,
                             const odometry::SideFilter& filter) const;

  VehicleId self_;
  VehicleSettings settings_;
  std::map<VehicleId, PeerWatch> peers_;
  std::map<PairKey, Pair> pairs_;
  std::map<PlaceKey, Place> places_;
  std::set<PlaceKey> lost_;  ///< places to be found again
  bool posed_ = false;       ///< the filter has found itself: what it refuses from then on is late
  int tau_ = -1;             ///< side state
  Time t_tau_;
  std::deque<sensor::RangeSample> waiting_;
  geometry::Vec3 up_odom_ = geometry::Vec3::UnitZ();
  std::optional<geometry::SE3> first_pose_;
  std::vector<fleet::RangeEntry> entries_;
};

}  // namespace rali::vehicle
