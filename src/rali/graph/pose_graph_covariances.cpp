// Covariances and predictions of PoseGraph.
#include <numeric>

#include "rali/base/assert.hpp"
#include "rali/graph/pose_graph.hpp"

namespace rali::graph {

namespace {

using geometry::Mat6;

const GlobalNode& value(const Window& window, GlobalId id) {
  const int g = window.find(id);
  RALI_ASSERT(g >= 0);
  return window.globals[static_cast<std::size_t>(g)];
}

}  // namespace

Marginals& PoseGraph::marginals() {
  if (!marginals_) marginals_ = std::make_unique<Marginals>(window(), settings_.huber_sd);
  return *marginals_;
}

std::vector<int> PoseGraph::pose_columns(Seq seq) const {
  const int first = window().column(seq);
  std::vector<int> columns(first < 0 ? 0 : kPoseDim);
  std::iota(columns.begin(), columns.end(), first);
  return columns;
}

Mat6 PoseGraph::covariance(Seq seq) {
  const std::vector<int> columns = pose_columns(seq);
  return columns.empty() ? Mat6(Mat6::Zero()) : Mat6(marginals().covariance(columns));
}

std::vector<Mat6> PoseGraph::covariances() {
  std::vector<Mat6> all;
  for (const KeyframeNode& node : window().keyframes) {
    all.push_back(Mat6::Zero());
    if (node.fixed) continue;
    const int column = window().column(node.seq);
    all.back() = marginals().own(column).topLeftCorner<kPoseDim, kPoseDim>();
  }
  return all;
}

Eigen::Matrix<double, 12, 12> PoseGraph::covariance(Seq a, Seq b) {
  RALI_ASSERT(a != b);
  const std::vector<int> of_a = pose_columns(a), of_b = pose_columns(b);
  Eigen::Matrix<double, 12, 12> P = Eigen::Matrix<double, 12, 12>::Zero();
  // A fixed node has no columns; its part stays zero.
  const auto own = [this](int column) { return marginals().own(column).topLeftCorner<6, 6>(); };
  if (!of_a.empty()) P.topLeftCorner<6, 6>() = own(of_a.front());
  if (!of_b.empty()) P.bottomRightCorner<6, 6>() = own(of_b.front());
  if (of_a.empty() || of_b.empty()) return P;
  P.topRightCorner<6, 6>() = marginals().between(of_a.front(), of_b).topRows<6>();
  P.bottomLeftCorner<6, 6>() = P.topRightCorner<6, 6>().transpose();
  return P;
}

LandmarkEstimate PoseGraph::landmark(int number) {
  const GlobalId id = landmark_id(number);
  const int column = window().column(id);
  return {value(window(), id).value, marginals().covariance({column, column + 1, column + 2})};
}

ScalarEstimate PoseGraph::scalar(GlobalId id) {
  const int column = window().column(id);
  return {value(window(), id).value.x(), marginals().covariance(std::vector<int>{column})(0, 0)};
}

ScalarEstimate PoseGraph::bias(int number) { return scalar(bias_id(number)); }

ScalarEstimate PoseGraph::tau(int number) { return scalar(tau_id(number)); }

double PoseGraph::residual(const RangeFactor& factor) const {
  LinearFactor row;
  range_residual(window(), factor, row);
  return row.r(0);
}

RangePrediction PoseGraph::predict(const RangeFactor& factor) {
  LinearFactor row;
  range_residual(window(), factor, row);
  return {row.r(0) + factor.range_m, marginals().covariance(row)(0, 0)};
}

std::vector<LoopVerdict> PoseGraph::judge(const std::vector<RelativePoseFactor>& candidates,
                                          Executor& executor) const {
  return judge_loops(window(), settings_, candidates, executor, stop_);
}

}  // namespace rali::graph
