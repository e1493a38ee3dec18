#include "rali/io/containers/db3_reader.hpp"

#include <algorithm>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "rali/io/containers/codec.hpp"

namespace rali::io {
namespace {

// Counting visits every page with the start of a row; too slow beyond this size.
constexpr std::uint64_t kCountBytesMax = 1ULL << 30;

// After this many consecutive unreadable rows, the gap is crossed in growing steps.
constexpr std::int64_t kSmallGap = 1000;

// Minimum size of rows accessed by their number.
constexpr std::uint64_t kRowBytesMin = 4;

wire::Encoding encoding_of(std::string_view name) {
  if (name == "cdr") return wire::Encoding::kCdr;
  if (name == "ros1") return wire::Encoding::kRos1;
  return wire::Encoding::kOther;
}

struct Key {
  std::int64_t t_ns = std::numeric_limits<std::int64_t>::min();
  std::int64_t row = std::numeric_limits<std::int64_t>::min();
  auto operator<=>(const Key&) const = default;
};

bool find_row(SqlStatement& statement, std::int64_t row) {
  statement.reset();
  statement.bind(1, row);
  return statement.step() == SqlStatement::Step::kRow;
}

class Db3Reader final : public MessageSource {
 public:
  Db3Reader(SqlDatabase database, std::string name, std::uint64_t file_bytes, const Db3Hints& hints,
            const ReadLimits& limits)
      : database_(std::move(database)),
        state_(std::move(name), limits),
        hints_(hints),
        file_bytes_(file_bytes) {}

  Status start();

  const std::vector<Topic>& topics() const override { return state_.topics(); }

  void select(std::function<bool(const Topic&)> keep) override { state_.select(std::move(keep)); }

  Result<bool> next(RawMessage& out) override;

  const SourceHealth& health() const override { return state_.health; }

  double progress() const override;

  std::optional<std::pair<Time, Time>> span() const override { return span_; }

  /// Rows are read in the order of their times.
  std::optional<bool> in_order() const override { return true; }

 private:
  Status check_tables();
  Status take_topics();
  std::map<std::string, std::string> definitions();
  void take_counts();
  void take_span();
  std::optional<std::int64_t> next_row();
  std::optional<std::int64_t> next_row_in_order();
  std::optional<std::int64_t> next_row_by_number();
  std::optional<std::int64_t> row_after(std::int64_t row, bool& failed);
  bool take_row(std::int64_t row, RawMessage& out);
  bool unpack(std::int64_t row, std::span<const std::byte>& data, wire::Encoding encoding);
  void malformed(const std::string& what);

  SqlDatabase database_;
  ReaderState state_;
  Db3Hints hints_;
  std::uint64_t file_bytes_;
  Decompressor decompressor_;
  std::vector<std::byte> unpacked_;
  std::map<std::int64_t, std::size_t> topic_of_id_;
  std::optional<std::pair<Time, Time>> span_;

  std::optional<SqlStatement> in_order_;
  std::optional<SqlStatement> after_;
  std::optional<SqlStatement> head_;
  std::optional<SqlStatement> data_;
  Key last_;  ///< of the last row read in the order of time
  std::int64_t row_ = std::numeric_limits<std::int64_t>::min();
  std::uint64_t rows_ = 0;
  double progress_ = 0.0;
  bool by_number_ = false;
  bool malformed_ = false;
  bool done_ = false;
};

Status Db3Reader::start() {
  if (const Status status = check_tables(); !status) return status;
  if (const Status status = take_topics(); !status) return status;
  state_.health.compression = hints_.zstd_messages ? "zstd" : "none";
  take_counts();
  take_span();
  in_order_ = database_.prepare("SELECT rowid, timestamp FROM messages ORDER BY timestamp, rowid");
  after_ = database_.prepare("SELECT rowid FROM messages WHERE rowid > ?1 ORDER BY rowid LIMIT 1");
  // Separate statements, so that the data of unselected topics are not read.
  head_ = database_.prepare("SELECT topic_id, timestamp FROM messages WHERE rowid = ?1");
  data_ = database_.prepare("SELECT data FROM messages WHERE rowid = ?1");
  if (in_order_ && after_ && head_ && data_) return {};
  return fail(ErrorCode::kInput, state_.name(),
              "table 'messages' is not that of rosbag2: " + database_.last_error());
}

/// Requires real tables, so that no view from an untrusted file is run.
Status Db3Reader::check_tables() {
  auto statement = database_.prepare(
      "SELECT name FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages') "
      "AND sql NOT LIKE 'CREATE VIRTUAL%'");
  std::set<std::string> found;
  if (!statement) {
    return fail(ErrorCode::kInput, state_.name(),
                "SQLite database that cannot be read: " + database_.last_error());
  }
  while (statement->step() == SqlStatement::Step::kRow) found.insert(statement->text(0));
  if (found.size() == 2) return {};
  return fail(ErrorCode::kInput, state_.name(),
              "SQLite database without the tables 'topics' and 'messages' of rosbag2");
}

std::map<std::string, std::string> Db3Reader::definitions() {
  std::map<std::string, std::string> out;
  auto statement =
      database_.prepare("SELECT topic_type, encoded_message_definition FROM message_definitions");
  if (!statement) return out;  // older than ROS 2 Iron
  while (statement->step() == SqlStatement::Step::kRow && out.size() < state_.limits().topics) {
    out[statement->text(0)] = statement->text(1);
  }
  return out;
}

Status Db3Reader::take_topics() {
  const auto definition_of_type = definitions();
  auto statement = database_.prepare("SELECT id, name, type, serialization_format FROM topics");
  if (!statement) {
    return fail(ErrorCode::kInput, state_.name(),
                "table 'topics' is not that of rosbag2: " + database_.last_error());
  }
  auto step = statement->step();
  for (; step == SqlStatement::Step::kRow; step = statement->step()) {
    Topic topic;
    topic.name = statement->text(1);
    topic.type = statement->text(2);
    topic.encoding_name = statement->text(3);
    topic.encoding = encoding_of(topic.encoding_name);
    const auto definition = definition_of_type.find(topic.type);
    if (definition != definition_of_type.end()) topic.definition = definition->second;
    const auto index = state_.topic(std::move(topic));
    if (!index) break;
    topic_of_id_[statement->integer(0)] = *index;
  }
  if (step == SqlStatement::Step::kFailed) malformed("the list of topics");
  return {};
}

void Db3Reader::take_counts() {
  if (file_bytes_ > kCountBytesMax) return;
  auto statement = database_.prepare("SELECT topic_id, count(*) FROM messages GROUP BY topic_id");
  if (!statement) return;
  std::map<std::int64_t, std::int64_t> counts;
  auto step = statement->step();
  for (; step == SqlStatement::Step::kRow; step = statement->step()) {
    counts[statement->integer(0)] = statement->integer(1);
  }
  if (step == SqlStatement::Step::kFailed) return;
  for (const auto& [id, topic] : topic_of_id_) {
    state_.add_count(topic, static_cast<std::uint64_t>(counts[id]));
  }
}

void Db3Reader::take_span() {
  Time ends[2];
  const std::string sql[2] = {"SELECT timestamp FROM messages ORDER BY timestamp LIMIT 1",
                              "SELECT timestamp FROM messages ORDER BY timestamp DESC LIMIT 1"};
  for (int i = 0; i < 2; ++i) {
    auto statement = database_.prepare(sql[i]);
    if (!statement || statement->step() != SqlStatement::Step::kRow) return;
    ends[i] = Time::from_ns(statement->integer(0));
  }
  span_ = {ends[0], ends[1]};
}

double Db3Reader::progress() const { return done_ ? 1.0 : progress_; }

Result<bool> Db3Reader::next(RawMessage& out) {
  while (!done_) {
    const auto row = next_row();
    if (!row) {
      done_ = true;
      in_order_->reset();
      break;
    }
    if (take_row(*row, out)) return true;
  }
  return false;
}

std::optional<std::int64_t> Db3Reader::next_row() {
  // Pages of a damaged tree may be visited many times; no file has more rows than this.
  if (++rows_ > 1000 + file_bytes_ / kRowBytesMin) return std::nullopt;
  return by_number_ ? next_row_by_number() : next_row_in_order();
}

std::optional<std::int64_t> Db3Reader::next_row_in_order() {
  const auto step = in_order_->step();
  if (step == SqlStatement::Step::kDone) return std::nullopt;
  if (step == SqlStatement::Step::kRow) {
    last_ = {in_order_->integer(1), in_order_->integer(0)};
    return last_.row;
  }
  malformed("the order of time");
  by_number_ = true;
  return next_row_by_number();
}

std::optional<std::int64_t> Db3Reader::row_after(std::int64_t row, bool& failed) {
  after_->reset();
  after_->bind(1, row);
  const auto step = after_->step();
  failed = step == SqlStatement::Step::kFailed;
  if (step != SqlStatement::Step::kRow) return std::nullopt;
  return after_->integer(0);
}

/// Rows in the order of their numbers, across unreadable gaps.
std::optional<std::int64_t> Db3Reader::next_row_by_number() {
  std::int64_t stride = 1;
  std::int64_t tried = 0;
  while (true) {
    bool failed = false;
    const auto row = row_after(row_, failed);
    if (!failed) {
      if (row) row_ = *row;
      return row;
    }
    row_ = std::max<std::int64_t>(row_, 0);
    if (++tried > kSmallGap) stride *= 2;
    if (row_ > std::numeric_limits<std::int64_t>::max() / 4 - stride) return std::nullopt;
    row_ += stride;
  }
}

bool Db3Reader::take_row(std::int64_t row, RawMessage& out) {
  if (!find_row(*head_, row)) {
    ++state_.health.messages_skipped;
    malformed(fmt::format("row {}", row));
    return false;
  }
  const Time t = Time::from_ns(head_->integer(1));
  // Rows up to last_ were already returned before reading in order of time failed.
  if (by_number_ && Key{t.ns, row} <= last_) return false;
  state_.saw(t);
  // In doubles: hostile times may differ by more than a Duration can hold.
  if (span_ && span_->second > span_->first) {
    const double fraction = (t.s() - span_->first.s()) / (span_->second.s() - span_->first.s());
    progress_ = std::max(progress_, std::min(fraction, 1.0));
  }
  const auto topic = topic_of_id_.find(head_->integer(0));
  if (topic == topic_of_id_.end()) {
    ++state_.health.messages_skipped;
    state_.find(Severity::kWarning, "io.damaged", std::nullopt,
                fmt::format("row {} belongs to no topic; left out", row));
    return false;
  }
  if (!state_.wanted(topic->second)) return false;
  const auto data = find_row(*data_, row) ? data_->blob(0) : std::nullopt;
  if (!data) {
    ++state_.health.messages_skipped;
    malformed(fmt::format("the data of row {}", row));
    return false;
  }
  out.data = *data;
  if (!unpack(row, out.data, state_.topics()[topic->second].encoding)) return false;
  out.topic = topic->second;
  out.t_record = t;
  out.offset = static_cast<std::uint64_t>(row);
  state_.handed_out();
  return true;
}

/// Decompresses a message that is a zstd frame. CDR starts with a byte 0, so it is never mistaken
/// for one; other encodings are only checked if the metadata says so.
bool Db3Reader::unpack(std::int64_t row, std::span<const std::byte>& data,
                       wire::Encoding encoding) {
  const bool possible = hints_.zstd_messages || encoding == wire::Encoding::kCdr;
  if (!possible || !is_zstd(data)) return true;
  state_.met_compression("zstd");
  const DecodeEnd end =
      decompressor_.decompress(Compression::kZstd, data, state_.limits().chunk_bytes, unpacked_);
  data = unpacked_;
  if (end == DecodeEnd::kWhole) return true;
  ++state_.health.messages_skipped;
  state_.find(Severity::kWarning, "io.damaged", std::nullopt,
              fmt::format("message of row {} cannot be decompressed; left out", row));
  return false;
}

/// One finding for the whole file, however many rows are affected.
void Db3Reader::malformed(const std::string& what) {
  if (malformed_) return;
  malformed_ = true;
  state_.find(Severity::kWarning, "io.malformed", std::nullopt,
              fmt::format("malformed SQLite database: {} cannot be read ({}). Rows that can be "
                          "reached are read",
                          what, database_.last_error()));
}

}  // namespace

Result<std::unique_ptr<MessageSource>> open_db3(SqlDatabase database, std::string name,
                                                std::uint64_t file_bytes, const Db3Hints& hints,
                                                const ReadLimits& limits) {
  auto reader =
      std::make_unique<Db3Reader>(std::move(database), std::move(name), file_bytes, hints, limits);
  if (const Status status = reader->start(); !status) return tl::make_unexpected(status.error());
  return reader;
}

}  // namespace rali::io
