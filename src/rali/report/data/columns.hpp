#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Values of one quantity over time; NaN if unknown.
struct Column {
  std::string_view name;
  std::vector<float> values;
  bool keeps_extremes = true;  ///< thinned to the lowest and highest value; else to single rows
};

/// One vehicle's quantities: row k of every column has the same time. The first column is `t`.
struct Columns {
  std::vector<Column> list;
  /// Per row: HeldBy in bits 0 and 1, Sight in bits 2 and 3, kDegenerateBit, kStandsBit.
  std::vector<std::uint8_t> state;

  [[nodiscard]] std::size_t rows() const { return state.size(); }
};

inline constexpr std::uint8_t kDegenerateBit = 16, kStandsBit = 32, kStateUnknown = 255;

/// The quantities of a vehicle at the times of its poses; of a vehicle without poses at those of
/// its degeneracy.
[[nodiscard]] Columns columns_of(const VehicleView& v);

/// At most `rows_max` rows: two per block of rows, with the lowest and the highest value in their
/// order, and the worst state. Neither a peak nor a single bad scan is lost.
void thin(Columns& columns, std::size_t rows_max);

}  // namespace rali::report
