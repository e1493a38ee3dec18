#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "rali/io/containers/damage_search.hpp"
#include "rali/io/message_source.hpp"

namespace rali::io {

/// What a damaged or hostile file may make a reader hold in memory.
struct ReadLimits {
  std::uint64_t chunk_bytes = 1ULL << 30;       ///< one chunk or message, decompressed
  std::uint64_t temp_bytes = 1ULL << 38;        ///< one decompressed file, on disk
  std::uint64_t definition_bytes = 1ULL << 26;  ///< all message definitions together
  std::size_t topics = 100'000;
  std::uint64_t prime_bytes = 32ULL << 20;  ///< read ahead for topics where no index tells them
  std::uint64_t search_bytes = 1ULL << 30;  ///< searched behind damage for what goes on
};

/// Topics, choice of topics, counts and findings: what the readers of all containers share.
class ReaderState {
 public:
  ReaderState(std::string name, const ReadLimits& limits)
      : search(limits.search_bytes), name_(std::move(name)), limits_(limits) {}

  /// Index of the topic of this name, type and encoding, made if new; none when there are too
  /// many. Several publishers (connections, channels) of one topic become one Topic.
  std::optional<std::size_t> topic(Topic topic);

  void select(std::function<bool(const Topic&)> keep);

  [[nodiscard]] bool wanted(std::size_t topic) const { return wanted_[topic]; }

  /// Adds to the count the index tells for a topic.
  void add_count(std::size_t topic, std::uint64_t messages);

  /// Where not every part of a recording knows its counts.
  void forget_counts();

  /// Goes on behind damage at `position`: with the chunk found behind it, or, without one, at the
  /// end of a file whose end is missing; then `cut_at` is where the damage was.
  Status skip_damage(const Result<std::optional<std::uint64_t>>& next_chunk,
                     std::uint64_t file_bytes, std::uint64_t& position,
                     std::optional<std::uint64_t>& cut_at);

  /// Counts messages that are damaged, with the reason.
  void lose(std::uint64_t messages, std::uint64_t offset, std::string why);

  /// Fills `out` and counts, if somebody wants this topic. @return whether it was wanted
  bool hand_out(std::size_t topic, Time t_record, std::uint64_t offset,
                std::span<const std::byte> data, RawMessage& out);

  /// Each whole message, wanted or not: tells how much of a cut file was read.
  void saw(Time t);

  /// At the end of an uncut file: what its index promises beyond what was seen or counted as
  /// damaged was lost in a way no record told of.
  void expect(std::uint64_t messages);

  void handed_out() { ++health.messages; }

  /// A chunk or file with this compression was met.
  void met_compression(std::string_view compression);

  /// `what` gets "file:offset N: " before it and a full stop after it. After kFindingsMax of them
  /// only one more is kept, which says so.
  void find(Severity severity, std::string id, std::optional<std::uint64_t> offset,
            std::string what, std::string remedy = {});

  /// "Read 412.3 of about 430 s"; without the estimate where the file does not tell how long it
  /// was meant to be (`expected_bytes` 0, or out of all proportion).
  [[nodiscard]] std::string read_so_far(std::uint64_t good_bytes,
                                        std::uint64_t expected_bytes) const;

  [[nodiscard]] const std::vector<Topic>& topics() const { return topics_; }

  [[nodiscard]] const std::string& name() const { return name_; }

  [[nodiscard]] const ReadLimits& limits() const { return limits_; }

  /// Why nothing follows at `cut_at`, as far as the bytes there tell.
  [[nodiscard]] Result<std::string> why_cut(ByteSource& source, ByteWindow& window,
                                            std::uint64_t cut_at) const;
  /// What lies behind the end of a recording that was closed.
  [[nodiscard]] static Result<std::string> what_more(ByteSource& source, ByteWindow& window,
                                                     std::uint64_t end);

  SourceHealth health;
  DamageSearch search;  ///< behind all damage of the file together

 private:
  std::string name_;
  ReadLimits limits_;
  std::vector<Topic> topics_;
  std::vector<bool> wanted_;
  std::map<std::tuple<std::string, std::string, std::string>, std::size_t> index_;
  std::function<bool(const Topic&)> keep_;
  std::uint64_t definition_bytes_ = 0;
  std::optional<std::pair<Time, Time>> seen_;
  std::uint64_t seen_messages_ = 0;
};

/// Whether parts of a file, in the order in which they lie there, follow each other in time.
[[nodiscard]] bool spans_in_order(std::span<const std::pair<Time, Time>> spans);

/// Nanoseconds since 1970 as recorders store them, clamped to Time.
[[nodiscard]] Time time_of_ns(std::uint64_t ns);

/// "name:offset N".
[[nodiscard]] std::string at_offset(const std::string& name, std::uint64_t offset);

}  // namespace rali::io
