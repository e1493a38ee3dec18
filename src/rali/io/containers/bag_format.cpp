#include "rali/io/containers/bag_format.hpp"

namespace rali::io {
namespace {

/// Splits off the next "length, name=value"; none at the end or if damaged.
struct Field {
  std::string_view name;
  std::span<const std::byte> value;
};

std::optional<Field> next_field(Cursor& cursor) {
  const auto field = cursor.bytes32();
  if (!cursor.ok()) return std::nullopt;
  const std::string_view text = text_of(field);
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) return std::nullopt;
  return Field{text.substr(0, equals), field.subspan(equals + 1)};
}

}  // namespace

std::optional<BagFields> BagFields::parse(std::span<const std::byte> header) {
  Cursor cursor(header);
  while (cursor.left() > 0) {
    if (!next_field(cursor)) return std::nullopt;
  }
  BagFields fields;
  fields.header_ = header;
  const auto op = fields.find("op");
  if (!op || op->size() != 1) return std::nullopt;
  fields.op_ = static_cast<BagOp>(std::to_integer<std::uint8_t>(op->front()));
  return fields;
}

std::optional<std::span<const std::byte>> BagFields::find(std::string_view name) const {
  Cursor cursor(header_);
  while (cursor.left() > 0) {
    const auto field = next_field(cursor);
    if (!field) return std::nullopt;
    if (field->name == name) return field->value;
  }
  return std::nullopt;
}

std::string_view BagFields::text(std::string_view name) const {
  const auto value = find(name);
  return value ? text_of(*value) : std::string_view();
}

std::optional<std::uint32_t> BagFields::u32(std::string_view name) const {
  const auto value = find(name);
  if (!value || value->size() != 4) return std::nullopt;
  return Cursor(*value).u32();
}

std::optional<std::uint64_t> BagFields::u64(std::string_view name) const {
  const auto value = find(name);
  if (!value || value->size() != 8) return std::nullopt;
  return Cursor(*value).u64();
}

std::optional<Time> BagFields::time(std::string_view name) const {
  const auto value = find(name);
  if (!value || value->size() != 8) return std::nullopt;
  Cursor cursor(*value);
  const std::int64_t seconds = cursor.u32();
  const std::int64_t nanoseconds = cursor.u32();
  return Time::from_ns(seconds * 1'000'000'000 + nanoseconds);
}

std::optional<BagRecord> read_bag_record(Cursor& cursor) {
  const std::uint32_t header_bytes = cursor.u32();
  if (header_bytes > kBagHeaderBytesMax) return std::nullopt;
  const auto header = cursor.bytes(header_bytes);
  const auto data = cursor.bytes32();
  if (!cursor.ok()) return std::nullopt;
  const auto fields = BagFields::parse(header);
  if (!fields) return std::nullopt;
  return BagRecord{*fields, data};
}

std::optional<std::pair<std::uint32_t, Topic>> bag_connection(const BagRecord& record) {
  const auto number = record.fields.u32("conn");
  if (!number) return std::nullopt;
  Topic topic;
  topic.name = record.fields.text("topic");
  topic.encoding = wire::Encoding::kRos1;
  topic.encoding_name = "ros1";
  Cursor cursor(record.data);
  while (cursor.left() > 0) {
    const auto field = next_field(cursor);
    if (!field) return std::nullopt;
    if (field->name == "type") topic.type = text_of(field->value);
    if (field->name == "message_definition") topic.definition = text_of(field->value);
    if (field->name == "topic" && topic.name.empty()) topic.name = text_of(field->value);
  }
  if (topic.name.empty() || topic.type.empty()) return std::nullopt;
  return std::make_pair(*number, std::move(topic));
}

}  // namespace rali::io
