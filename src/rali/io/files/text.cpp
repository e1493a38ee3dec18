#include "rali/io/files/text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include <fmt/core.h>

namespace rali::io {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// from_chars accepts '-' but not '+'.
std::string_view without_plus(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+';
  return plus ? text.substr(1) : text;
}

/// Length of the run of digits at the start of `text`.
std::size_t digits_at(std::string_view text) {
  std::size_t n = 0;
  while (n < text.size() && is_digit(text[n])) ++n;
  return n;
}

/// -1, 0, 1 as the number a is below, equal to or above b; both are digits of any length.
int compare_digits(std::string_view a, std::string_view b) {
  a.remove_prefix(std::min(a.find_first_not_of('0'), a.size()));
  b.remove_prefix(std::min(b.find_first_not_of('0'), b.size()));
  if (a.size() != b.size()) return a.size() < b.size() ? -1 : 1;
  const int order = a.compare(b);
  return order < 0 ? -1 : (order > 0 ? 1 : 0);
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

bool take_line(std::string_view& rest, std::string_view& line) {
  if (rest.empty()) return false;
  const std::size_t end = rest.find('\n');
  line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

std::string_view take_word(std::string_view& rest) {
  std::size_t begin = 0;
  while (begin < rest.size() && is_blank(rest[begin])) ++begin;
  std::size_t end = begin;
  while (end < rest.size() && !is_blank(rest[end])) ++end;
  const std::string_view word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

std::optional<double> parse_number(std::string_view text) {
  text = without_plus(trimmed(text));
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || text.empty()) return std::nullopt;
  if (error == std::errc()) return value;
  if (error != std::errc::result_out_of_range) return std::nullopt;
  // from_chars does not distinguish overflow from underflow; the exponent does.
  const std::size_t exponent = text.find_first_of("eE");
  const bool small = exponent == std::string_view::npos
                         ? digits_at(text.substr(text.front() == '-' ? 1 : 0)) < 300
                         : text.substr(exponent + 1).starts_with('-');
  const double magnitude = small ? 0.0 : std::numeric_limits<double>::infinity();
  return text.front() == '-' ? -magnitude : magnitude;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
  text = without_plus(trimmed(text));
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<Time> parse_stamp(std::string_view text) {
  text = without_plus(trimmed(text));
  const bool negative = !text.empty() && text.front() == '-';
  const std::string_view body = negative ? text.substr(1) : text;
  const std::size_t whole = digits_at(body);
  std::string_view decimals;
  if (whole < body.size() && body[whole] == '.') decimals = body.substr(whole + 1);
  const bool plain = whole > 0 && whole <= 10 && digits_at(decimals) == decimals.size() &&
                     (whole == body.size() || body[whole] == '.');
  if (!plain) {  // an exponent, or not a number at all
    const auto value_s = parse_number(text);
    if (!value_s || !(std::abs(*value_s) < 9.2e9)) return std::nullopt;
    return Time::from_s(*value_s);
  }
  std::int64_t ns = 0;
  for (const char c : body.substr(0, whole)) ns = ns * 10 + (c - '0');
  if (ns > 9'200'000'000) return std::nullopt;
  for (std::size_t i = 0; i < 9; ++i) {
    ns = ns * 10 + (i < decimals.size() ? decimals[i] - '0' : 0);
  }
  if (decimals.size() > 9 && decimals[9] >= '5') ++ns;
  return Time::from_ns(negative ? -ns : ns);
}

std::string format_stamp(Time t) {
  // Unsigned, because the smallest int64 cannot be negated.
  const bool negative = t.ns < 0;
  const std::uint64_t ns =
      negative ? 0 - static_cast<std::uint64_t>(t.ns) : static_cast<std::uint64_t>(t.ns);
  return fmt::format("{}{}.{:09}", negative ? "-" : "", ns / 1'000'000'000, ns % 1'000'000'000);
}

std::string format_fixed(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.find_first_not_of("-0.") == std::string::npos && text.front() == '-') text.erase(0, 1);
  return text;
}

bool natural_less(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a;
  const std::string_view whole_b = b;
  while (!a.empty() && !b.empty()) {
    const std::size_t digits_a = digits_at(a);
    const std::size_t digits_b = digits_at(b);
    if (digits_a > 0 && digits_b > 0) {
      const int order = compare_digits(a.substr(0, digits_a), b.substr(0, digits_b));
      if (order != 0) return order < 0;
      a.remove_prefix(digits_a);
      b.remove_prefix(digits_b);
      continue;
    }
    if (a.front() != b.front()) {
      return static_cast<unsigned char>(a.front()) < static_cast<unsigned char>(b.front());
    }
    a.remove_prefix(1);
    b.remove_prefix(1);
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;  // "scan02" and "scan2": the same number, still an order
}

std::string quoted(std::string_view text, std::size_t max) {
  std::string clean = "'";
  for (const char c : text.substr(0, max)) clean += c >= ' ' && c <= '~' ? c : '?';
  if (text.size() > max) clean += "...";
  return clean + "'";
}

}  // namespace rali::io
