#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "rali/report/range_data.hpp"

namespace rali::report {

/// Thins dots while they come, without hiding any cluster: of the dots in one cell of time and
/// residual the earliest is kept, and cells grow only as long as there are too many. Cells follow
/// asinh of the residual, so that small ones stay apart and wild ones need few. Dots without a
/// residual share one line of cells.
class CellThinner {
 public:
  /// @param dots_max never more are kept
  explicit CellThinner(std::size_t dots_max) : dots_max_(dots_max) {}

  /// What has no time is left out.
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

/// Ranges heard by one vehicle, in bins of time that grow with their number.
class HeardBins {
 public:
  void add(double t_s, bool used);
  [[nodiscard]] std::vector<Heard> spans() const;

 private:
  void coarsen();

  double bin_s_ = 0.5;
  std::map<std::int64_t, std::pair<std::size_t, std::size_t>> bins_;  ///< used, rejected
};

}  // namespace rali::report
