#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "rali/report/range_data.hpp"

namespace rali::report {

/// Thins dots as they arrive without hiding any cluster. The earliest dot in each cell of time and
/// residual is kept, and cells grow only while there are too many. Cells are uniform in asinh of
/// the residual: fine for small residuals, few for large ones. Dots without a residual share one
/// row of cells.
class CellThinner {
 public:
  /// @param dots_max upper limit of the dots kept
  explicit CellThinner(std::size_t dots_max) : dots_max_(dots_max) {}

  /// Dots without a time are left out.
  void add(const RangeDot& dot);

  /// The dots kept, by time.
  [[nodiscard]] std::vector<RangeDot> dots() const;

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;

  [[nodiscard]] Cell cell_of(const RangeDot& dot) const;
  void keep(const RangeDot& dot);
  void coarsen();

  std::size_t dots_max_;
  double cell_s_ = 0.05, cell_residual_ = 0.05;
  std::map<Cell, RangeDot> kept_;
};

/// Ranges received by one vehicle, in bins of time that grow with their number.
class ReceivedBins {
 public:
  void add(double t_s, bool used);
  [[nodiscard]] std::vector<Received> spans() const;

 private:
  void coarsen();

  double bin_s_ = 0.5;
  std::map<std::int64_t, std::pair<std::size_t, std::size_t>> bins_;  ///< used, rejected
};

}  // namespace rali::report
