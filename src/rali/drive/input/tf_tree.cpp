#include "rali/drive/input/tf_tree.hpp"

#include <algorithm>

namespace rali::drive {
namespace {

/// No sensor frame of a vehicle is deeper; also prevents endless loops in a damaged tree.
constexpr std::size_t kDepth = 64;
constexpr std::size_t kEdges = 4096;

std::string plain(const std::string& frame) {
  return frame.starts_with('/') ? frame.substr(1) : frame;
}

}  // namespace

void TfTree::add(const wire::TransformStamped& transform) {
  Edge edge{plain(transform.frame_id), plain(transform.child_frame_id), transform.T_frame_child};
  if (edge.child.empty() || edge.parent.empty() || edge.child == edge.parent) return;
  const auto same = std::find_if(edges_.begin(), edges_.end(),
                                 [&](const Edge& e) { return e.child == edge.child; });
  if (same != edges_.end()) {
    *same = std::move(edge);
  } else if (edges_.size() < kEdges) {
    edges_.push_back(std::move(edge));
  }
}

std::vector<const TfTree::Edge*> TfTree::to_root(const std::string& frame) const {
  std::vector<const Edge*> path;
  std::string at = frame;
  while (path.size() < kDepth) {
    const auto edge =
        std::find_if(edges_.begin(), edges_.end(), [&](const Edge& e) { return e.child == at; });
    if (edge == edges_.end()) break;
    path.push_back(&*edge);
    at = edge->parent;
  }
  return path;
}

std::optional<geometry::SE3> TfTree::find(const std::string& a, const std::string& b) const {
  const std::string from = plain(a), to = plain(b);
  if (from.empty() || to.empty()) return std::nullopt;
  if (from == to) return geometry::SE3{};
  const std::vector<const Edge*> up_a = to_root(from), up_b = to_root(to);
  const std::string root_a = up_a.empty() ? from : up_a.back()->parent;
  const std::string root_b = up_b.empty() ? to : up_b.back()->parent;
  if (root_a != root_b) return std::nullopt;
  geometry::SE3 T_root_a, T_root_b;
  for (const Edge* edge : up_a) T_root_a = edge->T_parent_child * T_root_a;
  for (const Edge* edge : up_b) T_root_b = edge->T_parent_child * T_root_b;
  return T_root_a.inverse() * T_root_b;
}

}  // namespace rali::drive
