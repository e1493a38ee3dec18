#include "rali/fleet/rounds/assignment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rali/base/assert.hpp"

namespace rali::fleet {
namespace {

/// A square problem with finite costs, rows and columns counted from 1 (0 is "none").
class Hungarian {
 public:
  Hungarian(std::size_t n, const std::vector<double>& cost)
      : n_(n), cost_(cost), u_(n + 1, 0.0), v_(n + 1, 0.0), row_of_(n + 1, 0) {
    for (std::size_t row = 1; row <= n_; ++row) add(row);
  }

  [[nodiscard]] std::size_t row_of(std::size_t column) const { return row_of_[column]; }

 private:
  /// Finds the cheapest way to assign the row a column, with reassignment of others.
  void add(std::size_t row) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    std::vector<double> slack(n_ + 1, kFar);
    std::vector<std::size_t> before(n_ + 1, 0);
    std::vector<char> done(n_ + 1, 0);
    row_of_[0] = row;
    std::size_t column = 0;
    while (row_of_[column] != 0) {
      done[column] = 1;
      const std::size_t i = row_of_[column];
      double minimum = kFar;
      std::size_t next = 0;
      for (std::size_t j = 1; j <= n_; ++j) {
        if (done[j] != 0) continue;
        const double reduced = cost_[(i - 1) * n_ + j - 1] - u_[i] - v_[j];
        if (reduced < slack[j]) {
          slack[j] = reduced;
          before[j] = column;
        }
        if (slack[j] < minimum) {
          minimum = slack[j];
          next = j;
        }
      }
      for (std::size_t j = 0; j <= n_; ++j) {
        if (done[j] != 0) {
          u_[row_of_[j]] += minimum;
          v_[j] -= minimum;
        } else {
          slack[j] -= minimum;
        }
      }
      column = next;
    }
    while (column != 0) {
      row_of_[column] = row_of_[before[column]];
      column = before[column];
    }
  }

  std::size_t n_;
  const std::vector<double>& cost_;
  std::vector<double> u_, v_;
  std::vector<std::size_t> row_of_;
};

}  // namespace

std::vector<std::optional<std::size_t>> assign(const CostTable& table) {
  RALI_ASSERT(table.cost.size() == table.rows * table.columns);
  std::vector<std::optional<std::size_t>> out(table.rows);
  const std::size_t n = std::max(table.rows, table.columns);
  double largest = 1.0;
  for (const double c : table.cost) {
    if (std::isfinite(c)) largest = std::max(largest, std::abs(c));
  }
  // No sum of allowed costs reaches a forbidden one.
  const double forbidden = largest * 4.0 * static_cast<double>(n + 1);
  std::vector<double> square(n * n, forbidden);
  for (std::size_t r = 0; r < table.rows; ++r) {
    for (std::size_t c = 0; c < table.columns; ++c) {
      if (std::isfinite(table.at(r, c))) square[r * n + c] = table.at(r, c);
    }
  }
  const Hungarian solved(n, square);
  for (std::size_t c = 0; c < table.columns; ++c) {
    const std::size_t r = solved.row_of(c + 1) - 1;
    if (r < table.rows && std::isfinite(table.at(r, c))) out[r] = c;
  }
  return out;
}

}  // namespace rali::fleet
