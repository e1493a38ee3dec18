#include "rali/io/containers/bag_reader.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "rali/io/containers/bag_index.hpp"
#include "rali/io/containers/chunk_loader.hpp"

namespace rali::io {
namespace {

/// A top-level record of the file: its header is read, its data not yet.
struct TopRecord {
  std::vector<std::byte> header;
  BagOp op = BagOp::kMessage;
  std::uint64_t offset = 0;
  std::uint64_t data_offset = 0;
  std::uint64_t data_bytes = 0;  ///< as its header claims

  [[nodiscard]] BagFields fields() const { return BagFields::parse(header).value_or(BagFields()); }

  [[nodiscard]] std::uint64_t end() const { return data_offset + data_bytes; }
};

/// The chunk whose messages are being returned.
struct OpenChunk {
  Cursor cursor;
  std::uint64_t offset = 0;       ///< of its record
  std::uint64_t data_offset = 0;  ///< of its data in the file
  std::uint64_t seen = 0;         ///< messages seen so far
  bool packed = false;
  bool cut = false;
};

class BagReader final : public MessageSource {
 public:
  BagReader(std::shared_ptr<ByteSource> source, const ReadLimits& limits)
      : source_(std::move(source)),
        window_(source_),
        loader_(source_, limits.chunk_bytes),
        state_(source_->name(), limits) {}

  /// Reads header and index.
  Status start();
  /// Collects topics from the first chunks, used without an index.
  Status prime();

  const std::vector<Topic>& topics() const override { return state_.topics(); }

  void select(std::function<bool(const Topic&)> keep) override { state_.select(std::move(keep)); }

  Result<bool> next(RawMessage& out) override;

  const SourceHealth& health() const override { return state_.health; }

  double progress() const override;

  std::optional<std::pair<Time, Time>> span() const override { return span_; }

  std::optional<bool> in_order() const override { return in_order_; }

 private:
  Result<std::optional<TopRecord>> peek();
  Status take_index(const BagFileHeader& header);
  void add_connection(std::uint32_t number, Topic topic);
  Result<bool> advance(RawMessage& out);
  Result<bool> take_record(const TopRecord& record, std::uint64_t available, RawMessage& out);
  Result<bool> take_top_message(const TopRecord& record, RawMessage& out);
  Status take_top_connection(const TopRecord& record);
  Status take_chunk(const TopRecord& record, std::uint64_t available);
  void lose_messages(std::uint64_t chunk_offset, std::uint64_t seen, std::uint64_t offset,
                     std::string why);
  bool next_in_chunk(RawMessage& out);
  bool take_message(const BagFields& fields, std::uint64_t offset, std::span<const std::byte> data,
                    RawMessage& out);
  std::uint64_t messages_in_chunk(std::uint64_t offset) const;
  void finish();

  std::shared_ptr<ByteSource> source_;
  ByteWindow window_;
  ChunkLoader loader_;
  ReaderState state_;
  std::map<std::uint32_t, std::size_t> topic_of_connection_;
  std::optional<std::pair<Time, Time>> span_;
  std::optional<bool> in_order_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> chunk_counts_;
  std::uint64_t index_offset_ = 0;

  std::uint64_t position_ = 0;           ///< of the next record of the file
  std::uint64_t last_whole_ = 0;         ///< end of the last whole record
  std::optional<std::uint64_t> cut_at_;  ///< the record that extends beyond the file
  bool index_short_ = false;             ///< truncated between two records of the index
  bool done_ = false;

  std::optional<OpenChunk> chunk_;
};

Status BagReader::start() {
  const auto header = read_bag_file_header(*source_, window_);
  if (!header) return tl::make_unexpected(header.error());
  position_ = last_whole_ = header->end;
  index_offset_ = header->index_offset;
  if (const Status status = take_index(*header); !status) return status;
  const auto record = peek();
  if (!record) return tl::make_unexpected(record.error());
  if (*record && (*record)->op == BagOp::kChunk) {
    state_.met_compression((*record)->fields().text("compression"));
  }
  return {};
}

Status BagReader::take_index(const BagFileHeader& header) {
  state_.health.unindexed = true;
  if (index_offset_ < kBagMagic.size() || index_offset_ > source_->size()) return {};
  auto index = read_bag_index(*source_, window_, index_offset_, state_.limits());
  if (!index) return tl::make_unexpected(index.error());
  if (!*index) return {};
  index_short_ =
      (*index)->connections.size() < header.connections || (*index)->chunks.size() < header.chunks;
  if (index_short_) return {};
  state_.health.unindexed = false;
  for (auto& [number, topic] : (*index)->connections) add_connection(number, std::move(topic));
  for (const auto& [number, topic] : topic_of_connection_) {
    const auto count = (*index)->counts.find(number);
    state_.add_count(topic, count == (*index)->counts.end() ? 0 : count->second);
  }
  span_ = (*index)->span;
  in_order_ = (*index)->in_order;
  chunk_counts_ = std::move((*index)->chunks);
  return {};
}

Status BagReader::prime() {
  if (!state_.health.unindexed) return {};
  state_.find(Severity::kInfo, "io.unindexed", std::nullopt,
              "no usable index (the recording was not closed or is cut); read by scanning");
  BagReader probe(source_, state_.limits());
  if (const Status status = probe.start(); !status) return status;
  RawMessage message;
  while (probe.position_ < state_.limits().prime_bytes) {
    const auto more = probe.next(message);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
  }
  for (const auto& [number, topic] : probe.topic_of_connection_) {
    add_connection(number, probe.topics()[topic]);
  }
  return {};
}

double BagReader::progress() const {
  if (done_ || source_->size() == 0) return 1.0;
  return std::min(1.0, static_cast<double>(position_) / static_cast<double>(source_->size()));
}

void BagReader::add_connection(std::uint32_t number, Topic topic) {
  if (topic_of_connection_.contains(number)) return;
  const auto index = state_.topic(std::move(topic));
  if (index) topic_of_connection_.emplace(number, *index);
}

/// The header of the record at position_; none if it is damaged or extends beyond the file.
Result<std::optional<TopRecord>> BagReader::peek() {
  auto bytes = window_.view(position_, 4);
  if (!bytes) return tl::make_unexpected(bytes.error());
  const std::uint32_t header_bytes = Cursor(*bytes).u32();
  if (header_bytes > kBagHeaderBytesMax) return std::nullopt;
  bytes = window_.view(position_, std::size_t{header_bytes} + 8);
  if (!bytes) return tl::make_unexpected(bytes.error());
  Cursor cursor(*bytes);
  const auto header = cursor.bytes32();
  TopRecord record;
  record.data_bytes = cursor.u32();
  const auto fields = BagFields::parse(header);
  if (!cursor.ok() || !fields) return std::nullopt;
  record.header.assign(header.begin(), header.end());
  record.op = fields->op();
  record.offset = position_;
  record.data_offset = position_ + cursor.at();
  return record;
}

Result<bool> BagReader::next(RawMessage& out) {
  while (true) {
    if (chunk_) {
      if (next_in_chunk(out)) return true;
    } else if (position_ >= source_->size()) {
      finish();
      return false;
    } else {
      const auto got = advance(out);
      if (!got || *got) return got;
    }
  }
}

/// Reads the next record of the file; true if it was a message outside a chunk.
Result<bool> BagReader::advance(RawMessage& out) {
  const auto record = peek();
  if (!record) return tl::make_unexpected(record.error());
  const bool readable = record->has_value();
  if (readable && (*record)->end() <= source_->size()) {
    position_ = (*record)->end();
    const auto got = take_record(**record, (*record)->data_bytes, out);
    if (!cut_at_) last_whole_ = position_;
    return got;
  }
  const Status status =
      state_.skip_damage(find_bag_chunk(*source_, window_, position_ + 1, state_.search),
                         source_->size(), position_, cut_at_);
  if (!status) return tl::make_unexpected(status.error());
  if (!readable || (*record)->op != BagOp::kChunk) return false;
  return take_record(**record, position_ - (*record)->data_offset, out);
}

Result<bool> BagReader::take_record(const TopRecord& record, std::uint64_t available,
                                    RawMessage& out) {
  Status status;
  if (record.op == BagOp::kMessage) return take_top_message(record, out);
  if (record.op == BagOp::kChunk) status = take_chunk(record, available);
  if (record.op == BagOp::kConnection) status = take_top_connection(record);
  if (!status) return tl::make_unexpected(status.error());
  return false;
}

Result<bool> BagReader::take_top_message(const TopRecord& record, RawMessage& out) {
  if (record.data_bytes > state_.limits().chunk_bytes) {
    lose_messages(record.offset, 0, record.offset, "message larger than is accepted");
    return false;
  }
  const Status status = loader_.load_plain(record.data_offset, record.data_bytes);
  if (!status) return tl::make_unexpected(status.error());
  return take_message(record.fields(), record.offset, loader_.bytes(), out);
}

/// Connections outside chunks: in the index section, whether or not that is usable as a whole.
Status BagReader::take_top_connection(const TopRecord& record) {
  if (record.data_bytes > state_.limits().definition_bytes) return {};
  if (const auto number = record.fields().u32("conn");
      number && topic_of_connection_.contains(*number)) {
    return {};
  }
  std::vector<std::byte> data(static_cast<std::size_t>(record.data_bytes));
  const Status status = source_->read(record.data_offset, data);
  if (!status) return status;
  auto connection = bag_connection(BagRecord{record.fields(), data});
  if (connection) add_connection(connection->first, std::move(connection->second));
  return {};
}

Status BagReader::take_chunk(const TopRecord& record, std::uint64_t available) {
  const BagFields fields = record.fields();
  const auto size = fields.u32("size");
  const auto compression = compression_named(fields.text("compression"));
  if (!size || !compression) {
    lose_messages(record.offset, 0, record.offset,
                  fmt::format("chunk of unknown compression '{:.20}'", fields.text("compression")));
    return {};
  }
  state_.met_compression(name_of(*compression));
  const StoredChunk stored{*compression, record.data_offset, record.data_bytes, available, *size};
  const auto trouble = loader_.load(stored);
  if (!trouble) return tl::make_unexpected(trouble.error());
  if (!trouble->empty()) {
    // For the chunk truncated by the end of the file, the finding on the truncation suffices.
    if (!(stored.cut() && cut_at_)) lose_messages(record.offset, 0, record.offset, *trouble);
    return {};
  }
  chunk_ = OpenChunk{Cursor(loader_.bytes()), record.offset, record.data_offset, 0,
                     stored.packed(),         stored.cut()};
  return {};
}

std::uint64_t BagReader::messages_in_chunk(std::uint64_t offset) const {
  const auto chunk = std::lower_bound(chunk_counts_.begin(), chunk_counts_.end(),
                                      std::make_pair(offset, std::uint64_t{0}));
  return chunk != chunk_counts_.end() && chunk->first == offset ? chunk->second : 0;
}

/// Counts the messages of a damaged chunk, or one message without an index.
void BagReader::lose_messages(std::uint64_t chunk_offset, std::uint64_t seen, std::uint64_t offset,
                              std::string why) {
  const std::uint64_t held = messages_in_chunk(chunk_offset);
  state_.lose(held > seen ? held - seen : 1, offset, std::move(why));
}

bool BagReader::next_in_chunk(RawMessage& out) {
  OpenChunk& chunk = *chunk_;
  while (chunk.cursor.left() > 0) {
    const std::uint64_t within = chunk.cursor.at();
    const std::uint64_t offset = chunk.packed ? chunk.offset : chunk.data_offset + within;
    const auto record = read_bag_record(chunk.cursor);
    if (!record) {
      if (!chunk.cut) {
        lose_messages(chunk.offset, chunk.seen, offset,
                      "record is damaged or longer than its chunk; the rest of the chunk is left "
                      "out");
      }
      chunk_.reset();
      return false;
    }
    if (chunk.cut && cut_at_ && !chunk.packed) last_whole_ = chunk.data_offset + chunk.cursor.at();
    if (record->fields.op() == BagOp::kConnection) {
      auto connection = bag_connection(*record);
      if (connection) add_connection(connection->first, std::move(connection->second));
    }
    if (record->fields.op() != BagOp::kMessage) continue;
    ++chunk.seen;
    if (take_message(record->fields, offset, record->data, out)) return true;
  }
  if (!chunk.cut && messages_in_chunk(chunk.offset) > chunk.seen) {
    lose_messages(chunk.offset, chunk.seen, chunk.offset,
                  "chunk holds fewer messages than the index says");
  }
  chunk_.reset();
  return false;
}

bool BagReader::take_message(const BagFields& fields, std::uint64_t offset,
                             std::span<const std::byte> data, RawMessage& out) {
  const auto connection = fields.u32("conn");
  const auto time = fields.time("time");
  const auto topic =
      connection ? topic_of_connection_.find(*connection) : topic_of_connection_.end();
  if (topic == topic_of_connection_.end() || !time) {
    state_.lose(1, offset, "message without a known connection or time; left out");
    return false;
  }
  return state_.hand_out(topic->second, *time, offset, data, out);
}

void BagReader::finish() {
  if (done_) return;
  done_ = true;
  if (!cut_at_ && index_offset_ <= source_->size() && !index_short_) {
    std::uint64_t promised = 0;
    for (const auto& [offset, messages] : chunk_counts_) promised += messages;
    state_.expect(promised);
    return;
  }
  state_.health.truncated = true;
  state_.health.bytes_lost = source_->size() - std::min(last_whole_, source_->size());
  const std::uint64_t at = cut_at_.value_or(source_->size());
  const auto why = state_.why_cut(*source_, window_, at);
  state_.find(Severity::kWarning, "io.cut", at,
              why.value_or("cannot be read on. ") + state_.read_so_far(last_whole_, index_offset_));
}

}  // namespace

Result<std::unique_ptr<MessageSource>> open_bag(std::shared_ptr<ByteSource> source,
                                                const ReadLimits& limits) {
  const auto known = starts_with(*source, kBagMagic);
  if (!known) return tl::make_unexpected(known.error());
  if (!*known) {
    return fail(ErrorCode::kInput, source->name(), "not a ROS 1 bag of version 2.0",
                "Convert older bags with rosbag fix.");
  }
  auto reader = std::make_unique<BagReader>(std::move(source), limits);
  if (const Status status = reader->start(); !status) return tl::make_unexpected(status.error());
  if (const Status status = reader->prime(); !status) return tl::make_unexpected(status.error());
  return reader;
}

}  // namespace rali::io
