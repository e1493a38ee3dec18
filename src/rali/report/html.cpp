#include "rali/report/internal/html.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "rali/io/files/text.hpp"

namespace rali::report {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD", kNone = "\xE2\x80\x93";

/// Length of the UTF-8 character at the start of `text`, 0 if there is none.
/// Source: RFC 3629, section 4.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const auto tail = [&](std::size_t i) { return byte(i) >= 0x80 && byte(i) <= 0xBF; };
  const unsigned b = byte(0), c = byte(1);
  if (b < 0x80) return 1;
  if (b >= 0xC2 && b <= 0xDF) return tail(1) ? 2 : 0;
  if (b >= 0xE0 && b <= 0xEF) {
    const bool second = (b != 0xE0 || c >= 0xA0) && (b != 0xED || c <= 0x9F);
    return tail(1) && tail(2) && second ? 3 : 0;
  }
  if (b >= 0xF0 && b <= 0xF4) {
    const bool second = (b != 0xF0 || c >= 0x90) && (b != 0xF4 || c <= 0x8F);
    return tail(1) && tail(2) && tail(3) && second ? 4 : 0;
  }
  return 0;
}

std::string_view entity(char c) {
  switch (c) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      return {};
  }
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const char c = text.front();
    if (length == 0) {
      out += kReplacement;
    } else if (length > 1) {
      out += text.substr(0, length);
    } else if (const std::string_view word = entity(c); !word.empty()) {
      out += word;
    } else {
      out += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? ' ' : c;
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return std::string(kNone);
  return io::format_fixed(value, decimals);
}

std::string fixed(const Number& value, int decimals) {
  return fixed(value.value_or(kUnknown), decimals);
}

std::string percent(const Number& fraction) {
  if (!fraction) return std::string(kNone);
  const double value = 100.0 * *fraction;
  return fixed(value, value != 0.0 && std::abs(value) < 9.95 ? 1 : 0) + " %";
}

std::string counted(const Number& value) {
  if (!value || !std::isfinite(*value)) return std::string(kNone);
  std::string digits = fixed(*value, 0);
  const std::size_t first = digits.starts_with('-') ? 1 : 0;
  for (std::size_t at = digits.size(); at > first + 3;) {
    at -= 3;
    digits.insert(at, "\xE2\x80\xAF");  // narrow no-break space
  }
  return digits;
}

std::string at_most(const Number& value, double limit, int decimals) {
  if (value && *value > limit) return "over " + fixed(limit, 0);
  return fixed(value, decimals);
}

std::string metres(const Number& value_m) {
  if (!value_m) return std::string(kNone);
  constexpr double kBeyond_m = 1e5;
  if (std::abs(*value_m) > kBeyond_m) return "over 100 km";
  const double size = std::abs(*value_m);
  return fixed(*value_m, size < 0.1 ? 3 : size < 10.0 ? 2 : size < 100.0 ? 1 : 0) + " m";
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      word = word << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const bool there = k < 2 || i + k - 1 < bytes.size();
      out += there ? kDigits[word >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return out;
}

std::string Table::html(bool words) const {
  std::string out = words ? "<table class=\"words\"><thead><tr>" : "<table><thead><tr>";
  for (const std::string& cell : head_) out += "<th>" + cell + "</th>";
  out += "</tr></thead><tbody>\n";
  for (const std::vector<std::string>& row : rows_) {
    out += "<tr>";
    for (const std::string& cell : row) out += "<td>" + cell + "</td>";
    out += "</tr>\n";
  }
  return out + "</tbody></table>\n";
}

bool Table::all_of_column(std::size_t column, bool (*is)(const std::string&)) const {
  return std::all_of(rows_.begin(), rows_.end(), [&](const std::vector<std::string>& row) {
    return column < row.size() && is(row[column]);
  });
}

std::string Table::lean_html() const {
  const auto is_zero = [](const std::string& cell) {
    return cell.starts_with('0') && cell.find_first_of("123456789") == std::string::npos;
  };
  const auto is_unknown = [](const std::string& cell) {
    return cell == kNone || cell == "not known";
  };
  std::string zero, unknown;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < head_.size(); ++i) {
    std::string* list = i == 0 || rows_.empty()        ? nullptr
                        : all_of_column(i, is_zero)    ? &zero
                        : all_of_column(i, is_unknown) ? &unknown
                                                       : nullptr;
    if (list == nullptr) {
      kept.push_back(i);
    } else {
      *list += (list->empty() ? "" : ", ") + head_[i];
    }
  }
  const auto of_kept = [&](const std::vector<std::string>& cells) {
    std::vector<std::string> out;
    for (const std::size_t i : kept) out.push_back(i < cells.size() ? cells[i] : "");
    return out;
  };
  Table lean(of_kept(head_));
  for (const std::vector<std::string>& row : rows_) lean.row(of_kept(row));
  std::string out = lean.html();
  if (!zero.empty()) out += "<p class=\"note\">Zero in every row: " + zero + ".</p>\n";
  if (!unknown.empty()) out += "<p class=\"note\">Not known: " + unknown + ".</p>\n";
  return out;
}

std::string absent(std::string_view sentence) {
  return fmt::format("<p class=\"absent\">{}</p>\n", sentence);
}

}  // namespace rali::report
