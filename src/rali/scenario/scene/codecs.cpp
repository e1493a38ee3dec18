#include "rali/scenario/scene/codecs.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace rali::scenario {

using config::CustomTarget;
using config::Node;
using geometry::Vec2;
using geometry::Vec3;

namespace {

constexpr double kFarthest_m = 1e5;
constexpr std::string_view kPointType =
    "a point [x, y] or [x, y, z] in metres, at most 100 km away";

/// The numbers of a point; empty if it is not a point.
std::vector<double> numbers_of(const Node& node) {
  std::vector<double> values;
  if (node.kind != Node::Kind::kSequence || node.children.size() > 3) return {};
  for (const Node& child : node.children) {
    double value = 0.0;
    if (child.kind != Node::Kind::kScalar || child.quoted) return {};
    if (!config::parse_double(child.text, value) || !(std::abs(value) <= kFarthest_m)) return {};
    values.push_back(value);
  }
  return values;
}

Status decode_point(const Node& node, const std::string& key, Vec3& point) {
  const std::vector<double> values = numbers_of(node);
  if (values.size() < 2) return config::not_allowed(node, key, std::string(kPointType));
  const double z = values.size() == 3 ? values[2] : std::numeric_limits<double>::quiet_NaN();
  point = {values[0], values[1], z};
  return {};
}

std::string encode_point(const Vec3& p) {
  const std::array<double, 3> values{p.x(), p.y(), p.z()};
  return config::encode_list(std::span(values).first(std::isnan(p.z()) ? 2 : 3));
}

}  // namespace

std::string encode_path(const std::vector<Vec3>& points) {
  std::string text = "[";
  for (const Vec3& p : points) text += (text.size() > 1 ? ", " : "") + encode_point(p);
  return text + "]";
}

Status decode_path(const Node& node, const std::string& key, std::vector<Vec3>& points) {
  points.clear();
  if (node.kind != Node::Kind::kSequence) {
    return config::not_allowed(node, key, "a list of points [x, y] or [x, y, z]");
  }
  for (const Node& child : node.children) {
    Vec3 point;
    if (auto status = decode_point(child, key, point); !status) return status;
    const bool again = !points.empty() && (point - points.back()).head<2>().norm() < 1e-6;
    if (!again) points.push_back(point);
  }
  if (points.size() == 1) {
    return fail(ErrorCode::kUsage, node.where, fmt::format("{} has only one point", key),
                "A way has at least two; leave it out for a vehicle that stands.");
  }
  return {};
}

CustomTarget path(std::vector<Vec3>& points) {
  CustomTarget target;
  target.type = "a list of points [x, y] or [x, y, z]";
  target.decode = [&points](const Node& node, const std::string& key) {
    return decode_path(node, key, points);
  };
  target.encode = [&points] { return encode_path(points); };
  return target;
}

CustomTarget place(Vec3& point) {
  CustomTarget target;
  target.type = std::string(kPointType);
  target.decode = [&point](const Node& node, const std::string& key) {
    return decode_point(node, key, point);
  };
  target.encode = [&point] {
    return std::isnan(point.x()) ? std::string("[]") : encode_point(point);
  };
  return target;
}

CustomTarget noting(CustomTarget target, std::string& where) {
  target.decode = [&where, inner = std::move(target.decode)](const Node& node,
                                                             const std::string& key) {
    where = node.where;
    return inner(node, key);
  };
  return target;
}

CustomTarget ring(sim::Polygon& polygon) {
  CustomTarget target;
  target.type = "a list of corners [x, y] that ends with the first one";
  target.decode = [&polygon](const Node& node, const std::string& key) -> Status {
    std::vector<Vec3> points;
    if (node.kind == Node::Kind::kSequence && node.children.size() < 4) {
      return fail(ErrorCode::kUsage, node.where,
                  fmt::format("{} has {} corners; it needs 3, and the first again", key,
                              node.children.size()));
    }
    if (auto status = decode_path(node, key, points); !status) return status;
    const Vec2 first = points.front().head<2>();
    const Vec2 last = points.back().head<2>();
    if ((last - first).norm() > 1e-6) {
      return fail(ErrorCode::kUsage, node.where,
                  fmt::format("{} is open: it ends at [{:.6g}, {:.6g}], not at its first corner "
                              "[{:.6g}, {:.6g}]",
                              key, last.x(), last.y(), first.x(), first.y()),
                  "Repeat the first corner at the end.");
    }
    polygon.clear();
    for (std::size_t i = 0; i + 1 < points.size(); ++i) polygon.push_back(points[i].head<2>());
    const std::string fault = sim::polygon_fault(polygon);
    if (fault.empty()) return {};
    return fail(ErrorCode::kUsage, node.where, fmt::format("{} {}", key, fault));
  };
  target.encode = [&polygon] {
    std::vector<Vec3> points;
    for (const Vec2& p : polygon) {
      points.emplace_back(p.x(), p.y(), std::numeric_limits<double>::quiet_NaN());
    }
    if (!points.empty()) points.push_back(points.front());
    return encode_path(points);
  };
  return target;
}

CustomTarget reflectivities(std::map<std::string, double>& values) {
  CustomTarget target;
  target.type = "names with a reflectivity of 0 to 1";
  target.decode = [&values, type = target.type](const Node& node,
                                                const std::string& key) -> Status {
    if (node.kind != Node::Kind::kMap) return config::not_allowed(node, key, type);
    for (const Node& child : node.children) {
      const config::Field field{key + '.' + child.key, &values[child.key], 0.0, 1.0, ""};
      if (auto status = config::decode_field(field, child); !status) return status;
    }
    return {};
  };
  target.encode = [&values] {
    std::string text = "{";
    for (const auto& [name, value] : values) {
      text += fmt::format("{}{}: {}", text.size() > 1 ? ", " : "", config::yaml_quoted(name),
                          config::yaml_number(value));
    }
    return text + "}";
  };
  return target;
}

std::string encode_fields(const config::FieldList& fields, std::size_t prefix) {
  std::string text = "{";
  for (const config::Field& field : fields) {
    const std::string value = config::encode_field(field);
    if (value == "[]" || value == "\"\"" || value == "{}") continue;
    text += fmt::format("{}{}: {}", text.size() > 1 ? ", " : "", field.key.substr(prefix), value);
  }
  return text + "}";
}

}  // namespace rali::scenario
