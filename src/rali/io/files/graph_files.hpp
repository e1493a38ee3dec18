#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
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

/// A relative pose. 6x6 matrices in this program's order (rotation, translation) [rad, m], rotation
/// vector; the writers put translation first, as the formats require.
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

/// A g2o file of any origin.
struct G2oFile {
  GraphFile graph;                ///< stamps and keyframe ids are not in the file; no covariances
  std::vector<std::int64_t> ids;  ///< of the vertices, as the file names them
  std::vector<bool> placed;       ///< false: only edges refer to the vertex, its pose is identity
  bool planar = false;            ///< the file contains only 2-D elements
};

/// Reads `VERTEX_SE3:QUAT`, `EDGE_SE3:QUAT`, `VERTEX_SE2` and `EDGE_SE2`. Planar poses and edges
/// get z, roll and pitch 0 with information 1e4 (algorithms_fleet 8.7). Information is kept as in
/// the file, reordered to this program's order. If the file's rotation is the vector part of a
/// quaternion, the information is four times larger. Vertices come in the order of the file, then
/// those that only edges name. `FIX` and lines that begin with # are ignored.
/// Errors: kInput with file:line for anything else, numbers that are not finite, a vertex named
/// twice, an edge from a vertex to itself, an invalid quaternion; files beyond 1 GB.
[[nodiscard]] Result<G2oFile> read_g2o(const std::string& path);

/// The same from text; `name` stands in errors.
[[nodiscard]] Result<G2oFile> parse_g2o(std::string_view text, const std::string& name);

/// graph.pyfg: the same with covariances, stamps and ranges, as PyFactorGraph reads it. Names are a
/// letter for the vehicle, never L (that is a landmark), and the keyframe's number.
/// Errors: kNoAnswer for a vehicle beyond the 25 letters.
[[nodiscard]] Status write_pyfg(const std::string& path, const GraphFile& graph);

/// Name of a keyframe in a pyfg file, e.g. "A0"; empty beyond the letters.
[[nodiscard]] std::string pyfg_name(KeyframeId id);

}  // namespace rali::io
