#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "rali/graph/local_graph.hpp"
#include "rali/vehicle/event.hpp"
#include "rali/vehicle/path_recorder.hpp"
#include "rali/vehicle/range_record.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// The second look: all keyframes of a stretch with what ties them together (algorithms 6), solved
/// when the stretch is at its end. The filter must decide about each range when it comes, at a pose
/// and a place of the other antenna as known then; later both are known better, and what went wrong
/// while the vehicle was blind and unheard is put right: the shift is shared by the keyframes that
/// had room for it.
///
/// Where the LiDAR knows, the shape of the filter's path is kept: it was registered against the
/// whole map, which no chain of relative poses can do better. Along blind directions only inertial
/// data and ranges speak. A stretch that was never blind for long is left alone.
class BackEnd {
 public:
  BackEnd(VehicleId self, const VehicleSettings& settings);

  /// After each sweep. @param node if the sweep is one
  /// @param ranges what was judged since the last one
  void add(const std::optional<PathNode>& node, const std::vector<RangeRecord>& ranges);

  /// Solves and says where the keyframes of the stretch were. @param places and pairs of the ranges
  void finish(const std::vector<PlaceRecord>& places, const std::vector<PairRecord>& pairs,
              const geometry::Vec3& g_odom_mps2, OutputList& out);

 private:
  struct NodeRange {
    RangeRecord record;
    std::size_t after = 0;  ///< node before it
  };

  [[nodiscard]] std::unique_ptr<graph::LocalGraph> build(const std::vector<PlaceRecord>& places,
                                                         const std::vector<PairRecord>& pairs,
                                                         const geometry::Vec3& g_odom_mps2) const;
  void add_motion(graph::LocalGraph& graph, std::size_t k, const geometry::Vec3& g_odom_mps2) const;
  [[nodiscard]] graph::RangeFactor factor_of(const NodeRange& range) const;
  void judge_again(graph::LocalGraph& graph, const std::vector<PairRecord>& pairs);
  void tell(const graph::LocalGraph& graph, OutputList& out) const;
  void forget();

  VehicleId self_;
  VehicleSettings settings_;
  std::vector<PathNode> nodes_;
  std::vector<NodeRange> ranges_;
  double blind_m_ = 0.0;  ///< way driven blind
};

}  // namespace rali::vehicle
