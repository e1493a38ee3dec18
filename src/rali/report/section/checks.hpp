#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Nothing is good that was not checked.
enum class CheckState { kGood, kLook, kBad, kNotChecked };

struct Check {
  CheckState state = CheckState::kNotChecked;
  std::string what, found;  ///< HTML
};

/// What was looked at and what came out, in the order of the page.
[[nodiscard]] std::vector<Check> checks_of(const RunData& run);

/// One sentence (HTML): what a reader should question first.
[[nodiscard]] std::string largest_uncertainty(const RunData& run);

/// rmse of the position against the truth over all vehicles, if evaluated.
[[nodiscard]] Number truth_error(const RunData& run);

/// The vehicle with the largest expected error; null: none is known.
[[nodiscard]] const VehicleView* least_certain(const RunData& run);

/// Largest position error of a pose against the truth.
[[nodiscard]] Number largest_error(const RunData& run);

/// How many times the stated sigma the errors are, root mean square: of a mean NEES.
[[nodiscard]] std::string ratio_text(const Number& nees, const Number& expected);

/// Why ranges that were given are not used (HTML); empty: none were given, or they are.
[[nodiscard]] std::string ranges_unused(const RunData& run);

[[nodiscard]] std::string_view state_class(CheckState state);
[[nodiscard]] std::string_view state_word(CheckState state);

/// What a count of metrics.json's gaps means, in words; the key itself if unknown.
[[nodiscard]] std::string_view gap_words(std::string_view key);

}  // namespace rali::report
