#include "rali/graph/window.hpp"

#include <algorithm>

#include "rali/base/assert.hpp"

namespace rali::graph {

int Window::find(Seq seq) const {
  const auto it = std::lower_bound(keyframes.begin(), keyframes.end(), seq,
                                   [](const KeyframeNode& k, Seq s) { return k.seq < s; });
  return it == keyframes.end() || it->seq != seq ? -1 : static_cast<int>(it - keyframes.begin());
}

int Window::find(GlobalId id) const {
  const auto it = std::lower_bound(globals.begin(), globals.end(), id,
                                   [](const GlobalNode& g, GlobalId i) { return g.id < i; });
  return it == globals.end() || it->id != id ? -1 : static_cast<int>(it - globals.begin());
}

int Window::column(Seq seq) const {
  const int k = find(seq);
  RALI_ASSERT(k >= 0);
  return kStateDim * k;
}

int Window::column(GlobalId id) const {
  const int place = find(id);
  RALI_ASSERT(place >= 0);
  int column = keyframe_columns();
  for (int g = 0; g < place; ++g) column += globals[static_cast<std::size_t>(g)].dim();
  return column;
}

int Window::keyframe_columns() const { return kStateDim * static_cast<int>(keyframes.size()); }

int Window::columns() const {
  int columns = keyframe_columns();
  for (const GlobalNode& global : globals) columns += global.dim();
  return columns;
}

void Window::move(const Eigen::VectorXd& delta) {
  int column = 0;
  for (KeyframeNode& keyframe : keyframes) {
    keyframe.x = boxplus(keyframe.x, delta.segment<kStateDim>(column));
    column += kStateDim;
  }
  for (GlobalNode& global : globals) {
    global.value.head(global.dim()) += delta.segment(column, global.dim());
    column += global.dim();
  }
}

}  // namespace rali::graph
