#include "rali/graph/window.hpp"

#include <algorithm>

#include "rali/base/assert.hpp"

namespace rali::graph {

int rank(const RelativeTerm& term) {
  // information_root leaves a row of zeros for a direction without information.
  return static_cast<int>((term.root.rowwise().squaredNorm().array() > 0.0).count());
}

int Window::find(Seq seq) const {
  // Without gaps in seq the index is known; otherwise it is searched.
  if (!keyframes.empty() && seq >= keyframes.front().seq) {
    const std::size_t guess = seq - keyframes.front().seq;
    if (guess < keyframes.size() && keyframes[guess].seq == seq) return static_cast<int>(guess);
  }
  const auto it = std::lower_bound(keyframes.begin(), keyframes.end(), seq,
                                   [](const KeyframeNode& k, Seq s) { return k.seq < s; });
  return it == keyframes.end() || it->seq != seq ? -1 : static_cast<int>(it - keyframes.begin());
}

int Window::find(GlobalId id) const {
  const auto it = std::lower_bound(globals.begin(), globals.end(), id,
                                   [](const GlobalNode& g, GlobalId i) { return g.id < i; });
  return it == globals.end() || it->id != id ? -1 : static_cast<int>(it - globals.begin());
}

const KeyframeNode& Window::node(Seq seq) const {
  const int k = find(seq);
  RALI_ASSERT(k >= 0);
  return keyframes[static_cast<std::size_t>(k)];
}

int Window::column(Seq seq) const {
  const int k = find(seq);
  RALI_ASSERT(k >= 0);
  RALI_ASSERT(!keyframe_column_.empty());  // not laid out
  const auto at = static_cast<std::size_t>(k);
  return keyframes[at].fixed ? -1 : keyframe_column_[at];
}

int Window::column(GlobalId id) const {
  const int place = find(id);
  RALI_ASSERT(place >= 0 && !global_column_.empty());
  return global_column_[static_cast<std::size_t>(place)];
}

int Window::columns() const {
  RALI_ASSERT(!global_column_.empty());
  return global_column_.back();
}

void Window::lay_out() {
  keyframe_column_.assign(1, 0);
  for (const KeyframeNode& keyframe : keyframes) {
    keyframe_column_.push_back(keyframe_column_.back() + (keyframe.fixed ? 0 : keyframe.dim));
  }
  global_column_.assign(1, keyframe_column_.back());
  for (const GlobalNode& global : globals) {
    global_column_.push_back(global_column_.back() + global.dim());
  }
}

void Window::move(const Eigen::VectorXd& delta) {
  int column = 0;
  for (KeyframeNode& keyframe : keyframes) {
    if (keyframe.fixed) continue;
    StateVec own = StateVec::Zero();
    own.head(keyframe.dim) = delta.segment(column, keyframe.dim);
    keyframe.x = boxplus(keyframe.x, own);
    column += keyframe.dim;
  }
  for (GlobalNode& global : globals) {
    global.value.head(global.dim()) += delta.segment(column, global.dim());
    column += global.dim();
  }
}

}  // namespace rali::graph
