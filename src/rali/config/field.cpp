#include "rali/config/field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace rali::config {
namespace {

template <class... Fs>
struct Overloaded : Fs... {
  using Fs::operator()...;
};
template <class... Fs>
Overloaded(Fs...) -> Overloaded<Fs...>;

tl::unexpected<Error> refuse(const Field& field, const Node& node, std::string_view is) {
  return fail(ErrorCode::kUsage, node.where,
              fmt::format("{} {}; allowed is {}", field.key, is, allowed_text(field)));
}

Result<double> number(const Field& field, const Node& node) {
  double value = 0.0;
  if (node.kind != Node::Kind::kScalar || node.quoted || !parse_double(node.text, value)) {
    return refuse(field, node, describe_value(node));
  }
  if (!(value >= field.min && value <= field.max)) return refuse(field, node, describe_value(node));
  return value;
}

template <class I>
Status integer(const Field& field, const Node& node, I* target) {
  long long value = 0;
  if (node.kind != Node::Kind::kScalar || node.quoted || !parse_integer(node.text, value)) {
    return refuse(field, node, describe_value(node));
  }
  const auto as_double = static_cast<double>(value);
  if (as_double < field.min || as_double > field.max)
    return refuse(field, node, describe_value(node));
  const auto low = static_cast<double>(std::numeric_limits<I>::lowest());
  const auto high = static_cast<double>(std::numeric_limits<I>::max());
  if (as_double < low || as_double > high) return refuse(field, node, describe_value(node));
  *target = static_cast<I>(value);
  return {};
}

Status array(const Field& field, const Node& node, std::span<double> target) {
  if (node.kind != Node::Kind::kSequence || node.children.size() != target.size()) {
    return refuse(field, node, describe_value(node));
  }
  std::vector<double> values;
  for (const Node& child : node.children) {
    const Result<double> value = number(field, child);
    if (!value) return tl::make_unexpected(value.error());
    values.push_back(*value);
  }
  std::copy(values.begin(), values.end(), target.begin());
  return {};
}

Status boolean(const Field& field, const Node& node, bool* target) {
  if (node.kind != Node::Kind::kScalar || node.quoted ||
      (node.text != "true" && node.text != "false")) {
    return refuse(field, node, describe_value(node));
  }
  *target = node.text == "true";
  return {};
}

Status one_of(const Field& field, const Node& node, const ChoiceTarget& choice) {
  for (std::size_t i = 0; node.kind == Node::Kind::kScalar && i < choice.names.size(); ++i) {
    if (node.text == choice.names[i]) {
      choice.set(i);
      return {};
    }
  }
  return refuse(field, node, describe_value(node));
}

std::string bounds_text(const Field& field) {
  return fmt::format("{} to {}", yaml_number(field.min), yaml_number(field.max));
}

}  // namespace

std::string describe_value(const Node& node) {
  if (node.kind == Node::Kind::kNull) return "is empty";
  if (node.kind == Node::Kind::kMap) return "is a group of keys";
  if (node.kind == Node::Kind::kSequence)
    return fmt::format("is a list of {}", node.children.size());
  const std::string text = node.text.substr(0, 60);
  const bool printable =
      std::all_of(text.begin(), text.end(), [](unsigned char c) { return c >= 0x20 && c != 0x7f; });
  return "is " + (node.quoted || !printable ? yaml_quoted(text) : text);
}

Status decode_field(const Field& field, const Node& node) {
  const auto visitor = Overloaded{
      [&](double* target) -> Status {
        const Result<double> value = number(field, node);
        if (!value) return tl::make_unexpected(value.error());
        *target = *value;
        return {};
      },
      [&](int* target) -> Status { return integer(field, node, target); },
      [&](std::size_t* target) -> Status { return integer(field, node, target); },
      [&](bool* target) -> Status { return boolean(field, node, target); },
      [&](std::string* target) -> Status {
        if (node.kind != Node::Kind::kScalar) return refuse(field, node, describe_value(node));
        *target = node.text;
        return {};
      },
      [&](std::span<double> target) -> Status { return array(field, node, target); },
      [&](const ChoiceTarget& choice) -> Status { return one_of(field, node, choice); },
      [&](const CustomTarget& custom) -> Status { return custom.decode(node, field.key); }};
  return std::visit(visitor, field.target);
}

std::string encode_field(const Field& field) {
  const auto visitor = Overloaded{
      [](const double* value) { return yaml_number(*value); },
      [](const int* value) { return fmt::format("{}", *value); },
      [](const std::size_t* value) { return fmt::format("{}", *value); },
      [](const bool* value) { return std::string(*value ? "true" : "false"); },
      [](const std::string* value) { return yaml_quoted(*value); },
      [](std::span<const double> values) {
        std::string text = "[";
        for (const double value : values)
          text += (text.size() > 1 ? ", " : "") + yaml_number(value);
        return text + "]";
      },
      [](const ChoiceTarget& choice) { return std::string(choice.names.at(choice.get())); },
      [](const CustomTarget& custom) { return custom.encode(); }};
  return std::visit(visitor, field.target);
}

std::string allowed_text(const Field& field) {
  const auto visitor = Overloaded{
      [&](const double* /*value*/) { return bounds_text(field); },
      [&](const int* /*value*/) { return bounds_text(field) + ", whole"; },
      [&](const std::size_t* /*value*/) { return bounds_text(field) + ", whole"; },
      [](const bool* /*value*/) { return std::string("true or false"); },
      [](const std::string* /*value*/) { return std::string("a word"); },
      [&](std::span<const double> values) {
        return fmt::format("a list of {} numbers, each {}", values.size(), bounds_text(field));
      },
      [](const ChoiceTarget& choice) { return fmt::format("{}", fmt::join(choice.names, ", ")); },
      [](const CustomTarget& custom) { return custom.type; }};
  return std::visit(visitor, field.target);
}

}  // namespace rali::config
