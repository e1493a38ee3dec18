#include "rali/graph/marginalise.hpp"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "rali/base/assert.hpp"
#include "rali/graph/normal_equations.hpp"

namespace rali::graph {

namespace {

constexpr double kDropEigenvalue = 1e-9;

// Unknowns have different units: eigenvalues are comparable only after scaling by the diagonal.
struct ScaledEigen {
  Eigen::VectorXd unscale;  ///< 1/sqrt(H_ii), 0 where there is no information
  Eigen::VectorXd values;   ///< dropped ones are 0
  Eigen::MatrixXd vectors;

  explicit ScaledEigen(const Eigen::MatrixXd& H) {
    unscale = H.diagonal().unaryExpr([](double v) { return v > 0.0 ? 1.0 / std::sqrt(v) : 0.0; });
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        Eigen::MatrixXd(unscale.asDiagonal() * H * unscale.asDiagonal()));
    const double minimum = kDropEigenvalue * eigen.eigenvalues().maxCoeff();
    values = eigen.eigenvalues().unaryExpr([minimum](double v) { return v > minimum ? v : 0.0; });
    vectors = eigen.eigenvectors();
  }
};

class Marginalisation {
 public:
  Marginalisation(Window& window, const std::vector<Seq>& nodes) : window_(window), leave_(nodes) {
    RALI_ASSERT(std::is_sorted(nodes.begin(), nodes.end()));
    split();
    collect_globals();
    collect_nodes();
  }

  void run(double huber_sd) {
    part_.lay_out();
    std::vector<int> kept;
    DensePrior prior = blocks(kept);
    Quadratic left = eliminate(kept, huber_sd);
    drop_rounding(left);
    prior.H = std::move(left.H);
    prior.b = std::move(left.b);
    prior.cost = left.cost;
    window_.dense = std::move(prior);
    remove();
  }

 private:
  [[nodiscard]] bool leaves(Seq seq) const {
    return std::binary_search(leave_.begin(), leave_.end(), seq);
  }

  void touch(Seq seq) { touched_.push_back(seq); }

  // Moves the terms of a leaving node to the part. `nodes_of` calls its argument with each of a
  // term's nodes.
  template <class Term, class NodesOf>
  void split(std::vector<Term>& from, std::vector<Term>& to, const NodesOf& nodes_of) {
    std::vector<Term> stay;
    for (const Term& term : from) {
      bool any = false;
      nodes_of(term, [&](Seq seq) { any = any || leaves(seq); });
      if (!any) {
        stay.push_back(term);
        continue;
      }
      nodes_of(term, [&](Seq seq) { touch(seq); });
      to.push_back(term);
    }
    from = std::move(stay);
  }

  void split() {
    const auto pair = [](const auto& term, const auto& use) {
      use(term.f.i);
      use(term.f.j);
    };
    std::erase_if(window_.loops, [&](const LoopTerm& loop) {
      return loop.weight == 0.0 && (leaves(loop.term.f.i) || leaves(loop.term.f.j));
    });
    split(window_.inertial, part_.inertial, pair);
    split(window_.relative, part_.relative, pair);
    split(window_.loops, part_.loops,
          [&](const LoopTerm& loop, const auto& use) { pair(loop.term, use); });
    split(window_.ranges, part_.ranges, [](const RangeFactor& f, const auto& use) {
      for (const RangeEnd* end :
           {static_cast<const RangeEnd*>(&f), f.other ? &*f.other : nullptr}) {
        if (end == nullptr) continue;
        use(end->i);
        if (end->j) use(*end->j);
      }
    });
    split(window_.standstill, part_.standstill, [](const StandstillFactor& f, const auto& use) {
      use(f.i);
      if (f.next) use(*f.next);
    });
    split(window_.gravity, part_.gravity,
          [](const GravityFactor& f, const auto& use) { use(f.i); });
    split(window_.priors, part_.priors,
          [](const PriorTerm& term, const auto& use) { use(term.f.i); });
    part_.dense = window_.dense;
    for (const auto& block : part_.dense.keyframes) touch(block.seq);
  }

  static bool uses(const RangeFactor& f, GlobalId id) {
    const std::optional<int>& used = id.kind == GlobalKind::kLandmark ? f.landmark
                                     : id.kind == GlobalKind::kBias   ? f.bias
                                                                      : f.tau;
    return used && *used == id.number;
  }

  // A global in the dense prior has all its prior information there.
  void collect_globals() {
    for (GlobalNode& global : window_.globals) {
      const auto used = [&](const RangeFactor& f) { return uses(f, global.id); };
      const auto blocked = [&](const auto& block) { return block.id == global.id; };
      const bool in_part =
          std::any_of(part_.ranges.begin(), part_.ranges.end(), used) ||
          std::any_of(part_.dense.globals.begin(), part_.dense.globals.end(), blocked);
      if (!in_part) continue;
      part_.globals.push_back(global);
      global.prior_information.setZero();
    }
  }

  void collect_nodes() {
    for (const Seq seq : leave_) touch(seq);
    std::sort(touched_.begin(), touched_.end());
    touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    for (const Seq seq : touched_) part_.keyframes.push_back(window_.node(seq));
  }

  // Blocks of the new prior at the present values, and their variables.
  DensePrior blocks(std::vector<int>& kept) const {
    DensePrior prior;
    int variable = 0;
    for (const KeyframeNode& node : part_.keyframes) {
      if (node.fixed) continue;
      if (!leaves(node.seq)) {
        prior.keyframes.push_back({node.seq, node.x});
        kept.push_back(variable);
      }
      ++variable;
    }
    for (const GlobalNode& global : part_.globals) {
      prior.globals.push_back({global.id, global.value});
      kept.push_back(variable++);
    }
    return prior;
  }

  [[nodiscard]] Quadratic eliminate(const std::vector<int>& kept, double huber_sd) const {
    if (kept.empty()) return {};
    NormalEquations equations(part_, huber_sd, kept);
    // The floor prevents a zero pivot in an unobservable direction. Such a direction is not coupled
    // to the others, so the error from squared rounding over the floor is negligible.
    const bool done = factorise_with_floor(equations);
    RALI_ASSERT(done);
    const BlockCholesky& cholesky = equations.cholesky();
    const Eigen::VectorXd reduced = cholesky.reduce(equations.gradient());
    const Eigen::Index n = cholesky.schur().rows();
    return {cholesky.schur(), reduced.tail(n),
            equations.cost() - 0.5 * reduced.head(reduced.size() - n).squaredNorm()};
  }

  void remove() {
    std::erase_if(window_.keyframes, [this](const KeyframeNode& node) { return leaves(node.seq); });
    window_.lay_out();
  }

  Window& window_;
  const std::vector<Seq>& leave_;
  Window part_;  ///< nodes and factors that become the prior
  std::vector<Seq> touched_;
};

}  // namespace

void marginalise(Window& window, const std::vector<Seq>& nodes, double huber_sd) {
  if (nodes.empty()) return;
  Marginalisation(window, nodes).run(huber_sd);
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

}  // namespace rali::graph
