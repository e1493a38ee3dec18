#include "number_rows.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <limits>

namespace rali::ranges_bench {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace

double number_of(std::string_view text) {
  text = trimmed(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && !text.empty() ? value : std::numeric_limits<double>::quiet_NaN();
}

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> out;
  const bool blanks = separator == ' ';
  std::size_t begin = 0;
  for (std::size_t k = 0; k <= line.size(); ++k) {
    const bool end = k == line.size() || (blanks ? is_blank(line[k]) : line[k] == separator);
    if (!end) continue;
    const std::string_view piece = trimmed(line.substr(begin, k - begin));
    if (!blanks || !piece.empty()) out.push_back(piece);
    begin = k + 1;
  }
  return out;
}

int NumberRows::column(std::string_view name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

Result<NumberRows> read_number_rows(const std::filesystem::path& path, char separator) {
  std::ifstream file(path);
  if (!file) return fail(ErrorCode::kInput, path.string(), "this file cannot be read");
  NumberRows out;
  std::size_t width = 0;
  for (std::string line; std::getline(file, line);) {
    const std::string_view text = trimmed(line);
    if (text.empty() || text.front() == '#') continue;
    const auto cells = split(text, separator);
    if (width == 0) width = cells.size();
    if (cells.size() != width) {
      ++out.damaged;
      continue;
    }
    if (out.names.empty() && out.rows.empty() &&
        std::isalpha(static_cast<unsigned char>(text.front())) != 0) {
      out.names.assign(cells.begin(), cells.end());
      continue;
    }
    std::vector<double> row;
    row.reserve(width);
    for (const std::string_view cell : cells) row.push_back(number_of(cell));
    out.rows.push_back(std::move(row));
  }
  if (out.rows.empty()) return fail(ErrorCode::kInput, path.string(), "no row of numbers in it");
  return out;
}

}  // namespace rali::ranges_bench
