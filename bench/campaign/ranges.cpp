#include "ranges.hpp"

#include <cmath>
#include <fstream>
#include <sstream>

#include "rali/base/assert.hpp"

namespace rali::campaign {

using config::Node;

namespace {

double number_of(std::string_view text) {
  double value = 0.0;
  RALI_ASSERT(config::parse_double(text, value));
  return value;
}

/// "log [a, b]" is one scalar in YAML.
bool parse_log(const std::string& text, double& low, double& high) {
  if (text.rfind("log [", 0) != 0 || text.back() != ']') return false;
  const std::size_t comma = text.find(',');
  RALI_ASSERT(comma != std::string::npos);
  low = number_of(std::string_view(text).substr(5, comma - 5));
  const std::size_t second = text.find_first_not_of(' ', comma + 1);
  high = number_of(std::string_view(text).substr(second, text.size() - 1 - second));
  return true;
}

}  // namespace

Result<Ranges> Ranges::load(const std::string& path) {
  std::ifstream file(path);
  if (!file) return fail(ErrorCode::kInput, path, "cannot be read");
  std::stringstream text;
  text << file.rdbuf();
  Ranges out;
  out.hash_ = 0xcbf29ce484222325ULL;
  for (const char c : text.str()) {
    out.hash_ = (out.hash_ ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  Result<Node> root = config::parse_yaml(text.str(), path);
  if (!root) return tl::make_unexpected(root.error());
  out.root_ = std::move(*root);
  return out;
}

const Node& Ranges::at(std::string_view key) const {
  const Node* node = &root_;
  while (!key.empty()) {
    const std::size_t dot = key.find('.');
    node = node->find(key.substr(0, dot));
    RALI_ASSERT(node != nullptr);
    key = dot == std::string_view::npos ? std::string_view{} : key.substr(dot + 1);
  }
  return *node;
}

double Ranges::number(std::string_view key, Rng& rng) const {
  const Node& node = at(key);
  double low = 0.0;
  double high = 0.0;
  if (node.kind == Node::Kind::kScalar && parse_log(node.text, low, high)) {
    return low * std::exp(rng.uniform() * std::log(high / low));
  }
  RALI_ASSERT(node.kind == Node::Kind::kSequence && node.children.size() == 2);
  return rng.uniform(number_of(node.children[0].text), number_of(node.children[1].text));
}

int Ranges::count(std::string_view key, Rng& rng) const {
  return static_cast<int>(std::lround(number(key, rng)));
}

bool Ranges::happens(std::string_view key, Rng& rng) const {
  return rng.uniform() < number_of(at(key).text);
}

std::string Ranges::choice(std::string_view key, Rng& rng) const {
  const Node& node = at(key);
  double sum = 0.0;
  for (const Node& child : node.children) sum += number_of(child.text);
  double left = rng.uniform() * sum;
  for (const Node& child : node.children) {
    left -= number_of(child.text);
    if (left < 0.0) return child.key;
  }
  return node.children.back().key;
}

}  // namespace rali::campaign
