#include "rali/io/files/covariance_csv.hpp"

#include <vector>

#include <fmt/core.h>

namespace rali::io {

Result<CovarianceWriter> CovarianceWriter::create(const std::string& path) {
  std::vector<std::string> columns = {"stamp_s"};
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) columns.push_back(fmt::format("c{}{}", row, col));
  }
  auto csv = CsvWriter::create(path, columns);
  if (!csv) return tl::make_unexpected(csv.error());
  return CovarianceWriter(std::move(*csv));
}

Status CovarianceWriter::add(Time t, const geometry::Mat6& covariance_fixed_axes) {
  row_.clear();
  row_.stamp(t);
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) row_.scientific(covariance_fixed_axes(row, col), 6);
  }
  return csv_.add(row_, t);
}

}  // namespace rali::io
