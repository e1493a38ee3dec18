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

/// Limits for the resources that a damaged or hostile file can make a reader use.
struct ReadLimits {
  std::uint64_t chunk_bytes = 1ULL << 30;       ///< one chunk or message, decompressed
  std::uint64_t temp_bytes = 1ULL << 38;        ///< one decompressed file, on disk
  std::uint64_t definition_bytes = 1ULL << 26;  ///< all message definitions together
  std::size_t topics = 100'000;
  std::uint64_t prime_bytes = 32ULL << 20;  ///< read ahead for topics if there is no index
  std::uint64_t search_bytes = 1ULL << 30;  ///< searched for the next valid chunk after damage
};

/// Topics, topic selection, counts and findings: the state shared by the readers of all containers.
class ReaderState {
 public:
  ReaderState(std::string name, const ReadLimits& limits)
      : search(limits.search_bytes), name_(std::move(name)), limits_(limits) {}

  /// Index of the topic with this name, type and encoding, created if new; none if there are too
  /// many. Several publishers (connections, channels) of one topic become one Topic.
  std::optional<std::size_t> topic(Topic topic);

  void select(std::function<bool(const Topic&)> keep);

  [[nodiscard]] bool wanted(std::size_t topic) const { return wanted_[topic]; }

  /// Adds to the count of a topic as given by the index.
  void add_count(std::size_t topic, std::uint64_t messages);

  /// Discards the counts, if some part of a recording has none.
  void forget_counts();

  /// Continues after damage at `position` with the next chunk found. Without one it continues at
  /// the end of the truncated file; then `cut_at` is the position of the damage.
  Status skip_damage(const Result<std::optional<std::uint64_t>>& next_chunk,
                     std::uint64_t file_bytes, std::uint64_t& position,
                     std::optional<std::uint64_t>& cut_at);

  /// Counts messages as damaged, with the reason.
  void lose(std::uint64_t messages, std::uint64_t offset, std::string why);

  /// Fills `out` and counts, if this topic is selected. @return whether it is
  bool hand_out(std::size_t topic, Time t_record, std::uint64_t offset,
                std::span<const std::byte> data, RawMessage& out);

  /// Called for each whole message, selected or not; measures how much of a truncated file was
  /// read.
  void saw(Time t);

  /// At the end of a complete file: messages of the index that were neither seen nor counted as
  /// damaged are counted as lost.
  void expect(std::uint64_t messages);

  void handed_out() { ++health.messages; }

  /// Notes the compression of a chunk or file.
  void met_compression(std::string_view compression);

  /// Adds a finding; `what` gets "file:offset N: " before it and a full stop after it. After
  /// kFindingsMax of them one last finding states that the others are omitted.
  void find(Severity severity, std::string id, std::optional<std::uint64_t> offset,
            std::string what, std::string remedy = {});

  /// "Read 412.3 of about 430 s"; without the estimate if the file does not contain its intended
  /// length (`expected_bytes` 0, or implausible).
  [[nodiscard]] std::string read_so_far(std::uint64_t good_bytes,
                                        std::uint64_t expected_bytes) const;

  [[nodiscard]] const std::vector<Topic>& topics() const { return topics_; }

  [[nodiscard]] const std::string& name() const { return name_; }

  [[nodiscard]] const ReadLimits& limits() const { return limits_; }

  /// Reason why nothing follows at `cut_at`, as far as the bytes there show.
  [[nodiscard]] Result<std::string> why_cut(ByteSource& source, ByteWindow& window,
                                            std::uint64_t cut_at) const;
  /// Describes the data after the end of a closed recording.
  [[nodiscard]] static Result<std::string> what_more(ByteSource& source, ByteWindow& window,
                                                     std::uint64_t end);

  SourceHealth health;
  DamageSearch search;  ///< for all damage of the file together

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

/// Whether the parts of a file, in file order, are in order of time.
[[nodiscard]] bool spans_in_order(std::span<const std::pair<Time, Time>> spans);

/// Nanoseconds since 1970 as recorders store them, clamped to Time.
[[nodiscard]] Time time_of_ns(std::uint64_t ns);

/// "name:offset N".
[[nodiscard]] std::string at_offset(const std::string& name, std::uint64_t offset);

}  // namespace rali::io
