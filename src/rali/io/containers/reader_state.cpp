#include "rali/io/containers/reader_state.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace rali::io {
namespace {

constexpr std::size_t kFindingsMax = 100;
/// Limit for stored zeros (not holes), which are read at 1 GB/s.
constexpr std::uint64_t kZerosBytesMax = 256ULL << 20;

// A damaged size field gives an absurd estimate; more than this multiple of the bytes read is
// rejected.
constexpr std::uint64_t kBelievableFactor = 20;

/// The sentence for a file with only zeros from `from` on; empty if it contains other bytes.
Result<std::string> zeros_to_end(ByteSource& source, ByteWindow& window, std::uint64_t from) {
  const auto zeros = end_of_zeros(source, window, from, kZerosBytesMax);
  if (!zeros) return tl::make_unexpected(zeros.error());
  if (*zeros != source.size()) return std::string();
  return fmt::format(
      "nothing but zeros to the end, {:.1f} MB (the disk or the computer failed "
      "while recording, or the file was grown). ",
      1e-6 * static_cast<double>(source.size() - from));
}

}  // namespace

std::optional<std::size_t> ReaderState::topic(Topic topic) {
  auto key = std::make_tuple(topic.name, topic.type, topic.encoding_name);
  const auto known = index_.find(key);
  if (known != index_.end()) return known->second;
  if (topics_.size() >= limits_.topics) {
    find(Severity::kError, "io.topics", std::nullopt,
         fmt::format("more than {} topics; the rest is left out", limits_.topics));
    return std::nullopt;
  }
  definition_bytes_ += topic.definition.size();
  if (definition_bytes_ > limits_.definition_bytes) topic.definition.clear();
  const std::size_t index = topics_.size();
  index_.emplace(std::move(key), index);
  topics_.push_back(std::move(topic));
  wanted_.push_back(!keep_ || keep_(topics_.back()));
  return index;
}

void ReaderState::select(std::function<bool(const Topic&)> keep) {
  keep_ = std::move(keep);
  for (std::size_t i = 0; i < topics_.size(); ++i) wanted_[i] = !keep_ || keep_(topics_[i]);
}

void ReaderState::add_count(std::size_t topic, std::uint64_t messages) {
  auto& count = topics_[topic].messages;
  count = count.value_or(0) + messages;
}

void ReaderState::forget_counts() {
  for (Topic& topic : topics_) topic.messages.reset();
}

void ReaderState::expect(std::uint64_t messages) {
  const std::uint64_t met = seen_messages_ + health.messages_skipped;
  if (messages <= met) return;
  health.messages_skipped += messages - met;
  find(Severity::kWarning, "io.damaged", std::nullopt,
       fmt::format("the index lists {} messages, {} were found", messages, seen_messages_));
}

Status ReaderState::skip_damage(const Result<std::optional<std::uint64_t>>& next_chunk,
                                std::uint64_t file_bytes, std::uint64_t& position,
                                std::optional<std::uint64_t>& cut_at) {
  if (!next_chunk) return tl::make_unexpected(next_chunk.error());
  if (*next_chunk) {
    find(Severity::kWarning, "io.damaged", position,
         fmt::format("damaged record; reading goes on at offset {}", **next_chunk));
    position = **next_chunk;
    return {};
  }
  cut_at = position;
  position = file_bytes;
  return {};
}

void ReaderState::lose(std::uint64_t messages, std::uint64_t offset, std::string why) {
  health.messages_skipped += messages;
  find(Severity::kWarning, "io.damaged", offset, std::move(why));
}

bool ReaderState::hand_out(std::size_t topic, Time t_record, std::uint64_t offset,
                           std::span<const std::byte> data, RawMessage& out) {
  saw(t_record);
  if (!wanted(topic)) return false;
  out.topic = topic;
  out.t_record = t_record;
  out.data = data;
  out.offset = offset;
  handed_out();
  return true;
}

void ReaderState::saw(Time t) {
  ++seen_messages_;
  if (!seen_) seen_ = {t, t};
  seen_->first = std::min(seen_->first, t);
  seen_->second = std::max(seen_->second, t);
}

void ReaderState::met_compression(std::string_view compression) {
  // Writers leave an incompressible chunk uncompressed; the file is still "zstd".
  if (health.compression.empty() || health.compression == "none") {
    health.compression = compression;
  } else if (compression != "none" && compression != health.compression) {
    health.compression = "mixed";
  }
}

void ReaderState::find(Severity severity, std::string id, std::optional<std::uint64_t> offset,
                       std::string what, std::string remedy) {
  if (health.findings.size() > kFindingsMax) return;
  Finding finding;
  finding.severity = severity;
  if (health.findings.size() == kFindingsMax) {
    finding.id = "io.more";
    finding.text = name_ + ": more damage follows that is counted but not listed.";
  } else {
    finding.id = std::move(id);
    finding.text = (offset ? at_offset(name_, *offset) : name_) + ": " + std::move(what) + ".";
    finding.remedy = std::move(remedy);
  }
  health.findings.push_back(std::move(finding));
}

std::string ReaderState::read_so_far(std::uint64_t good_bytes, std::uint64_t expected_bytes) const {
  if (!seen_) return "Nothing could be read";
  const double read_s = seconds_between(seen_->first, seen_->second);
  if (good_bytes == 0 || expected_bytes <= good_bytes ||
      expected_bytes / good_bytes > kBelievableFactor) {
    return fmt::format("Read {:.1f} s", read_s);
  }
  const double whole_s =
      read_s * static_cast<double>(expected_bytes) / static_cast<double>(good_bytes);
  return fmt::format("Read {:.1f} of about {:.0f} s", read_s, whole_s);
}

Result<std::string> ReaderState::why_cut(ByteSource& source, ByteWindow& window,
                                         std::uint64_t cut_at) const {
  if (cut_at >= source.size()) return std::string("record ends after the file. ");
  const auto zeros = zeros_to_end(source, window, cut_at);
  if (!zeros) return tl::make_unexpected(zeros.error());
  if (!zeros->empty()) return zeros;
  if (search.gave_up()) {
    return fmt::format(
        "damaged, and nothing readable within {:.0f} MB behind it; the rest of the "
        "file was not searched. ",
        1e-6 * static_cast<double>(limits_.search_bytes));
  }
  return std::string("record ends after the file. ");
}

Result<std::string> ReaderState::what_more(ByteSource& source, ByteWindow& window,
                                           std::uint64_t end) {
  auto zeros = zeros_to_end(source, window, end);
  if (!zeros || !zeros->empty()) return zeros;
  return fmt::format("{:.1f} MB behind the closing record were not read. ",
                     1e-6 * static_cast<double>(source.size() - end));
}

bool spans_in_order(std::span<const std::pair<Time, Time>> spans) {
  double newest_s = -std::numeric_limits<double>::infinity();
  for (const auto& [first, last] : spans) {
    // As doubles: hostile times may differ by more than a Duration can hold.
    if (newest_s - first.s() > kOrderSlackS) return false;
    newest_s = std::max(newest_s, last.s());
  }
  return true;
}

Time time_of_ns(std::uint64_t ns) {
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  return Time::from_ns(static_cast<std::int64_t>(std::min(ns, kMax)));
}

std::string at_offset(const std::string& name, std::uint64_t offset) {
  return name + ":offset " + std::to_string(offset);
}

}  // namespace rali::io
