#include "rali/graph/elimination.hpp"

#include <algorithm>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

namespace rali::graph {

namespace {

// Two fronts are merged if zeros are less than this fraction of the result: the cost of small
// fronts is in their number.
constexpr double kZerosMax = 0.2;
constexpr int kSmallFront = 36;  ///< unknowns; such fronts merge with more zeros
constexpr double kZerosMaxSmall = 0.5;

using Lists = std::vector<std::vector<int>>;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<int> minimum_degree(const BlockMatrix& matrix, const std::vector<int>& last) {
  std::vector<int> order;
  std::vector<int> place(at(matrix.variables()), 0);
  for (const int variable : last) place[at(variable)] = -1;
  std::vector<int> free;
  for (int v = 0; v < matrix.variables(); ++v) {
    if (place[at(v)] < 0) continue;
    place[at(v)] = static_cast<int>(free.size());
    free.push_back(v);
  }
  if (!free.empty()) {
    std::vector<Eigen::Triplet<double>> pattern;
    for (const auto& e : matrix.entries()) {
      const int row = place[at(e.row)];
      const int column = place[at(e.column)];
      if (row < 0 || column < 0) continue;
      pattern.emplace_back(row, column, 1.0);
      if (row != column) pattern.emplace_back(column, row, 1.0);
    }
    const auto n = static_cast<int>(free.size());
    Eigen::SparseMatrix<double> graph(n, n);
    graph.setFromTriplets(pattern.begin(), pattern.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
    Eigen::AMDOrdering<int>()(graph, permutation);
    for (int i = 0; i < n; ++i) order.push_back(free[at(permutation.indices()(i))]);
  }
  order.insert(order.end(), last.begin(), last.end());
  return order;
}

// For each position, the later positions coupled to it when it is eliminated, and its parent in the
// elimination tree: the first of them.
struct Fill {
  Lists below;
  std::vector<int> parent;
};

Fill fill_in(Lists adjacent) {
  const int n = static_cast<int>(adjacent.size());
  Fill fill{Lists(at(n)), std::vector<int>(at(n), -1)};
  Lists children(at(n));
  std::vector<int> seen(at(n), -1);
  for (int j = 0; j < n; ++j) {
    std::vector<int>& below = fill.below[at(j)];
    const auto take = [&](const std::vector<int>& from) {
      for (const int row : from) {
        if (row <= j || seen[at(row)] == j) continue;
        seen[at(row)] = j;
        below.push_back(row);
      }
    };
    take(adjacent[at(j)]);
    for (const int child : children[at(j)]) take(fill.below[at(child)]);
    std::sort(below.begin(), below.end());
    if (below.empty()) continue;
    fill.parent[at(j)] = below.front();
    children[at(below.front())].push_back(j);
  }
  return fill;
}

// Children directly before their parents, the highest child last: `last` variables stay last.
std::vector<int> postorder(const std::vector<int>& parent) {
  const int n = static_cast<int>(parent.size());
  Lists children(at(n) + 1);
  for (int j = 0; j < n; ++j) children[at(parent[at(j)] < 0 ? n : parent[at(j)])].push_back(j);
  std::vector<int> order;
  std::vector<std::pair<int, std::size_t>> stack{{n, 0}};
  while (!stack.empty()) {
    auto& [node, next] = stack.back();
    if (next < children[at(node)].size()) {
      const int child = children[at(node)][next++];
      stack.emplace_back(child, 0);
    } else {
      if (node < n) order.push_back(node);
      stack.pop_back();
    }
  }
  return order;
}

Lists adjacency(const BlockMatrix& matrix, const std::vector<int>& position) {
  Lists adjacent(position.size());
  for (const auto& e : matrix.entries()) {
    const int a = position[at(e.row)];
    const int b = position[at(e.column)];
    if (a != b) adjacent[at(std::min(a, b))].push_back(std::max(a, b));
  }
  return adjacent;
}

std::vector<int> inverted(const std::vector<int>& order) {
  std::vector<int> position(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) position[at(order[i])] = static_cast<int>(i);
  return position;
}

// Merges neighbouring positions into fronts.
class FrontBuilder {
 public:
  FrontBuilder(const BlockMatrix& matrix, const std::vector<int>& order, const Fill& fill, int kept)
      : matrix_(matrix), order_(order), fill_(fill), kept_(kept) {}

  std::vector<Supernode> build() {
    const int n = static_cast<int>(order_.size());
    std::vector<Supernode> fronts;
    for (int j = 0; j < n; ++j) {
      if (!fronts.empty() && joins(j)) {
        ++fronts.back().pivots;
        pivots_ += size_of(j);
      } else {
        Supernode front;
        front.first = j;
        front.pivots = 1;
        fronts.push_back(front);
        pivots_ = size_of(j);
        zeros_ = 0;
      }
    }
    for (Supernode& front : fronts) finish(front);
    return fronts;
  }

 private:
  [[nodiscard]] int size_of(int position) const { return matrix_.dim(order_[at(position)]); }

  [[nodiscard]] int below_size(int position) const {
    int size = 0;
    for (const int row : fill_.below[at(position)]) size += size_of(row);
    return size;
  }

  bool joins(int j) {
    const int n = static_cast<int>(order_.size());
    if (j >= n - kept_) return j > n - kept_;  // the kept ones form one front alone
    const int previous = j - 1;
    if (fill_.parent[at(previous)] != j) return false;
    const int height = size_of(j) + below_size(j);
    const int zeros = zeros_ + pivots_ * (height - below_size(previous));
    const int width = pivots_ + size_of(j);
    const int stored = width * (pivots_ + height);
    const double fraction = static_cast<double>(zeros) / stored;
    if (fraction > (pivots_ + height <= kSmallFront ? kZerosMaxSmall : kZerosMax)) return false;
    zeros_ = zeros;
    return true;
  }

  void finish(Supernode& front) const {
    const int last = front.first + front.pivots - 1;
    for (int j = front.first; j <= last; ++j) front.rows.push_back(j);
    const auto& below = fill_.below[at(last)];
    front.rows.insert(front.rows.end(), below.begin(), below.end());
    int offset = 0;
    for (const int row : front.rows) {
      front.offsets.push_back(offset);
      offset += size_of(row);
    }
    front.offsets.push_back(offset);
  }

  const BlockMatrix& matrix_;
  const std::vector<int>& order_;
  const Fill& fill_;
  int kept_ = 0;
  int pivots_ = 0;  ///< unknowns eliminated by the current front
  int zeros_ = 0;   ///< stored zeros of it
};

void link(std::vector<Supernode>& fronts, const std::vector<int>& front_at) {
  for (Supernode& front : fronts) {
    const auto first_below = at(front.pivots);
    if (front.rows.size() == first_below) continue;
    front.parent = front_at[at(front.rows[first_below])];
    const Supernode& parent = fronts[at(front.parent)];
    auto place = parent.rows.begin();
    for (std::size_t r = first_below; r < front.rows.size(); ++r) {
      place = std::lower_bound(place, parent.rows.end(), front.rows[r]);
      front.offsets_in_parent.push_back(
          parent.offsets[at(static_cast<int>(place - parent.rows.begin()))]);
    }
  }
}

}  // namespace

Elimination::Elimination(const BlockMatrix& matrix, const std::vector<int>& last, bool keep_last) {
  const int n = matrix.variables();
  const int kept = keep_last ? static_cast<int>(last.size()) : 0;
  for (int v = 0; v < n; ++v) {
    unknowns.push_back(size);
    size += matrix.dim(v);
  }
  const std::vector<int> degree_order = minimum_degree(matrix, last);
  Lists adjacent = adjacency(matrix, inverted(degree_order));
  for (int a = n - kept; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) adjacent[at(a)].push_back(b);
  }
  const Fill first_fill = fill_in(std::move(adjacent));
  const std::vector<int> post = postorder(first_fill.parent);
  for (const int p : post) order.push_back(degree_order[at(p)]);
  position = inverted(order);
  // The same fill, in the new numbering.
  const std::vector<int> renumbered = inverted(post);
  Fill fill{Lists(at(n)), std::vector<int>(at(n), -1)};
  for (int j = 0; j < n; ++j) {
    const int old = post[at(j)];
    for (const int row : first_fill.below[at(old)])
      fill.below[at(j)].push_back(renumbered[at(row)]);
    std::sort(fill.below[at(j)].begin(), fill.below[at(j)].end());
    if (first_fill.parent[at(old)] >= 0)
      fill.parent[at(j)] = renumbered[at(first_fill.parent[at(old)])];
  }
  supernodes = FrontBuilder(matrix, order, fill, kept).build();
  supernode_at.assign(at(n), 0);
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    for (int p = 0; p < supernodes[s].pivots; ++p) {
      supernode_at[at(supernodes[s].first + p)] = static_cast<int>(s);
    }
  }
  link(supernodes, supernode_at);
}

}  // namespace rali::graph
