#pragma once

#include <span>
#include <vector>

#include "rali/wire/cloud_format.hpp"
#include "rali/wire/internal/cloud_layout.hpp"

namespace rali::wire::internal {

/// The first non-empty clouds of a topic with the input of several decisions: a thinned-out sample
/// of each cloud's points in the order of the data.
struct FirstClouds {
  struct Cloud {
    const CloudView* view = nullptr;
    CloudLayout layout;
    std::size_t stride = 1;             ///< every stride-th point is in the sample
    std::vector<double> x_m, y_m, z_m;  ///< sample, as sent
    std::vector<char> valid;            ///< sample point is a finite point away from zero
    std::size_t valid_count = 0;
  };

  std::vector<Cloud> clouds;
  double stamp_period_s = 0.0;  ///< median interval of the stamps, 0 if unknown
  int x = -1, y = -1, z = -1;

  [[nodiscard]] const std::vector<CloudField>& fields() const { return clouds[0].view->fields; }
};

/// Errors: kNoAnswer if all clouds are empty, kInput for a cloud that cannot be read.
[[nodiscard]] Result<FirstClouds> look_at(std::span<const CloudView> clouds);

/// Middle value (the upper of two); 0 for none. Reorders the values.
[[nodiscard]] double median(std::vector<double>& values);

}  // namespace rali::wire::internal
