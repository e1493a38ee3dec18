#pragma once

#include <map>
#include <string>
#include <vector>

#include "rali/config/apply.hpp"
#include "rali/config/codecs.hpp"
#include "rali/config/field.hpp"
#include "rali/sim/floor_plan/polygon.hpp"

namespace rali::scenario {

/// Corners [[x, y], ...] whose last one repeats the first; stored without the repetition.
/// Errors: not a list of pairs; open; polygon_fault().
[[nodiscard]] config::CustomTarget ring(sim::Polygon& polygon);

/// A path [[x, y], ...] or [[x, y, z], ...], empty or at least two points; z is NaN where not
/// given.
[[nodiscard]] config::CustomTarget path(std::vector<geometry::Vec3>& points);

/// [x, y] or [x, y, z]; NaN where not given.
[[nodiscard]] config::CustomTarget place(geometry::Vec3& point);

/// The same field; also stores the file:line of its value.
[[nodiscard]] config::CustomTarget noting(config::CustomTarget target, std::string& where);

/// {name: number, ...}, each 0 to 1.
[[nodiscard]] config::CustomTarget reflectivities(std::map<std::string, double>& values);

/// The points as YAML.
[[nodiscard]] std::string encode_path(const std::vector<geometry::Vec3>& points);

/// Reads [[x, y], ...] or [[x, y, z], ...]; see path().
[[nodiscard]] Status decode_path(const config::Node& node, const std::string& key,
                                 std::vector<geometry::Vec3>& points);

/// "{key: value, ...}" of fields, without empty ones.
[[nodiscard]] std::string encode_fields(const config::FieldList& fields, std::size_t prefix);

/// A list of groups of keys, each a struct with visit(); sets its member `where`, if any.
template <class T>
[[nodiscard]] config::CustomTarget list_of(std::vector<T>& items) {
  config::CustomTarget target;
  target.type = "a list of groups of keys";
  target.decode = [&items, type = target.type](const config::Node& node,
                                               const std::string& key) -> Status {
    if (node.kind != config::Node::Kind::kSequence) return config::not_allowed(node, key, type);
    items.clear();
    for (const config::Node& child : node.children) {
      T item;
      config::FieldList fields;
      config::Origins origins;
      config::collect_fields(key + '.', item, fields);
      if (auto status = config::apply_map(child, key + '.', "", fields, origins); !status) {
        return status;
      }
      if constexpr (requires { item.where; }) item.where = child.where;
      items.push_back(std::move(item));
    }
    return {};
  };
  target.encode = [&items] {
    std::string text = "[";
    for (T& item : items) {
      config::FieldList fields;
      config::collect_fields("", item, fields);
      text += (text.size() > 1 ? ", " : "") + encode_fields(fields, 0);
    }
    return text + "]";
  };
  return target;
}

}  // namespace rali::scenario
