#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Text of unknown origin as it may stand in HTML, in attributes too: what is no UTF-8 becomes
/// U+FFFD, control characters become blanks.
[[nodiscard]] std::string escaped(std::string_view text);

/// Fixed decimals; "–" for what is no finite number.
[[nodiscard]] std::string fixed(double value, int decimals);
[[nodiscard]] std::string fixed(const Number& value, int decimals);

/// A share as "12.3 %".
[[nodiscard]] std::string percent(const Number& share);

/// Whole numbers with thin gaps: 530 968.
[[nodiscard]] std::string counted(const Number& value);

/// "over 1000" beyond a limit: a number that only shows that something is wrong is not written out.
[[nodiscard]] std::string at_most(const Number& value, double limit, int decimals);

/// Metres as people say them: 0.006 m, 87.3 m, 1204 m, over 100 km.
[[nodiscard]] std::string metres(const Number& value_m);

/// Bytes as base64.
[[nodiscard]] std::string base64(std::span<const std::byte> bytes);

/// Numbers as base64 of their bytes, little-endian as on every machine that is built for.
template <class T>
[[nodiscard]] std::string packed(const std::vector<T>& values) {
  return base64(std::as_bytes(std::span(values)));
}

/// A table; cells are HTML already. Columns after the first are set right.
class Table {
 public:
  explicit Table(std::vector<std::string> head) : head_(std::move(head)) {}

  void row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

  [[nodiscard]] bool empty() const { return rows_.empty(); }

  [[nodiscard]] std::size_t size() const { return rows_.size(); }

  /// `words`: columns hold text, set left.
  [[nodiscard]] std::string html(bool words = false) const;

  /// Without the columns that hold nothing but zeros or unknowns; a sentence names those.
  [[nodiscard]] std::string lean_html() const;

 private:
  [[nodiscard]] bool all_of_column(std::size_t column, bool (*is)(const std::string&)) const;

  std::vector<std::string> head_;
  std::vector<std::vector<std::string>> rows_;
};

/// A paragraph that says why there is nothing.
[[nodiscard]] std::string absent(std::string_view sentence);

}  // namespace rali::report
