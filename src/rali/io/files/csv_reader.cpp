#include "rali/io/files/csv_reader.hpp"

#include <algorithm>
#include <cstring>

#include <fmt/core.h>

#include "rali/io/files/content_kind.hpp"
#include "rali/io/files/old_names.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 18;
// The program's tables have far shorter rows; longer is no table, or an unclosed quote.
constexpr std::size_t kRowBytesMax = std::size_t{1} << 20;
constexpr std::size_t kColumnsMax = 10000;
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

bool quotes_are_closed(std::string_view text) {
  return std::count(text.begin(), text.end(), '"') % 2 == 0;
}

}  // namespace

CsvReader::CsvReader(std::optional<InputFile> file, std::string text, std::string name)
    : file_(std::move(file)),
      name_(std::move(name)),
      buffer_(std::move(text)),
      at_end_(!file_.has_value()) {}

Result<CsvReader> CsvReader::open(const std::string& path) {
  auto file = InputFile::open(path);
  if (!file) return tl::make_unexpected(file.error());
  CsvReader reader(std::move(*file), {}, path);
  if (auto status = reader.read_header(); !status) return tl::make_unexpected(status.error());
  return reader;
}

Result<CsvReader> CsvReader::from_text(std::string text, const std::string& name) {
  CsvReader reader(std::nullopt, std::move(text), name);
  if (auto status = reader.read_header(); !status) return tl::make_unexpected(status.error());
  return reader;
}

tl::unexpected<Error> CsvReader::error(std::string what) const {
  return fail(ErrorCode::kInput, where(), std::move(what));
}

std::string CsvReader::where() const { return fmt::format("{}:{}", name_, row_line_); }

Status CsvReader::fill() {
  buffer_.erase(0, buffer_at_);
  buffer_at_ = 0;
  const std::size_t before = buffer_.size();
  buffer_.resize(before + kChunkBytes);
  const auto n =
      file_->read(std::as_writable_bytes(std::span(buffer_.data() + before, kChunkBytes)));
  if (!n) return tl::make_unexpected(n.error());
  buffer_.resize(before + *n);
  at_end_ = *n < kChunkBytes;
  return {};
}

Result<bool> CsvReader::take_physical_line(std::string& out) {
  std::size_t searched = buffer_at_;
  while (true) {
    const std::size_t end = buffer_.find('\n', searched);
    const bool found = end != std::string::npos;
    if ((found ? end : buffer_.size()) - buffer_at_ > kRowBytesMax) {
      return error("the line is longer than 1 MiB");
    }
    if (found || at_end_) {
      if (!found && buffer_at_ == buffer_.size()) return false;
      const std::size_t stop = found ? end : buffer_.size();
      out.append(buffer_, buffer_at_, stop - buffer_at_);
      buffer_at_ = found ? stop + 1 : stop;
      ++next_line_;
      return true;
    }
    searched = buffer_.size() - buffer_at_;
    if (auto status = fill(); !status) return tl::make_unexpected(status.error());
  }
}

/// Reads lines until the quotes are closed; skips comments and blank lines.
Result<bool> CsvReader::take_logical_line() {
  while (true) {
    text_.clear();
    row_line_ = next_line_;
    auto more = take_physical_line(text_);
    if (!more || !*more) return more;
    const std::string_view line = trimmed(text_);
    if (!line.empty() && line.front() != '#') break;
  }
  while (!quotes_are_closed(text_)) {
    text_ += '\n';
    auto more = take_physical_line(text_);
    if (!more) return more;
    if (!*more || text_.size() > kRowBytesMax) {
      return error("a cell that begins with a quote does not end");
    }
  }
  return true;
}

Status CsvReader::split() {
  unquoted_.clear();
  cells_.clear();
  std::string_view text = text_;
  if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
  bool in_quotes = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') {
      if (in_quotes && i + 1 < text.size() && text[i + 1] == '"') {
        unquoted_ += '"';
        ++i;
      } else {
        in_quotes = !in_quotes;
      }
    } else if (c == ',' && !in_quotes) {
      cells_.emplace_back(begin, unquoted_.size());
      begin = unquoted_.size();
    } else {
      unquoted_ += c;
    }
  }
  cells_.emplace_back(begin, unquoted_.size());
  if (cells_.size() > kColumnsMax) return error("the row has more than 10000 cells");
  return {};
}

Status CsvReader::check_first_bytes() {
  if (file_) {
    if (auto status = fill(); !status) return status;
  }
  const std::span<const std::byte> head = text_bytes(buffer_);
  if (buffer_.empty()) return fail(ErrorCode::kInput, name_, "is an empty file");
  if (buffer_.starts_with("\xff\xfe") || buffer_.starts_with("\xfe\xff")) {
    return fail(ErrorCode::kInput, name_, "is text in UTF-16", "Save it as UTF-8.");
  }
  const std::string kind = content_kind(head);
  if (kind != "text") {
    return fail(ErrorCode::kInput, name_, fmt::format("is {}, not a CSV table", kind));
  }
  if (buffer_.starts_with(kByteOrderMark)) buffer_at_ = kByteOrderMark.size();
  return {};
}

Status CsvReader::read_header() {
  if (auto status = check_first_bytes(); !status) return status;
  const auto more = take_logical_line();
  if (!more) return tl::make_unexpected(more.error());
  if (!*more) return fail(ErrorCode::kInput, name_, "has no header line");
  if (auto status = split(); !status) return status;
  header_.clear();
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    header_.emplace_back(cell(static_cast<int>(i)));
    const bool twice = !header_.back().empty() && std::find(header_.begin(), header_.end() - 1,
                                                            header_.back()) != header_.end() - 1;
    if (twice) return error(fmt::format("column {} stands twice", quoted(header_.back())));
  }
  const std::string_view line = text_;
  if (header_.size() == 1 && line.find_first_of(";\t") != std::string_view::npos) {
    return error("the columns are not separated by commas");
  }
  return {};
}

int CsvReader::column(std::string_view name) const {
  auto found = std::find(header_.begin(), header_.end(), name);
  if (found == header_.end()) {
    found = std::find(header_.begin(), header_.end(), old_name_of(name));
  }
  return found == header_.end() ? -1 : static_cast<int>(found - header_.begin());
}

Result<int> CsvReader::require(std::string_view name) const {
  const int index = column(name);
  if (index >= 0) return index;
  std::string there;
  for (std::size_t i = 0; i < std::min<std::size_t>(header_.size(), 12); ++i) {
    there += (i > 0 ? ", " : "") + quoted(header_[i]);
  }
  return fail(ErrorCode::kInput, name_,
              fmt::format("has no column '{}'; its columns are {}{}", name, there,
                          header_.size() > 12 ? ", ..." : ""),
              "The first line must name the columns.");
}

Result<bool> CsvReader::next() {
  auto more = take_logical_line();
  if (!more || !*more) return more;
  if (auto status = split(); !status) return tl::make_unexpected(status.error());
  return true;
}

std::string_view CsvReader::cell(int column) const {
  if (column < 0 || static_cast<std::size_t>(column) >= cells_.size()) return {};
  const auto [begin, end] = cells_[static_cast<std::size_t>(column)];
  return trimmed(std::string_view(unquoted_).substr(begin, end - begin));
}

}  // namespace rali::io
