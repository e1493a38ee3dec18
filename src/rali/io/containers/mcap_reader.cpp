#include "rali/io/containers/mcap_reader.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "rali/io/containers/chunk_loader.hpp"
#include "rali/io/containers/mcap_summary.hpp"

namespace rali::io {
namespace {

/// A top-level record of the file, its content not yet read.
struct TopRecord {
  McapOp op = McapOp::kHeader;
  std::uint64_t offset = 0;
  std::uint64_t content_bytes = 0;  ///< as its header claims

  [[nodiscard]] std::uint64_t content() const { return offset + kMcapRecordHeaderBytes; }
};

/// The chunk whose messages are being returned.
struct OpenChunk {
  Cursor cursor;
  std::uint64_t offset = 0;       ///< of its record
  std::uint64_t data_offset = 0;  ///< of its records in the file
  bool packed = false;
  bool cut = false;
};

wire::Encoding encoding_of(std::string_view name) {
  if (name == "cdr") return wire::Encoding::kCdr;
  if (name == "ros1") return wire::Encoding::kRos1;
  return wire::Encoding::kOther;
}

/// Checks the length too: a damaged opcode must not end the reading unnoticed.
bool ends_data(const TopRecord& record) {
  return (record.op == McapOp::kDataEnd && record.content_bytes == kMcapDataEndBytes) ||
         (record.op == McapOp::kFooter && record.content_bytes == kMcapFooterBytes);
}

class McapReader final : public MessageSource {
 public:
  McapReader(std::shared_ptr<ByteSource> source, const ReadLimits& limits)
      : source_(std::move(source)),
        window_(source_),
        loader_(source_, limits.chunk_bytes),
        state_(source_->name(), limits) {}

  /// Reads the summary, or without one collects topics from the first chunks.
  Status start(bool prime);

  const std::vector<Topic>& topics() const override { return state_.topics(); }

  void select(std::function<bool(const Topic&)> keep) override { state_.select(std::move(keep)); }

  Result<bool> next(RawMessage& out) override;

  const SourceHealth& health() const override { return state_.health; }

  double progress() const override;

  std::optional<std::pair<Time, Time>> span() const override { return span_; }

  std::optional<bool> in_order() const override { return in_order_; }

 private:
  Status take_summary(bool& topics_known);
  Status prime();
  bool take_definition(const McapRecord& record);
  void add_channel(const McapChannel& channel);
  Result<std::optional<TopRecord>> peek();
  Result<bool> advance(RawMessage& out);
  Result<bool> take_record(const TopRecord& record, std::uint64_t available, RawMessage& out);
  Result<bool> take_top_message(const TopRecord& record, RawMessage& out);
  Status take_top_definition(const TopRecord& record);
  Status take_chunk(const TopRecord& record, std::uint64_t available);
  Status lose_chunk(const TopRecord& record, std::string why);
  bool next_in_chunk(RawMessage& out);
  bool take_message(std::span<const std::byte> content, std::uint64_t offset, RawMessage& out);
  void finish();
  void report_more();

  std::shared_ptr<ByteSource> source_;
  ByteWindow window_;
  ChunkLoader loader_;
  ReaderState state_;
  std::map<std::uint16_t, McapSchema> schemas_;
  std::map<std::uint16_t, std::size_t> topic_of_channel_;
  std::optional<std::pair<Time, Time>> span_;
  std::optional<bool> in_order_;

  std::uint64_t position_ = kMcapMagic.size();    ///< of the next record of the file
  std::uint64_t last_whole_ = kMcapMagic.size();  ///< end of the last whole record
  std::optional<std::uint64_t> cut_at_;           ///< the record that extends beyond the file
  std::uint64_t promised_ = 0;                    ///< messages according to the summary
  std::optional<std::uint64_t> data_end_;         ///< offset of the record that ends the data
  bool done_ = false;

  std::optional<OpenChunk> chunk_;
};

Status McapReader::start(bool with_prime) {
  bool topics_known = false;
  if (const Status status = take_summary(topics_known); !status) return status;
  const auto compression = first_mcap_compression(*source_, window_);
  if (!compression) return tl::make_unexpected(compression.error());
  if (!compression->empty()) state_.met_compression(*compression);
  return with_prime && !topics_known ? prime() : Status();
}

Status McapReader::take_summary(bool& topics_known) {
  std::string why;
  auto summary = read_mcap_summary(*source_, window_, state_.limits(), why);
  if (!summary) return tl::make_unexpected(summary.error());
  state_.health.unindexed = !summary->has_value();
  if (!*summary) {
    state_.find(Severity::kInfo, "io.unindexed", std::nullopt, why + "; read by scanning");
    return {};
  }
  for (McapSchema& schema : (*summary)->schemas) schemas_[schema.id] = std::move(schema);
  for (const McapChannel& channel : (*summary)->channels) add_channel(channel);
  in_order_ = (*summary)->in_order();
  const auto& statistics = (*summary)->statistics;
  topics_known = statistics && statistics->channels <= topic_of_channel_.size();
  if (!statistics) return {};
  promised_ = statistics->messages;
  if (statistics->messages > 0) {
    span_ = {time_of_ns(statistics->first_ns), time_of_ns(statistics->last_ns)};
  }
  if (statistics->counts.empty() && statistics->messages > 0) return {};
  for (const auto& [channel, topic] : topic_of_channel_) state_.add_count(topic, 0);
  for (const auto& [channel, messages] : statistics->counts) {
    const auto topic = topic_of_channel_.find(channel);
    if (topic != topic_of_channel_.end()) state_.add_count(topic->second, messages);
  }
  return {};
}

Status McapReader::prime() {
  McapReader probe(source_, state_.limits());
  if (const Status status = probe.start(false); !status) return status;
  RawMessage message;
  while (probe.position_ < state_.limits().prime_bytes) {
    const auto more = probe.next(message);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
  }
  for (const auto& [channel, topic] : probe.topic_of_channel_) {
    const auto index = state_.topic(probe.topics()[topic]);
    if (index) topic_of_channel_.emplace(channel, *index);
  }
  return {};
}

double McapReader::progress() const {
  if (done_ || source_->size() == 0) return 1.0;
  return std::min(1.0, static_cast<double>(position_) / static_cast<double>(source_->size()));
}

void McapReader::add_channel(const McapChannel& channel) {
  Topic topic;
  topic.name = channel.topic;
  topic.encoding_name = channel.encoding;
  topic.encoding = encoding_of(channel.encoding);
  if (const auto schema = schemas_.find(channel.schema); schema != schemas_.end()) {
    topic.type = schema->second.name;
    topic.definition = schema->second.data;
  }
  const auto index = state_.topic(std::move(topic));
  if (index) topic_of_channel_[channel.id] = *index;
}

/// Processes a schema or a channel; true if it was one and readable.
bool McapReader::take_definition(const McapRecord& record) {
  if (record.op == McapOp::kSchema) {
    auto schema = mcap_schema(record.content);
    if (!schema || schema->data.size() > state_.limits().definition_bytes) return false;
    schemas_[schema->id] = std::move(*schema);
    return true;
  }
  if (record.op != McapOp::kChannel) return false;
  const auto channel = mcap_channel(record.content);
  if (channel) add_channel(*channel);
  return channel.has_value();
}

/// The record at position_; none if even its length extends beyond the file or its opcode is 0.
Result<std::optional<TopRecord>> McapReader::peek() {
  const auto bytes = window_.view(position_, kMcapRecordHeaderBytes);
  if (!bytes) return tl::make_unexpected(bytes.error());
  Cursor cursor(*bytes);
  TopRecord record;
  record.op = static_cast<McapOp>(cursor.u8());
  record.content_bytes = cursor.u64();
  record.offset = position_;
  if (!cursor.ok() || record.op == McapOp{0}) return std::nullopt;
  return record;
}

Result<bool> McapReader::next(RawMessage& out) {
  while (true) {
    if (chunk_) {
      if (next_in_chunk(out)) return true;
    } else if (data_end_ || position_ >= source_->size()) {
      finish();
      return false;
    } else {
      const auto got = advance(out);
      if (!got || *got) return got;
    }
  }
}

/// Reads the next record of the file; true if it was a message outside a chunk.
Result<bool> McapReader::advance(RawMessage& out) {
  const auto record = peek();
  if (!record) return tl::make_unexpected(record.error());
  const bool readable = record->has_value();
  const std::uint64_t room =
      source_->size() - std::min(position_ + kMcapRecordHeaderBytes, source_->size());
  if (readable && (*record)->content_bytes <= room) {
    position_ = (*record)->content() + (*record)->content_bytes;
    const auto got = take_record(**record, (*record)->content_bytes, out);
    if (!cut_at_) last_whole_ = position_;
    return got;
  }
  const Status status =
      state_.skip_damage(find_mcap_chunk(*source_, window_, position_ + 1, state_.search),
                         source_->size(), position_, cut_at_);
  if (!status) return tl::make_unexpected(status.error());
  if (!readable || (*record)->op != McapOp::kChunk) return false;
  return take_record(**record, position_ - (*record)->content(), out);
}

Result<bool> McapReader::take_record(const TopRecord& record, std::uint64_t available,
                                     RawMessage& out) {
  Status status;
  if (record.op == McapOp::kMessage) return take_top_message(record, out);
  if (record.op == McapOp::kChunk) status = take_chunk(record, available);
  if (record.op == McapOp::kSchema || record.op == McapOp::kChannel) {
    status = take_top_definition(record);
  }
  if (ends_data(record)) data_end_ = record.offset;
  if (!status) return tl::make_unexpected(status.error());
  return false;
}

Result<bool> McapReader::take_top_message(const TopRecord& record, RawMessage& out) {
  state_.met_compression("none");
  if (record.content_bytes > state_.limits().chunk_bytes) {
    state_.lose(1, record.offset,
                fmt::format("message of {} bytes is larger than the {} that are accepted",
                            record.content_bytes, state_.limits().chunk_bytes));
    return false;
  }
  const Status status = loader_.load_plain(record.content(), record.content_bytes);
  if (!status) return tl::make_unexpected(status.error());
  return take_message(loader_.bytes(), record.offset, out);
}

Status McapReader::take_top_definition(const TopRecord& record) {
  if (record.content_bytes > state_.limits().definition_bytes) return {};
  std::vector<std::byte> content(static_cast<std::size_t>(record.content_bytes));
  const Status status = source_->read(record.content(), content);
  if (!status) return status;
  if (!take_definition({record.op, content})) {
    state_.find(Severity::kWarning, "io.damaged", record.offset, "damaged schema or channel");
  }
  return {};
}

Status McapReader::take_chunk(const TopRecord& record, std::uint64_t available) {
  const auto head = window_.view(record.content(), static_cast<std::size_t>(std::min<std::uint64_t>(
                                                       available, McapChunkHeader::kBytesMax)));
  if (!head) return tl::make_unexpected(head.error());
  const auto header = mcap_chunk(*head);
  if (!header) {
    return available < record.content_bytes ? Status() : lose_chunk(record, "damaged chunk");
  }
  const auto compression = compression_named(header->compression);
  if (!compression) {
    return lose_chunk(record,
                      fmt::format("chunk of unknown compression '{}'", header->compression));
  }
  state_.met_compression(name_of(*compression));
  const StoredChunk stored{*compression,
                           record.content() + header->header_bytes,
                           header->record_bytes,
                           available - header->header_bytes,
                           header->uncompressed_bytes,
                           header->uncompressed_crc};
  const auto trouble = loader_.load(stored);
  if (!trouble) return tl::make_unexpected(trouble.error());
  if (!trouble->empty()) {
    // For the chunk truncated by the end of the file, the finding on the truncation suffices.
    return stored.cut() && cut_at_ ? Status() : lose_chunk(record, *trouble);
  }
  chunk_ = OpenChunk{Cursor(loader_.bytes()), record.offset, stored.offset, stored.packed(),
                     stored.cut()};
  return {};
}

/// Counts the messages of a damaged chunk by the index after it, or one message without one.
Status McapReader::lose_chunk(const TopRecord& record, std::string why) {
  const auto messages = count_mcap_index(*source_, window_, position_);
  if (!messages) return tl::make_unexpected(messages.error());
  state_.lose(std::max<std::uint64_t>(1, *messages), record.offset, std::move(why));
  return {};
}

bool McapReader::next_in_chunk(RawMessage& out) {
  OpenChunk& chunk = *chunk_;
  while (chunk.cursor.left() > 0) {
    const std::uint64_t within = chunk.cursor.at();
    const std::uint64_t offset = chunk.packed ? chunk.offset : chunk.data_offset + within;
    const auto record = read_mcap_record(chunk.cursor);
    if (!record) {
      if (!chunk.cut) {
        state_.lose(1, offset,
                    "record is longer than its chunk; the rest of the chunk is left out");
      }
      break;
    }
    if (chunk.cut && cut_at_ && !chunk.packed) last_whole_ = chunk.data_offset + chunk.cursor.at();
    if (record->op == McapOp::kMessage) {
      if (take_message(record->content, offset, out)) return true;
    } else {
      take_definition(*record);
    }
  }
  chunk_.reset();
  return false;
}

bool McapReader::take_message(std::span<const std::byte> content, std::uint64_t offset,
                              RawMessage& out) {
  const auto message = mcap_message(content);
  const auto topic = message ? topic_of_channel_.find(message->channel) : topic_of_channel_.end();
  if (topic == topic_of_channel_.end()) {
    state_.lose(1, offset,
                message ? fmt::format("message of unknown channel {}; left out", message->channel)
                        : std::string("message too short for its header; left out"));
    return false;
  }
  return state_.hand_out(topic->second, time_of_ns(message->log_ns), offset,
                         content.subspan(McapMessageHeader::kBytes), out);
}

void McapReader::finish() {
  if (done_) return;
  done_ = true;
  if (data_end_ && !cut_at_) {
    state_.expect(promised_);
    return report_more();
  }
  state_.health.truncated = true;
  state_.health.bytes_lost = source_->size() - std::min(last_whole_, source_->size());
  const std::uint64_t at = cut_at_.value_or(source_->size());
  const auto why = cut_at_ ? state_.why_cut(*source_, window_, at)
                           : Result<std::string>("the file ends before its last record. ");
  state_.find(Severity::kWarning, "io.cut", at,
              why.value_or("cannot be read on. ") + state_.read_so_far(last_whole_, 0));
}

/// Reports data after the end of a closed recording: zeros from a failing disk, or another
/// recording.
void McapReader::report_more() {
  if (!state_.health.unindexed) return;  // the footer is the last thing in the file
  const auto end = end_of_mcap(*source_, window_, *data_end_);
  if (!end || !*end || **end >= source_->size()) return;
  state_.health.truncated = true;
  state_.health.bytes_lost = source_->size() - **end;
  const auto what = state_.what_more(*source_, window_, **end);
  state_.find(Severity::kWarning, "io.cut", **end,
              what.value_or("cannot be read on. ") + state_.read_so_far(**end, 0));
}

}  // namespace

Result<std::unique_ptr<MessageSource>> open_mcap(std::shared_ptr<ByteSource> source,
                                                 const ReadLimits& limits) {
  const auto known = starts_with(*source, kMcapMagic);
  if (!known) return tl::make_unexpected(known.error());
  if (!*known) {
    return fail(ErrorCode::kInput, source->name(), "not an MCAP file of format 0");
  }
  auto reader = std::make_unique<McapReader>(std::move(source), limits);
  if (const Status status = reader->start(true); !status)
    return tl::make_unexpected(status.error());
  return reader;
}

}  // namespace rali::io
