#pragma once

#include <string>
#include <string_view>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// The blind axis of a stretch against the motion: "along its path", "across its path", "up and
/// down", ... (plain text)
[[nodiscard]] std::string_view axis_words(const BlindSpan& span);

/// The axis of nearly all of a vehicle's blind way; "along one axis" where it changes.
[[nodiscard]] std::string_view axis_words(const VehicleView& v);

/// Whether its files say where it was blind.
[[nodiscard]] bool blindness_known(const VehicleView& v);

[[nodiscard]] bool was_blind(const VehicleView& v);

/// A vehicle that hardly moves is judged by time, others by their way.
[[nodiscard]] bool stood(const VehicleView& v);

/// Share of the blind way (of a vehicle that stood: time) that `by` held.
[[nodiscard]] double held_share(const VehicleView& v, HeldBy by);

/// Share of its whole way that was blind and held by nothing.
[[nodiscard]] double unheld_share(const VehicleView& v);

/// "40.0 m", of a vehicle that stood "40.0 s".
[[nodiscard]] std::string amount_words(const VehicleView& v, const WayShare& share);

/// "v2 was blind along its path for 182 of 201 m, constrained by ranges to v1 for 97 % of it;
/// nothing constrained it for 5.5 m: the expected error there is 12.0 m along its path (1 sigma)"
/// (HTML).
[[nodiscard]] std::string blind_sentence_of(const VehicleView& v);

/// "nothing constrained it for 40 m: the expected error there is 12.0 m along its path (1 sigma)"
/// (HTML).
[[nodiscard]] std::string unheld_words(const VehicleView& v);

}  // namespace rali::report
