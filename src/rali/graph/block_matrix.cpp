#include "rali/graph/block_matrix.hpp"

#include <algorithm>

#include "rali/base/assert.hpp"

namespace rali::graph {

BlockMatrix::BlockMatrix(std::vector<int> dims, const std::vector<std::pair<int, int>>& pairs)
    : dims_(std::move(dims)) {
  std::vector<std::pair<int, int>> places;  // (column, row)
  places.reserve(pairs.size() + dims_.size());
  for (int v = 0; v < variables(); ++v) places.emplace_back(v, v);
  for (const auto& [a, b] : pairs) places.emplace_back(std::min(a, b), std::max(a, b));
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  begins_.assign(dims_.size() + 1, 0);
  int offset = 0;
  for (const auto& [column, row] : places) {
    RALI_ASSERT(column >= 0 && row < variables());
    entries_.push_back({row, column, offset});
    offset += dim(row) * dim(column);
    ++begins_[static_cast<std::size_t>(column) + 1];
  }
  for (std::size_t v = 0; v < dims_.size(); ++v) begins_[v + 1] += begins_[v];
  values_.assign(static_cast<std::size_t>(offset), 0.0);
}

BlockMatrix::Block BlockMatrix::block(int row, int column) {
  const auto first =
      entries_.begin() + static_cast<std::ptrdiff_t>(begins_[static_cast<std::size_t>(column)]);
  const auto last =
      entries_.begin() + static_cast<std::ptrdiff_t>(begins_[static_cast<std::size_t>(column) + 1]);
  const auto found =
      std::lower_bound(first, last, row, [](const Entry& e, int r) { return e.row < r; });
  RALI_ASSERT(found != last && found->row == row);
  return {values_.data() + found->offset, dim(row), dim(column)};
}

BlockMatrix::ConstBlock BlockMatrix::block(const Entry& entry) const {
  return {values_.data() + entry.offset, dim(entry.row), dim(entry.column)};
}

}  // namespace rali::graph
