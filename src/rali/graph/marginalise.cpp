#include "rali/graph/marginalise.hpp"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "rali/base/assert.hpp"
#include "rali/graph/linearise.hpp"

namespace rali::graph {

namespace {

constexpr double kDropEigenvalue = 1e-9;

// Unknowns have different units: only in units of their own information do eigenvalues compare.
struct ScaledEigen {
  Eigen::VectorXd unscale;  ///< 1/sqrt(H_ii), 0 where there is no information
  Eigen::VectorXd values;   ///< dropped ones are 0
  Eigen::MatrixXd vectors;

  explicit ScaledEigen(const Eigen::MatrixXd& H) {
    unscale = H.diagonal().unaryExpr([](double v) { return v > 0.0 ? 1.0 / std::sqrt(v) : 0.0; });
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(unscale.asDiagonal() * H *
                                                               unscale.asDiagonal());
    const double least = kDropEigenvalue * eigen.eigenvalues().maxCoeff();
    values = eigen.eigenvalues().unaryExpr([least](double v) { return v > least ? v : 0.0; });
    vectors = eigen.eigenvectors();
  }

  // H^-1 without the dropped directions.
  [[nodiscard]] Eigen::MatrixXd inverse() const {
    const Eigen::VectorXd inverted =
        values.unaryExpr([](double v) { return v > 0.0 ? 1.0 / v : 0.0; });
    return unscale.asDiagonal() * vectors * inverted.asDiagonal() * vectors.transpose() *
           unscale.asDiagonal();
  }
};

// Which unknowns of the window go into the new prior, and where.
class LocalOrder {
 public:
  LocalOrder(const Window& window, const std::vector<bool>& eliminated,
             const std::vector<bool>& touched)
      : place_(static_cast<std::size_t>(window.columns()), -1) {
    for (const bool first : {true, false}) {
      int column = 0;
      const auto unknown = [&](int dim) {
        const auto at = static_cast<std::size_t>(column);
        if (touched[at] && eliminated[at] == first) {
          for (int d = 0; d < dim; ++d) place_[at + static_cast<std::size_t>(d)] = size_++;
          if (first) eliminated_size_ = size_;
        }
        column += dim;
      };
      for (std::size_t k = 0; k < window.keyframes.size(); ++k) unknown(kStateDim);
      for (const GlobalNode& global : window.globals) unknown(global.dim());
    }
  }

  [[nodiscard]] int place(int column) const { return place_[static_cast<std::size_t>(column)]; }

  [[nodiscard]] int size() const { return size_; }

  [[nodiscard]] int eliminated() const { return eliminated_size_; }

 private:
  std::vector<int> place_;
  int size_ = 0;
  int eliminated_size_ = 0;
};

bool touches(const LinearFactor& factor, const std::vector<bool>& marked) {
  for (int b = 0; b < factor.block_count; ++b) {
    const auto& block = factor.blocks[static_cast<std::size_t>(b)];
    if (marked[static_cast<std::size_t>(block.column)]) return true;
  }
  return false;
}

void mark(int column, std::vector<bool>& marked) {
  marked[static_cast<std::size_t>(column)] = true;
}

bool range_touches(const RangeFactor& f, Seq seq) { return f.i == seq || (f.j && *f.j == seq); }

bool range_uses(const RangeFactor& f, GlobalId id) {
  const std::optional<int>& used = id.kind == GlobalKind::kLandmark ? f.landmark
                                   : id.kind == GlobalKind::kBias   ? f.bias
                                                                    : f.tau;
  return used && *used == id.number;
}

// First columns of the unknowns that leave: the oldest keyframe and retired globals without use.
std::vector<bool> leaving(const Window& window) {
  std::vector<bool> out(static_cast<std::size_t>(window.columns()), false);
  const Seq oldest = window.keyframes.front().seq;
  mark(0, out);
  for (const GlobalNode& global : window.globals) {
    const bool needed =
        std::any_of(window.ranges.begin(), window.ranges.end(), [&](const RangeFactor& f) {
          return range_uses(f, global.id) && !range_touches(f, oldest);
        });
    if (global.retired && !needed) mark(window.column(global.id), out);
  }
  return out;
}

void add(const LinearFactor& factor, const LocalOrder& order, Quadratic& sum) {
  sum.cost += factor.cost;
  for (int a = 0; a < factor.block_count; ++a) {
    const auto& A = factor.blocks[static_cast<std::size_t>(a)];
    const int pa = order.place(A.column);
    const auto Ja = factor.J.middleCols(A.local, A.dim);
    sum.b.segment(pa, A.dim) += Ja.transpose() * factor.r;
    for (int b = 0; b < factor.block_count; ++b) {
      const auto& B = factor.blocks[static_cast<std::size_t>(b)];
      sum.H.block(pa, order.place(B.column), A.dim, B.dim) +=
          Ja.transpose() * factor.J.middleCols(B.local, B.dim);
    }
  }
}

void add(const LinearPrior& prior, const LocalOrder& order, Quadratic& sum) {
  sum.cost += prior.cost;
  for (const auto& A : prior.blocks) {
    const int pa = order.place(A.column);
    sum.b.segment(pa, A.dim) += prior.gradient.segment(A.local, A.dim);
    for (const auto& B : prior.blocks) {
      sum.H.block(pa, order.place(B.column), A.dim, B.dim) +=
          prior.H.block(A.local, B.local, A.dim, B.dim);
    }
  }
}

// Factors that touch what leaves, and the own priors of the globals those factors speak of: as
// soon as a global is in the dense prior, all that is known of it is there.
std::vector<LinearFactor> factors_of(const Window& window, double huber_sd,
                                     const std::vector<bool>& out, std::vector<bool>& touched) {
  std::vector<LinearFactor> factors;
  touched = out;
  const auto keep = [&](const LinearFactor& factor) {
    factors.push_back(factor);
    for (int b = 0; b < factor.block_count; ++b) {
      mark(factor.blocks[static_cast<std::size_t>(b)].column, touched);
    }
  };
  for_each_factor(window, huber_sd, [&](const LinearFactor& factor) {
    const bool unary_global =
        factor.block_count == 1 && factor.blocks[0].column >= window.keyframe_columns();
    if (!unary_global && touches(factor, out)) keep(factor);
  });
  for (const auto& block : window.dense.keyframes) mark(window.column(block.seq), touched);
  for (const auto& block : window.dense.globals) mark(window.column(block.id), touched);
  LinearFactor factor;
  for (const GlobalNode& global : window.globals) {
    linearise(window, global, factor);
    if (touches(factor, touched)) factors.push_back(factor);
  }
  return factors;
}

// Takes the unknowns and factors that are in the prior now out of the window.
void remove_leaving(Window& window, const std::vector<bool>& out,
                    const std::vector<bool>& touched) {
  const Seq oldest = window.keyframes.front().seq;
  std::vector<GlobalNode> globals;
  for (GlobalNode global : window.globals) {
    const auto at = static_cast<std::size_t>(window.column(global.id));
    if (out[at]) continue;
    if (touched[at]) global.prior_information.setZero();
    globals.push_back(global);
  }
  window.globals = std::move(globals);
  const auto drop_pair = [oldest](const auto& term) {
    return term.f.i == oldest || term.f.j == oldest;
  };
  std::erase_if(window.inertial, drop_pair);
  std::erase_if(window.relative, drop_pair);
  std::erase_if(window.ranges, [oldest](const RangeFactor& f) { return range_touches(f, oldest); });
  std::erase_if(window.standstill, [oldest](const StandstillFactor& f) {
    return f.i == oldest || (f.next && *f.next == oldest);
  });
  std::erase_if(window.heights, [oldest](const HeightFactor& f) { return f.i == oldest; });
  std::erase_if(window.priors, [oldest](const PriorTerm& term) { return term.f.i == oldest; });
  window.keyframes.erase(window.keyframes.begin());
}

// The blocks of the new prior, at the present values, in the order of the window.
DensePrior blocks_at_present(const Window& window, const std::vector<bool>& out,
                             const std::vector<bool>& touched) {
  DensePrior prior;
  for (const KeyframeNode& keyframe : window.keyframes) {
    const auto at = static_cast<std::size_t>(window.column(keyframe.seq));
    if (touched[at] && !out[at]) prior.keyframes.push_back({keyframe.seq, keyframe.x});
  }
  for (const GlobalNode& global : window.globals) {
    const auto at = static_cast<std::size_t>(window.column(global.id));
    if (touched[at] && !out[at]) prior.globals.push_back({global.id, global.value});
  }
  return prior;
}

}  // namespace

Quadratic eliminate_first(const Quadratic& in, int m) {
  const auto r = in.H.rows() - m;
  const ScaledEigen eigen(in.H.topLeftCorner(m, m));
  const Eigen::MatrixXd gain = in.H.bottomLeftCorner(r, m) * eigen.inverse();
  Quadratic out;
  out.H = in.H.bottomRightCorner(r, r) - gain * in.H.topRightCorner(m, r);
  out.H = 0.5 * (out.H + out.H.transpose()).eval();
  out.b = in.b.tail(r) - gain * in.b.head(m);
  out.cost = in.cost - 0.5 * in.b.head(m).dot(eigen.inverse() * in.b.head(m));
  return out;
}

void drop_rounding(Quadratic& quadratic) {
  if (quadratic.H.rows() == 0) return;
  const ScaledEigen eigen(quadratic.H);
  const Eigen::VectorXd scale =
      eigen.unscale.unaryExpr([](double u) { return u > 0.0 ? 1.0 / u : 0.0; });
  const Eigen::VectorXd kept = eigen.values.unaryExpr([](double v) { return v > 0.0 ? 1.0 : 0.0; });
  const Eigen::MatrixXd V = scale.asDiagonal() * eigen.vectors;
  quadratic.H = V * eigen.values.asDiagonal() * V.transpose();
  quadratic.b =
      V * kept.cwiseProduct(eigen.vectors.transpose() * eigen.unscale.cwiseProduct(quadratic.b));
}

void marginalise_oldest(Window& window, double huber_sd) {
  RALI_ASSERT(window.keyframes.size() >= 2);
  const std::vector<bool> out = leaving(window);
  std::vector<bool> touched;
  const std::vector<LinearFactor> factors = factors_of(window, huber_sd, out, touched);
  const LocalOrder order(window, out, touched);
  Quadratic sum{Eigen::MatrixXd::Zero(order.size(), order.size()),
                Eigen::VectorXd::Zero(order.size()), 0.0};
  for (const LinearFactor& factor : factors) add(factor, order, sum);
  if (window.dense.H.rows() > 0) add(linearise(window, window.dense), order, sum);
  Quadratic left = eliminate_first(sum, order.eliminated());
  drop_rounding(left);

  DensePrior prior = blocks_at_present(window, out, touched);
  prior.H = std::move(left.H);
  prior.b = std::move(left.b);
  prior.cost = left.cost;
  remove_leaving(window, out, touched);
  window.dense = std::move(prior);
}

void relax(Window& window, GlobalId id, double variance) {
  RALI_ASSERT(variance >= 0.0 && std::isfinite(variance));
  const int g = window.find(id);
  RALI_ASSERT(g >= 0);
  if (variance == 0.0) return;
  const int dim = dimension(id.kind);
  GlobalNode& global = window.globals[static_cast<std::size_t>(g)];
  // With x_new = x_old + w, w of variance q, x_old is minimised out: H -> H - H E S^-1 E^T H with
  // S = 1/q + E^T H E. The own prior is the case H = E^T H E.
  const auto less = [variance](const Eigen::MatrixXd& H_xx) -> Eigen::MatrixXd {
    const auto n = H_xx.rows();
    return (Eigen::MatrixXd::Identity(n, n) / variance + H_xx).inverse();
  };
  Eigen::MatrixXd own = global.prior_information.topLeftCorner(dim, dim);
  own -= own * less(own) * own;
  global.prior_information.topLeftCorner(dim, dim) = own;
  DensePrior& prior = window.dense;
  Eigen::Index at = 0;
  for (const auto& block : prior.keyframes) at += window.node(block.seq).dim;
  for (const auto& block : prior.globals) {
    if (block.id == id) {
      const Eigen::MatrixXd HE = prior.H.middleCols(at, dim);
      const Eigen::MatrixXd S = less(prior.H.block(at, at, dim, dim));
      const Eigen::VectorXd b = prior.b.segment(at, dim);
      prior.H -= HE * S * HE.transpose();
      prior.b -= HE * (S * b);
      prior.cost -= 0.5 * b.dot(S * b);
      return;
    }
    at += dimension(block.id.kind);
  }
}

}  // namespace rali::graph
