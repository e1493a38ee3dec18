#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "rali/base/time.hpp"

namespace rali::io {

/// Text and numbers without the locale: the decimal sign is always '.'.

/// `text` without blanks, tabs and carriage returns at both ends.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// `text` with ASCII letters in lower case.
[[nodiscard]] std::string lower_case(std::string_view text);

/// Removes the first line from `rest`, without its "
/// " or "\r
/// "; false when nothing is left.
[[nodiscard]] bool take_line(std::string_view& rest, std::string_view& line);

/// Removes the first word from `rest`; empty when only blanks are left.
[[nodiscard]] std::string_view take_word(std::string_view& rest);

/// The whole text as a number; "nan" and "inf" are numbers too. Overflow: infinity; underflow: 0.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// The whole text as an integer.
[[nodiscard]] std::optional<std::int64_t> parse_integer(std::string_view text);

/// Seconds as text to whole nanoseconds, exact for decimals (a double of Unix seconds is not);
/// further decimals are rounded. Nothing for NaN and out of range.
[[nodiscard]] std::optional<Time> parse_stamp(std::string_view text);

/// Seconds with nine decimals, exact.
[[nodiscard]] std::string format_stamp(Time t);

/// Fixed decimals; a value that rounds to zero has no sign.
[[nodiscard]] std::string format_fixed(double value, int decimals);

/// Natural order: "scan2" before "scan10". A total order: equal only if identical.
[[nodiscard]] bool natural_less(std::string_view a, std::string_view b);

/// At most `max` printable characters of a text of unknown origin, for messages.
[[nodiscard]] std::string quoted(std::string_view text, std::size_t max = 40);

}  // namespace rali::io
