#pragma once

#include <string>

#include "rali/graph/pose_graph.hpp"
#include "rali/io/files/graph_files.hpp"

namespace rali::posegraph {

/// Initial values of the poses.
enum class Start {
  kFile,      ///< vertices of the file; those without a pose by chaining edges
  kOdometry,  ///< chained edges from vertex to next vertex, only the first from the file
};

/// Poses of all vertices by chaining edges from initialised vertices, in the order of the edges.
[[nodiscard]] std::vector<geometry::SE3> chained(const io::G2oFile& file);

/// One node per vertex, in their order, the first one fixed; one relative pose per edge.
[[nodiscard]] graph::PoseGraph make_graph(const io::G2oFile& file, Start start,
                                          const graph::GraphSettings& settings);

/// Several files merged: vertices by id, an edge between the same two vertices once.
[[nodiscard]] io::G2oFile joined(const std::vector<io::G2oFile>& files);

/// Stops only at full convergence: the tables compare optima to many digits.
[[nodiscard]] graph::GraphSettings to_the_end();

}  // namespace rali::posegraph
