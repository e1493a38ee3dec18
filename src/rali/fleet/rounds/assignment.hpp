#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace rali::fleet {

/// Costs row by row; infinite: not allowed.
struct CostTable {
  std::size_t rows = 0, columns = 0;
  std::vector<double> cost;

  [[nodiscard]] double at(std::size_t row, std::size_t column) const {
    return cost[row * columns + column];
  }
};

/// Assigns each row at most one column and each column at most one row: as many as possible, and of
/// these assignments the one of least cost (Kuhn 1955 "Hungarian method", in the form of successive
/// shortest paths with potentials). Costs may be negative; not-a-number counts as infinite.
[[nodiscard]] std::vector<std::optional<std::size_t>> assign(const CostTable& table);

}  // namespace rali::fleet
