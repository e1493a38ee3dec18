#include "rali/config/yaml_tree.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

namespace rali::config {
namespace {

/// Exception to leave yaml-cpp's parser; always caught in this file.
struct Refused {
  Error error;
};

/// Builds our tree from yaml-cpp's events, so that depth and size are bounded while reading.
class TreeBuilder final : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::string_view name) : name_(name) {}

  Node root;

  void OnDocumentStart(const YAML::Mark& /*mark*/) override {}

  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Node node = make(Node::Kind::kNull, mark);
    finish(std::move(node), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) refuse(mark, "an alias names a value that is not complete yet");
    Node node = found->second;
    count_ += size_of(node);
    check_count(mark);
    node.key.clear();
    node.key_where.clear();
    finish(std::move(node), YAML::NullAnchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Node node = make(Node::Kind::kScalar, mark);
    node.text = value;
    node.quoted = tag == "!";  // yaml-cpp's mark of a quoted scalar
    finish(std::move(node), anchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    open(Node::Kind::kSequence, mark, anchor);
  }

  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    open(Node::Kind::kMap, mark, anchor);
  }

  void OnMapEnd() override { close(); }

 private:
  struct Open {
    Node node;
    YAML::anchor_t anchor = YAML::NullAnchor;
    bool have_key = false;
    Node key;
    std::map<std::string, std::string> seen;  // key -> where
  };

  [[nodiscard]] std::string at(const YAML::Mark& mark) const {
    return fmt::format("{}:{}", name_, mark.line + 1);
  }

  [[noreturn]] void refuse(const YAML::Mark& mark, std::string what,
                           std::string remedy = {}) const {
    throw Refused{{ErrorCode::kUsage, std::move(what), at(mark), std::move(remedy)}};
  }

  void check_count(const YAML::Mark& mark) const {
    if (count_ > kMaxYamlNodes) {
      refuse(mark, fmt::format("more than {} values", kMaxYamlNodes));
    }
  }

  [[nodiscard]] static std::size_t size_of(const Node& node) {
    std::size_t n = 1;
    for (const Node& child : node.children) n += size_of(child);
    return n;
  }

  Node make(Node::Kind kind, const YAML::Mark& mark) {
    ++count_;
    check_count(mark);
    Node node;
    node.kind = kind;
    node.where = at(mark);
    return node;
  }

  void open(Node::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (stack_.size() >= static_cast<std::size_t>(kMaxYamlDepth)) {
      refuse(mark, fmt::format("nested deeper than {} levels", kMaxYamlDepth));
    }
    if (!stack_.empty() && stack_.back().node.kind == Node::Kind::kMap && !stack_.back().have_key) {
      refuse(mark, "a key must be a plain word");
    }
    Open opened;
    opened.node = make(kind, mark);
    opened.anchor = anchor;
    stack_.push_back(std::move(opened));
  }

  void close() {
    Node node = std::move(stack_.back().node);
    const YAML::anchor_t anchor = stack_.back().anchor;
    stack_.pop_back();
    finish(std::move(node), anchor);
  }

  void finish(Node node, YAML::anchor_t anchor) {
    if (anchor != YAML::NullAnchor) anchors_[anchor] = node;
    if (stack_.empty()) {
      root = std::move(node);
      return;
    }
    Open& parent = stack_.back();
    if (parent.node.kind == Node::Kind::kSequence) {
      parent.node.children.push_back(std::move(node));
      return;
    }
    if (!parent.have_key) {
      take_key(parent, std::move(node));
      return;
    }
    node.key = parent.key.text;
    node.key_where = parent.key.where;
    parent.have_key = false;
    parent.node.children.push_back(std::move(node));
  }

  static void take_key(Open& parent, Node key) {
    if (key.kind != Node::Kind::kScalar || key.text.empty()) {
      throw Refused{{ErrorCode::kUsage, "a key must be a plain word", key.where, ""}};
    }
    const auto [seen, is_new] = parent.seen.emplace(key.text, key.where);
    if (!is_new) {
      throw Refused{{ErrorCode::kUsage,
                     fmt::format("key '{}' is given twice (first at {})", key.text, seen->second),
                     key.where, "Remove one of them."}};
    }
    parent.key = std::move(key);
    parent.have_key = true;
  }

  std::string name_;
  std::vector<Open> stack_;
  std::map<YAML::anchor_t, Node> anchors_;
  std::size_t count_ = 0;
};

std::string plain_reason(const std::string& yaml_message) {
  return yaml_message.empty() ? std::string("cannot be read as YAML")
                              : "not valid YAML: " + yaml_message;
}

}  // namespace

const Node* Node::find(std::string_view name) const {
  for (const Node& child : children) {
    if (kind == Kind::kMap && child.key == name) return &child;
  }
  return nullptr;
}

Result<Node> parse_yaml(std::string_view text, std::string_view name) {
  if (text.size() > kMaxYamlBytes) {
    return fail(
        ErrorCode::kUsage, std::string(name),
        fmt::format("{} bytes; a settings file has at most {}", text.size(), kMaxYamlBytes));
  }
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
    return fail(ErrorCode::kUsage, fmt::format("{}:offset {}", name, zero),
                "a zero byte: this is no text file");
  }
  TreeBuilder builder(name);
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    if (parser.HandleNextDocument(builder)) {
      TreeBuilder second(name);
      if (parser.HandleNextDocument(second)) {
        return fail(ErrorCode::kUsage,
                    second.root.where.empty() ? std::string(name) : second.root.where,
                    "a second YAML document", "Keep one document per file.");
      }
    }
  } catch (const Refused& refused) {
    return tl::make_unexpected(refused.error);
  } catch (const YAML::Exception& e) {
    return fail(ErrorCode::kUsage, fmt::format("{}:{}", name, e.mark.line + 1),
                plain_reason(e.msg));
  } catch (const std::exception& e) {
    return fail(ErrorCode::kUsage, std::string(name), plain_reason(e.what()));
  }
  if (builder.root.kind == Node::Kind::kNull) {
    builder.root.kind = Node::Kind::kMap;
    builder.root.where = std::string(name);
  }
  return std::move(builder.root);
}

Result<Node> parse_yaml_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(ErrorCode::kInput, path, "cannot be opened");
  std::string text(kMaxYamlBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) return fail(ErrorCode::kInput, path, "cannot be read");
  text.resize(static_cast<std::size_t>(file.gcount()));
  return parse_yaml(text, path);
}

std::string yaml_quoted(std::string_view text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./+-";
  double number = 0.0;
  const bool plain = !text.empty() && text.find_first_not_of(kPlain) == std::string_view::npos &&
                     text.front() != '-' && text != "null" && text != "Null" && text != "NULL" &&
                     !parse_double(text, number);
  if (plain) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += fmt::format("\\x{:02x}", static_cast<unsigned>(byte));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string yaml_number(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  return fmt::format("{}", value);
}

bool parse_double(std::string_view text, double& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  if (text == ".inf" || text == "inf" || text == ".Inf") {
    value = std::numeric_limits<double>::infinity();
    return true;
  }
  if (text == "-.inf" || text == "-inf" || text == "-.Inf") {
    value = -std::numeric_limits<double>::infinity();
    return true;
  }
  // from_chars would also accept "nan" and "infinity"; a digit is required.
  if (text.find_first_of("0123456789") == std::string_view::npos) return false;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc() && end == text.data() + text.size() && !std::isnan(value);
}

bool parse_integer(std::string_view text, long long& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc() && end == text.data() + text.size();
}

}  // namespace rali::config
