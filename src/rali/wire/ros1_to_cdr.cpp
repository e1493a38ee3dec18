#include "rali/wire/ros1_to_cdr.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace rali::wire {
namespace {

constexpr std::size_t kDefinitionBytesMax = 1 << 20;
constexpr std::size_t kFixedMax = 1 << 20;  ///< elements of a fixed array
constexpr std::size_t kDepthMax = 32;
constexpr std::size_t kBytesMinMax = std::size_t{1} << 30;
constexpr std::size_t kTimeBytes = 8;    ///< two of 4: seconds, nanoseconds
constexpr std::size_t kLengthBytes = 4;  ///< of strings and sequences
constexpr std::string_view kHeader = "std_msgs/Header";
constexpr const char* kBlanks = " \t\r";

constexpr std::array<std::pair<std::string_view, std::size_t>, 13> kPlain{{{"bool", 1},
                                                                           {"int8", 1},
                                                                           {"uint8", 1},
                                                                           {"byte", 1},
                                                                           {"char", 1},
                                                                           {"int16", 2},
                                                                           {"uint16", 2},
                                                                           {"int32", 4},
                                                                           {"uint32", 4},
                                                                           {"float32", 4},
                                                                           {"int64", 8},
                                                                           {"uint64", 8},
                                                                           {"float64", 8}}};

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// "float64" and 9 of "float64[9]".
struct Declared {
  std::string_view type, name;
  std::string_view brackets;  ///< between them; has_brackets separates "" from none
  bool has_brackets = false;
};

/// The field in a line; nothing for blank lines, comments and constants.
std::optional<Declared> parse_line(std::string_view line) {
  line = trimmed(line.substr(0, line.find('#')));
  const std::size_t type_end = line.find_first_of(kBlanks);
  if (line.empty()) return std::nullopt;
  Declared out;
  out.type = line.substr(0, type_end);
  if (type_end != std::string_view::npos) out.name = trimmed(line.substr(type_end));
  if (out.name.find('=') != std::string_view::npos) return std::nullopt;
  const std::size_t open = out.type.find('[');
  if (open != std::string_view::npos && out.type.ends_with(']')) {
    out.brackets = out.type.substr(open + 1, out.type.size() - open - 2);
    out.type = out.type.substr(0, open);
    out.has_brackets = true;
  }
  return out;
}

}  // namespace

/// Reads the definitions of a type and of the types it contains.
class Ros1ToCdr::Parser {
 public:
  Parser(std::string_view type, std::string_view definition) : where_(type) {
    std::string name(type);
    std::string_view* body = &sections_[name];
    const std::vector<std::string_view> lines = lines_of(definition);
    for (const std::string_view line : lines) {
      const std::string_view text = trimmed(line);
      if (text.starts_with("MSG:")) {
        name = std::string(trimmed(text.substr(4)));
        body = &sections_[name];
        *body = {};
      } else if (!text.starts_with("====")) {
        const char* begin = body->empty() ? line.data() : body->data();
        *body = {begin, static_cast<std::size_t>(line.data() + line.size() - begin)};
      }
    }
  }

  /// Index of a message of the result.
  Result<std::size_t> message(const std::string& type) {
    if (const auto known = made_.find(type); known != made_.end()) return known->second;
    const auto section = sections_.find(type);
    if (section == sections_.end()) return refuse("no definition of " + type);
    if (!open_.insert(type).second) return refuse(type + " contains itself");
    if (open_.size() > kDepthMax) return refuse("messages within messages without end");
    Message out;
    for (const std::string_view line : lines_of(section->second)) {
      const auto declared = parse_line(line);
      if (!declared) continue;
      auto field = parse_field(*declared, type);
      if (!field) return tl::make_unexpected(field.error());
      const std::size_t n = field->count == Count::kFixed ? field->n : 1;
      out.bytes_min += field->count == Count::kAny ? kLengthBytes : n * field->bytes;
      if (out.bytes_min > kBytesMinMax) return refuse(type + " is too large");
      out.fields.push_back(*field);
    }
    open_.erase(type);
    messages.push_back(std::move(out));
    made_[type] = messages.size() - 1;
    return messages.size() - 1;
  }

  std::vector<Message> messages;

 private:
  [[nodiscard]] tl::unexpected<Error> refuse(const std::string& what) const {
    return fail(ErrorCode::kInput, where_, "its definition is not usable: " + what);
  }

  Result<Field> parse_field(const Declared& declared, const std::string& parent) {
    Field field;
    if (declared.name.empty()) return refuse("a line without a name");
    field.dropped = parent == kHeader && declared.name == "seq";
    if (declared.has_brackets) {
      field.count = declared.brackets.empty() ? Count::kAny : Count::kFixed;
      const char* end = declared.brackets.data() + declared.brackets.size();
      const auto [stop, error] = std::from_chars(declared.brackets.data(), end, field.n);
      const bool is_number = error == std::errc() && stop == end && field.n <= kFixedMax;
      if (field.count == Count::kFixed && !is_number) return refuse("an array of no size");
    }
    for (const auto& [name, bytes] : kPlain) {
      if (declared.type != name) continue;
      field.bytes = bytes;
      return field;
    }
    if (declared.type == "time" || declared.type == "duration") {
      field.kind = Kind::kTime;
      field.bytes = kTimeBytes;
      return field;
    }
    if (declared.type == "string") {
      field.kind = Kind::kString;
      field.bytes = kLengthBytes;
      return field;
    }
    return parse_message_field(std::move(field), std::string(declared.type), parent);
  }

  Result<Field> parse_message_field(Field field, std::string type, const std::string& parent) {
    if (type == "Header") {
      type = kHeader;
    } else if (type.find('/') == std::string::npos) {
      type = parent.substr(0, parent.find('/') + 1) + type;  // of the same package
    }
    const auto index = message(type);
    if (!index) return tl::make_unexpected(index.error());
    field.kind = Kind::kMessage;
    field.message = *index;
    field.bytes = messages[*index].bytes_min;
    // Fields without bytes would allow unbounded work on a message.
    if (field.bytes == 0) return refuse(type + " within " + parent + " has no fields");
    return field;
  }

  std::string where_;
  std::map<std::string, std::string_view> sections_;
  std::map<std::string, std::size_t> made_;
  std::set<std::string> open_;
};

Result<Ros1ToCdr> Ros1ToCdr::make(std::string_view type_name, std::string_view definition) {
  if (definition.size() > kDefinitionBytesMax) {
    return fail(ErrorCode::kInput, std::string(type_name), "has a definition of over 1 MiB");
  }
  Parser parser(type_name, definition);
  const auto root = parser.message(std::string(type_name));
  if (!root) return tl::make_unexpected(root.error());
  Ros1ToCdr out;
  out.type_ = type_name;
  out.messages_ = std::move(parser.messages);
  out.root_ = *root;
  return out;
}

Result<Bytes> Ros1ToCdr::convert(std::span<const std::byte> message) const {
  ByteReader in(message, Encoding::kRos1);
  ByteWriter out(Encoding::kCdr);
  out.reserve(message.size() + message.size() / 8 + 64);
  copy(messages_[root_], in, out);
  if (!in.ok()) return tl::make_unexpected(in.error(type_));
  return out.take();
}

void Ros1ToCdr::copy(const Message& message, ByteReader& in, ByteWriter& out) const {
  if (message.fields.empty()) out.put(std::uint8_t{0});  // ROS 2: structures are never empty
  for (const Field& field : message.fields) {
    if (!in.ok()) return;
    copy(field, in, out);
  }
}

void Ros1ToCdr::copy(const Field& field, ByteReader& in, ByteWriter& out) const {
  if (field.dropped) {
    in.skip(field.bytes);
    return;
  }
  std::size_t n = field.n;
  if (field.count == Count::kOne) n = 1;
  if (field.count == Count::kAny) {
    n = in.sequence(field.bytes);
    out.sequence(n);
  }
  copy_elements(field, n, in, out);
}

void Ros1ToCdr::copy_elements(const Field& field, std::size_t n, ByteReader& in,
                              ByteWriter& out) const {
  if (n == 0) return;
  if (field.kind == Kind::kPlain || field.kind == Kind::kTime) {
    // Both are little endian, and elements of one size are contiguous.
    out.align(field.kind == Kind::kTime ? kTimeBytes / 2 : field.bytes);
    out.bytes(in.bytes(n * field.bytes));
    return;
  }
  for (std::size_t i = 0; i < n && in.ok(); ++i) {
    if (field.kind == Kind::kString) {
      out.string(in.string());
    } else {
      copy(messages_[field.message], in, out);
    }
  }
}

}  // namespace rali::wire
