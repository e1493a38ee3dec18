#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Escapes untrusted text for HTML, also for attributes: invalid UTF-8 becomes U+FFFD, control
/// characters become blanks.
[[nodiscard]] std::string escaped(std::string_view text);

/// Fixed decimals; "–" for non-finite numbers.
[[nodiscard]] std::string fixed(double value, int decimals);
[[nodiscard]] std::string fixed(const Number& value, int decimals);

/// A fraction as "12.3 %".
[[nodiscard]] std::string percent(const Number& fraction);

/// Whole numbers with thin spaces: 530 968.
[[nodiscard]] std::string counted(const Number& value);

/// "over 1000" beyond a limit: such a number shows only an error, its digits are irrelevant.
[[nodiscard]] std::string at_most(const Number& value, double limit, int decimals);

/// Metres with readable precision: 0.006 m, 87.3 m, 1204 m, over 100 km.
[[nodiscard]] std::string metres(const Number& value_m);

/// Bytes as base64.
[[nodiscard]] std::string base64(std::span<const std::byte> bytes);

/// Numbers as base64 of their bytes, little-endian as on all supported machines.
template <class T>
[[nodiscard]] std::string packed(const std::vector<T>& values) {
  return base64(std::as_bytes(std::span(values)));
}

/// A table; cells are already HTML. Columns after the first are right-aligned.
class Table {
 public:
  explicit Table(std::vector<std::string> head) : head_(std::move(head)) {}

  void row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

  [[nodiscard]] bool empty() const { return rows_.empty(); }

  [[nodiscard]] std::size_t size() const { return rows_.size(); }

  /// `words`: columns hold text, left-aligned.
  [[nodiscard]] std::string html(bool words = false) const;

  /// Without the columns that hold only zeros or unknowns; a sentence names those.
  [[nodiscard]] std::string lean_html() const;

 private:
  [[nodiscard]] bool all_of_column(std::size_t column, bool (*is)(const std::string&)) const;

  std::vector<std::string> head_;
  std::vector<std::vector<std::string>> rows_;
};

/// A paragraph that states why there is no content.
[[nodiscard]] std::string absent(std::string_view sentence);

}  // namespace rali::report
