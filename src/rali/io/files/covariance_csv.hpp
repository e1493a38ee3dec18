#pragma once

#include <string>
#include <utility>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"
#include "rali/io/files/csv_writer.hpp"

namespace rali::io {

/// Writes `<v>.cov.csv` (product.md section 5): `stamp_s,c00..c55`, upper triangle of the 6x6 in
/// the order x y z rx ry rz about fixed axes (see geometry::covariance_fixed_axes), %.6e.
class CovarianceWriter {
 public:
  [[nodiscard]] static Result<CovarianceWriter> create(const std::string& path);

  [[nodiscard]] Status add(Time t, const geometry::Mat6& covariance_fixed_axes);

  [[nodiscard]] Status finish() { return csv_.finish(); }

 private:
  explicit CovarianceWriter(CsvWriter csv) : csv_(std::move(csv)) {}

  CsvWriter csv_;
  CsvRow row_;
};

}  // namespace rali::io
