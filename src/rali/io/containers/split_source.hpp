#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rali/io/containers/reader_state.hpp"
#include "rali/io/message_source.hpp"

namespace rali::io {

/// Several files of one recording, read one after the other as if they were one. Only one is open
/// at a time.
class SplitSource final : public MessageSource {
 public:
  using Open = std::function<Result<std::unique_ptr<MessageSource>>(const std::string& path)>;

  struct Part {
    std::string path;
    std::uint64_t bytes = 0;
    /// False if opening decompresses everything: its topics are then collected while reading.
    bool cheap_to_open = true;
  };

  SplitSource(std::string name, std::vector<Part> parts, Open open, const ReadLimits& limits);

  /// Adds a finding on the whole recording; before start().
  void note(Severity severity, std::string sentence);
  void set_truncated();

  /// Collects topics, counts and span. An Error only if no part can be opened.
  [[nodiscard]] Status start();

  const std::vector<Topic>& topics() const override { return state_.topics(); }

  void select(std::function<bool(const Topic&)> keep) override;

  Result<bool> next(RawMessage& out) override;

  const SourceHealth& health() const override { return state_.health; }

  double progress() const override;

  std::optional<std::pair<Time, Time>> span() const override { return span_; }

  std::optional<bool> in_order() const override { return in_order_; }

 private:
  bool look_into(MessageSource& part);
  bool open_next();
  void map_topics();
  void merge_health();

  ReaderState state_;
  std::vector<Part> parts_;
  Open open_;
  std::function<bool(const Topic&)> keep_;
  std::optional<std::pair<Time, Time>> span_;
  std::optional<bool> in_order_;
  std::size_t next_part_ = 0;
  std::uint64_t bytes_done_ = 0;
  std::uint64_t bytes_all_ = 0;
  bool done_ = false;

  std::unique_ptr<MessageSource> current_;
  std::unique_ptr<MessageSource> first_;  ///< opened by start(), read from by the first next()
  std::vector<std::optional<std::size_t>> topic_of_;  ///< our index, by topic of current_
  SourceHealth before_;                               ///< of the parts already read
};

}  // namespace rali::io
