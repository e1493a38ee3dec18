#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Without a check the state is never kGood.
enum class CheckState { kGood, kLook, kBad, kNotChecked };

struct Check {
  CheckState state = CheckState::kNotChecked;
  std::string what, found;  ///< HTML
};

/// The checks and their results, in the order of the page.
[[nodiscard]] std::vector<Check> checks_of(const RunData& run);

/// One sentence (HTML): the least reliable result, for the reader to check first.
[[nodiscard]] std::string largest_uncertainty(const RunData& run);

/// rmse of the position against the ground truth over all vehicles, if evaluated.
[[nodiscard]] Number truth_error(const RunData& run);

/// The vehicle with the largest expected error; null: none is known.
[[nodiscard]] const VehicleView* least_certain(const RunData& run);

/// Largest position error of a pose against the ground truth.
[[nodiscard]] Number largest_error(const RunData& run);

/// Ratio of errors to stated sigma, root mean square: from a mean NEES.
[[nodiscard]] std::string ratio_text(const Number& nees, const Number& expected);

/// Why given ranges are not used (HTML); empty: none were given, or they are used.
[[nodiscard]] std::string ranges_unused(const RunData& run);

[[nodiscard]] std::string_view state_class(CheckState state);
[[nodiscard]] std::string_view state_word(CheckState state);

/// Meaning of a key of metrics.json's gaps as text; the key itself if unknown.
[[nodiscard]] std::string_view gap_words(std::string_view key);

}  // namespace rali::report
