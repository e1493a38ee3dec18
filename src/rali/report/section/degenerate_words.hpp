#pragma once

#include <string>
#include <string_view>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Direction of a period's degenerate axis relative to the motion: "along its path", "across its
/// path", "up and
/// down", ... (plain text)
[[nodiscard]] std::string_view axis_words(const DegenerateSpan& span);

/// The axis of nearly all of a vehicle's degenerate distance; "along one axis" if it varies.
[[nodiscard]] std::string_view axis_words(const VehicleView& v);

/// Whether its files contain degeneracy.
[[nodiscard]] bool blindness_known(const VehicleView& v);

[[nodiscard]] bool was_degenerate(const VehicleView& v);

/// A vehicle that hardly moves is evaluated by time, others by distance travelled.
[[nodiscard]] bool stood(const VehicleView& v);

/// Fraction of the degenerate distance (time, for a vehicle at standstill) constrained by `by`.
[[nodiscard]] double held_fraction(const VehicleView& v, HeldBy by);

/// Fraction of its whole distance that was degenerate and unconstrained.
[[nodiscard]] double unheld_fraction(const VehicleView& v);

/// "40.0 m", of a vehicle at standstill "40.0 s".
[[nodiscard]] std::string amount_words(const VehicleView& v, const PathFraction& fraction);

/// "v2 was blind along its path for 182 of 201 m, constrained by ranges to v1 for 97 % of it;
/// nothing constrained it for 5.5 m: the expected error there is 12.0 m along its path (1 sigma)"
/// (HTML).
[[nodiscard]] std::string degenerate_sentence_of(const VehicleView& v);

/// "nothing constrained it for 40 m: the expected error there is 12.0 m along its path (1 sigma)"
/// (HTML).
[[nodiscard]] std::string unheld_words(const VehicleView& v);

}  // namespace rali::report
