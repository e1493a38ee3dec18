#include "problem.hpp"

#include <map>
#include <set>

namespace rali::posegraph {

std::vector<geometry::SE3> chained(const io::G2oFile& file) {
  std::vector<geometry::SE3> poses;
  for (const io::GraphVertex& vertex : file.graph.vertices) poses.push_back(vertex.T);
  std::vector<bool> known = file.placed;
  if (!poses.empty()) known[0] = true;
  std::vector<std::vector<std::size_t>> edges_of(poses.size());
  for (std::size_t e = 0; e < file.graph.edges.size(); ++e) {
    edges_of[file.graph.edges[e].from].push_back(e);
    edges_of[file.graph.edges[e].to].push_back(e);
  }
  // Depth first, first edge first: on a path the edges to the next vertex precede loop closures.
  std::vector<std::size_t> stack;
  for (std::size_t v = poses.size(); v-- > 0;) {
    if (known[v]) stack.push_back(v);
  }
  while (!stack.empty()) {
    const std::size_t v = stack.back();
    stack.pop_back();
    for (auto e = edges_of[v].rbegin(); e != edges_of[v].rend(); ++e) {
      const io::GraphEdge& edge = file.graph.edges[*e];
      const std::size_t other = edge.from == v ? edge.to : edge.from;
      if (known[other]) continue;
      poses[other] = poses[v] * (edge.from == v ? edge.T_from_to : edge.T_from_to.inverse());
      known[other] = true;
      stack.push_back(other);
    }
  }
  return poses;
}

graph::PoseGraph make_graph(const io::G2oFile& file, Start start,
                            const graph::GraphSettings& settings) {
  io::G2oFile from = file;
  if (start == Start::kOdometry) {
    // Along the path only: an edge is used if it leads to the next id.
    from.placed.assign(from.placed.size(), false);
    std::erase_if(from.graph.edges, [&](const io::GraphEdge& edge) {
      return from.ids[edge.to] - from.ids[edge.from] != 1;
    });
  }
  graph::PoseGraph graph(settings);
  for (const geometry::SE3& pose : chained(from)) graph.add_pose(pose);
  graph.fix(0);
  for (const io::GraphEdge& edge : file.graph.edges) {
    graph.add(graph::RelativePoseFactor{static_cast<graph::Seq>(edge.from),
                                        static_cast<graph::Seq>(edge.to), edge.T_from_to,
                                        edge.information});
  }
  return graph;
}

io::G2oFile joined(const std::vector<io::G2oFile>& files) {
  io::G2oFile all;
  std::map<std::int64_t, std::size_t> index;
  std::set<std::pair<std::size_t, std::size_t>> there;
  for (const io::G2oFile& file : files) {
    for (std::size_t v = 0; v < file.ids.size(); ++v) {
      const auto [place, is_new] = index.emplace(file.ids[v], all.ids.size());
      if (is_new) {
        all.ids.push_back(file.ids[v]);
        all.placed.push_back(false);
        all.graph.vertices.emplace_back();
      }
      if (!file.placed[v]) continue;
      all.placed[place->second] = true;
      all.graph.vertices[place->second] = file.graph.vertices[v];
    }
    for (io::GraphEdge edge : file.graph.edges) {
      edge.from = index.at(file.ids[edge.from]);
      edge.to = index.at(file.ids[edge.to]);
      if (there.emplace(edge.from, edge.to).second) all.graph.edges.push_back(edge);
    }
  }
  return all;
}

graph::GraphSettings to_the_end() {
  graph::GraphSettings settings;
  settings.iterations = 100;
  settings.cost_change_min = 1e-9;
  settings.step_min_m = 1e-7;
  return settings;
}

}  // namespace rali::posegraph
