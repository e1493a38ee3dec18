#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/wire/messages.hpp"

namespace rali::drive {

/// Fixed transforms of /tf_static. Later ones replace earlier ones with the same child.
class TfTree {
 public:
  void add(const wire::TransformStamped& transform);

  /// T_a_b along the tree; empty if the frames are not connected. A leading '/' of old tf names is
  /// ignored.
  [[nodiscard]] std::optional<geometry::SE3> find(const std::string& a, const std::string& b) const;

  [[nodiscard]] bool empty() const { return edges_.empty(); }

 private:
  struct Edge {
    std::string parent, child;
    geometry::SE3 T_parent_child;
  };

  [[nodiscard]] std::vector<const Edge*> to_root(const std::string& frame) const;

  std::vector<Edge> edges_;
};

}  // namespace rali::drive
