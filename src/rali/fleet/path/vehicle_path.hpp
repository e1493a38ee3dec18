#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rali/fleet/facts/facts.hpp"

namespace rali::fleet {

/// A pose on the path between two nodes: that of a vehicle at some time.
struct PathPlace {
  std::size_t node = 0;       ///< index in nodes(); the last one not after the time
  double alpha = 0.0;         ///< fraction of the time to the next node; 0 on or beyond the last
  geometry::SE3 T_odom_body;  ///< the body at the time, on an arc of constant twist
};

/// One vehicle's path in one odom frame, built from its facts in any order. It shares the facts'
/// data: many copies of a path take little memory.
class VehiclePath {
 public:
  struct Node {
    Time t;
    std::shared_ptr<const Increment> step;
  };

  explicit VehiclePath(VehicleId vehicle, std::uint32_t epoch = 0)
      : vehicle_(vehicle), epoch_(epoch) {}

  void add(const FactPtr& fact);

  /// The same for a body without a fact.
  void add(Time t, FactBody body);

  [[nodiscard]] VehicleId vehicle() const { return vehicle_; }

  [[nodiscard]] std::uint32_t epoch() const { return epoch_; }

  [[nodiscard]] const std::string& name() const { return start_.name; }

  [[nodiscard]] const std::vector<geometry::Vec3>& antennas_body_m() const {
    return start_.antennas_body_m;
  }

  /// By time; those that have not arrived are missing.
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

  /// Index of the node that is this keyframe.
  [[nodiscard]] std::optional<std::size_t> node_of(std::uint32_t keyframe) const;

  /// Index of the node of this number.
  [[nodiscard]] std::optional<std::size_t> index_of(std::uint32_t number) const;

  /// True if nothing is missing between nodes k - 1 and k, and they are in one map.
  [[nodiscard]] bool ties_to_before(std::size_t k) const;

  /// Nothing outside the path's time, or where a new map begins between the nodes.
  [[nodiscard]] std::optional<PathPlace> at(Time t) const;

  /// By time, as recorded by this vehicle.
  [[nodiscard]] const std::vector<std::shared_ptr<const RangeEntry>>& ranges() const {
    return ranges_;
  }

  /// By keyframe.
  [[nodiscard]] const std::map<std::uint32_t, KeyframePoints>& points() const { return points_; }

  /// Frees the points of keyframes before this node.
  void forget_points_before(std::size_t node);

  /// The newest node with gravity from inertial data; null: there is none.
  [[nodiscard]] const Increment* newest_levelled() const;

  /// Unit vector against gravity in odom, by the newest levelled node.
  [[nodiscard]] geometry::Vec3 up_odom() const;

  /// Whether gravity has been estimated from inertial data.
  [[nodiscard]] bool levelled() const { return newest_levelled() != nullptr; }

  /// Up direction used until inertial data determine it; z of odom unless set. @param up unit
  void set_up_odom(const geometry::Vec3& up) { up_unlevelled_ = up; }

  /// Distance travelled in degenerate stretches [m].
  [[nodiscard]] double degenerate_m() const;

 private:
  /// The first node not before this number.
  [[nodiscard]] std::vector<Node>::const_iterator numbered(std::uint32_t number) const;
  void add_node(Time t, std::shared_ptr<const Increment> step);
  void add_range(std::shared_ptr<const RangeEntry> range);

  VehicleId vehicle_;
  std::uint32_t epoch_ = 0;
  EpochStart start_;
  std::vector<Node> nodes_;
  std::map<std::uint32_t, std::uint32_t> keyframes_;  ///< to the number of its node
  std::map<std::uint32_t, KeyframePoints> points_;
  std::vector<std::shared_ptr<const RangeEntry>> ranges_;
  geometry::Vec3 up_unlevelled_ = geometry::Vec3::UnitZ();
};

}  // namespace rali::fleet
