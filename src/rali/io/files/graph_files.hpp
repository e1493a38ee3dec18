#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::io {

/// A pose of the graph.
struct GraphVertex {
  Time t;
  KeyframeId id;
  geometry::SE3 T;  ///< in map
};

/// A relative pose. 6x6 matrices in the order of this program (rotation, translation) [rad, m],
/// rotation vector; the writers put translation first, as the formats want it.
struct GraphEdge {
  Time t;
  std::size_t from = 0, to = 0;  ///< indices in the list of vertices
  geometry::SE3 T_from_to;
  geometry::Mat6 information = geometry::Mat6::Identity();
  geometry::Mat6 covariance = geometry::Mat6::Identity();  ///< its inverse
};

struct GraphRange {
  Time t;
  std::size_t from = 0, to = 0;  ///< indices in the list of vertices
  double range_m = 0.0;
  double variance_m2 = 0.0;
};

struct GraphFile {
  std::vector<GraphVertex> vertices;
  std::vector<GraphEdge> edges;
  std::vector<GraphRange> ranges;
};

/// graph.g2o (product.md section 5): `VERTEX_SE3:QUAT` with the index in the list as id and
/// `EDGE_SE3:QUAT` with information; no other tag and no comment; ranges are left out.
[[nodiscard]] Status write_g2o(const std::string& path, const GraphFile& graph);

/// graph.pyfg: the same with covariances, stamps and ranges, as PyFactorGraph reads it. Names are a
/// letter for the vehicle, never L (that is a landmark), and the keyframe's number.
/// Errors: kNoAnswer for a vehicle beyond the 25 letters.
[[nodiscard]] Status write_pyfg(const std::string& path, const GraphFile& graph);

/// Name of a keyframe in a pyfg file, e.g. "A0"; empty beyond the letters.
[[nodiscard]] std::string pyfg_name(KeyframeId id);

}  // namespace rali::io
