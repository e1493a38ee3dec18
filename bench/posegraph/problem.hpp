#pragma once

#include <string>

#include "rali/graph/pose_graph.hpp"
#include "rali/io/files/graph_files.hpp"

namespace rali::posegraph {

/// Where the poses begin.
enum class Start {
  kFile,      ///< vertices of the file; those without a pose along the edges
  kOdometry,  ///< along the edges from vertex to next vertex, none from the file but the first
};

/// Poses of all vertices by chaining edges from placed vertices, in the order of the edges.
[[nodiscard]] std::vector<geometry::SE3> chained(const io::G2oFile& file);

/// One node per vertex, in their order, the first one held; one relative pose per edge.
[[nodiscard]] graph::PoseGraph make_graph(const io::G2oFile& file, Start start,
                                          const graph::GraphSettings& settings);

/// Several files as one: vertices by id, an edge between the same two vertices once.
[[nodiscard]] io::G2oFile joined(const std::vector<io::G2oFile>& files);

/// Stops only where nothing moves: the tables compare optima to many digits.
[[nodiscard]] graph::GraphSettings to_the_end();

}  // namespace rali::posegraph
