#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/settings.hpp"
#include "rali/config/yaml_tree.hpp"

namespace rali::config {

/// An enumeration with its type erased.
struct ChoiceTarget {
  std::vector<std::string_view> names;
  std::function<std::size_t()> get;
  std::function<void(std::size_t)> set;
};

/// A value with its own syntax (a pose, `auto` or a number, a list).
struct CustomTarget {
  std::string type;  ///< allowed values, for the manual
  /// Stores the value. `key` is the full name, for messages.
  std::function<Status(const Node& node, const std::string& key)> decode;
  std::function<std::string()> encode;  ///< one line of YAML that decodes to the same value
};

/// Where a value is kept.
using Target = std::variant<double*, int*, std::size_t*, bool*, std::string*, std::span<double>,
                            ChoiceTarget, CustomTarget>;

/// Public settings keep their names; unstable ones may change with any release.
enum class Visibility { kUnstable, kPublic };

/// One setting: its full name, where its value is stored, and its allowed values.
struct Field {
  std::string key;  ///< "odometry.imu_noise.gyro_radps_rthz"
  Target target;
  double min = 0.0, max = 0.0;  ///< bounds of numbers, inclusive
  std::string help;
  Visibility visibility = Visibility::kUnstable;
  std::string group_help = {};  ///< purpose of the key's innermost group
};

using FieldList = std::vector<Field>;

/// Origin of each value that is not a default, by full key: "preset paper", "fleet.yaml:14",
/// "command line".
using Origins = std::map<std::string, std::string>;

/// The visitor of base/settings.hpp: turns a settings struct into a flat list of fields that
/// point into it. The struct must outlive the list and stay where it is.
class FieldCollector {
 public:
  FieldCollector(std::string prefix, FieldList& fields, std::string group_help = {})
      : prefix_(std::move(prefix)), fields_(&fields), group_help_(std::move(group_help)) {}

  void operator()(std::string_view key, double& value, double min, double max,
                  std::string_view help) {
    add(key, &value, min, max, help);
  }

  void operator()(std::string_view key, int& value, double min, double max, std::string_view help) {
    add(key, &value, min, max, help);
  }

  void operator()(std::string_view key, std::size_t& value, double min, double max,
                  std::string_view help) {
    add(key, &value, min, max, help);
  }

  template <std::size_t N>
  void operator()(std::string_view key, std::array<double, N>& value, double min, double max,
                  std::string_view help) {
    add(key, std::span<double>(value), min, max, help);
  }

  void operator()(std::string_view key, bool& value, std::string_view help) {
    add(key, &value, 0.0, 0.0, help);
  }

  void operator()(std::string_view key, std::string& value, std::string_view help) {
    add(key, &value, 0.0, 0.0, help);
  }

  template <class E, std::size_t N>
  void choice(std::string_view key, E& value, const ChoiceNames<N>& names, std::string_view help) {
    ChoiceTarget target;
    target.names.assign(names.begin(), names.end());
    target.get = [&value] { return static_cast<std::size_t>(value); };
    target.set = [&value](std::size_t i) { value = static_cast<E>(i); };
    add(key, std::move(target), 0.0, 0.0, help);
  }

  void custom(std::string_view key, CustomTarget target, std::string_view help) {
    add(key, std::move(target), 0.0, 0.0, help);
  }

  template <class S>
  void group(std::string_view key, S& settings, std::string_view help) {
    FieldCollector inner(prefix_ + std::string(key) + '.', *fields_, std::string(help));
    settings.visit(inner);
  }

 private:
  void add(std::string_view key, Target target, double min, double max, std::string_view help) {
    fields_->push_back({prefix_ + std::string(key), std::move(target), min, max, std::string(help),
                        Visibility::kUnstable, group_help_});
  }

  std::string prefix_;
  FieldList* fields_;
  std::string group_help_;
};

/// The fields of one settings struct, named `prefix` + key; prefix is "" or ends with a dot.
template <class S>
void collect_fields(std::string prefix, S& settings, FieldList& fields) {
  FieldCollector collector(std::move(prefix), fields);
  settings.visit(collector);
}

/// Stores a YAML value in a field.
/// Errors (kUsage, where = position of the value): wrong type, not a number, out of bounds,
/// not one of the names.
[[nodiscard]] Status decode_field(const Field& field, const Node& node);

/// The field's value as one line of YAML; decode_field of it gives the same value.
[[nodiscard]] std::string encode_field(const Field& field);

/// Describes a wrong value: "is 7.5", "is empty", "is a list of 2"; shortened, so that a message
/// stays one line.
[[nodiscard]] std::string describe_value(const Node& node);

/// The allowed values: "0.1 to 10", "true or false", "robust, paper".
[[nodiscard]] std::string allowed_text(const Field& field);

}  // namespace rali::config
