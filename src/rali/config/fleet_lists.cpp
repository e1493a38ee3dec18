#include "rali/config/fleet_lists.hpp"

#include <fmt/format.h>

#include "rali/config/apply.hpp"
#include "rali/config/codecs.hpp"
#include "rali/fleet/facts/quantise.hpp"

namespace rali::config {
namespace {

constexpr double kMaxLever_m = 100.0;

RadioName radio_name(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return {text, ""};
  return {text.substr(0, slash), text.substr(slash + 1)};
}

Status decode_ids(std::map<std::int64_t, RadioName>& ids, const Node& node,
                  const std::string& key) {
  const std::string type = "a map from radio number to vehicle or vehicle/antenna";
  if (node.kind != Node::Kind::kMap) return not_allowed(node, key, type);
  ids.clear();
  for (const Node& child : node.children) {
    long long id = 0;
    const bool is_id = parse_integer(child.key, id) && id >= 0 && id <= 0xffffffffLL;
    if (!is_id || child.kind != Node::Kind::kScalar || child.text.empty()) {
      return not_allowed(child, key + '.' + child.key, type);
    }
    ids[id] = radio_name(child.text);
  }
  return {};
}

CustomTarget ids_target(std::map<std::int64_t, RadioName>& ids) {
  CustomTarget target;
  target.type = "a map from radio number to vehicle or vehicle/antenna";
  target.decode = [&ids](const Node& node, const std::string& key) {
    return decode_ids(ids, node, key);
  };
  target.encode = [&ids] {
    std::string text = "{";
    for (const auto& [id, name] : ids) {
      const std::string whole =
          name.antenna.empty() ? name.vehicle : name.vehicle + '/' + name.antenna;
      text += fmt::format("{}{}: {}", text.size() > 1 ? ", " : "", id, yaml_quoted(whole));
    }
    return text + "}";
  };
  return target;
}

FieldList source_fields(RangeSource& source, const std::string& prefix,
                        const std::string& base_dir) {
  return {{prefix + "file", path_or_none(source.file, base_dir), 0.0, 0.0, ""},
          {prefix + "topic", &source.topic, 0.0, 0.0, ""},
          {prefix + "serial_log", path_or_none(source.serial_log, base_dir), 0.0, 0.0, ""},
          {prefix + "vehicle", &source.vehicle, 0.0, 0.0, ""},
          {prefix + "ids", ids_target(source.ids), 0.0, 0.0, ""}};
}

FieldList prior_fields(PriorConfig& prior, const std::string& prefix) {
  const std::span<double> xyz(prior.p_m.data(), 3);
  return {{prefix + "vehicle", &prior.vehicle, 0.0, 0.0, ""},
          {prefix + "relative_to", &prior.relative_to, 0.0, 0.0, ""},
          {prefix + "xyz_m", xyz, -1e5, 1e5, ""},
          {prefix + "yaw_deg", &prior.yaw_deg, -360.0, 360.0, ""},
          {prefix + "sigma_m", &prior.sigma_m, 1e-3, 1e3, ""},
          {prefix + "sigma_deg", &prior.sigma_deg, 1e-3, 180.0, ""}};
}

Status check_source(const RangeSource& source, const Node& node, const std::string& key) {
  const int given = (source.file.empty() ? 0 : 1) + (source.topic.empty() ? 0 : 1) +
                    (source.serial_log.empty() ? 0 : 1);
  if (given == 1) return {};
  return fail(ErrorCode::kUsage, node.where,
              fmt::format("{} names {} sources", key, given == 0 ? "no" : "several"),
              "Give one of file, topic, serial_log.");
}

/// The fields that differ from a default item, as a flow map.
std::string encode_item(const FieldList& fields, const FieldList& plain, std::size_t prefix) {
  std::string text = "{";
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string value = encode_field(fields[i]);
    if (value == encode_field(plain[i])) continue;
    text +=
        fmt::format("{}{}: {}", text.size() > 1 ? ", " : "", fields[i].key.substr(prefix), value);
  }
  return text + "}";
}

}  // namespace

CustomTarget antennas_target(std::vector<AntennaConfig>& antennas) {
  CustomTarget target;
  target.type = "{NAME: {xyz_m: [x, y, z]}, ...}";
  target.decode = [&antennas, type = target.type](const Node& node,
                                                  const std::string& key) -> Status {
    if (node.kind != Node::Kind::kMap) return not_allowed(node, key, type);
    if (node.children.size() > fleet::kAntennasMax) {
      return fail(ErrorCode::kUsage, node.where,
                  fmt::format("{} has {} antennas; at most {} are possible", key,
                              node.children.size(), fleet::kAntennasMax));
    }
    std::vector<AntennaConfig> read;
    for (const Node& child : node.children) {
      long long number = 0;
      if (child.key.empty() || parse_integer(child.key, number)) {
        return fail(ErrorCode::kUsage, child.key_where,
                    fmt::format("{}: {} is no name of an antenna", key, yaml_quoted(child.key)),
                    "A number in ranges.csv is a place in this list, from 0.");
      }
      AntennaConfig antenna;
      antenna.name = child.key;
      const std::string prefix = key + '.' + child.key + '.';
      const std::span<double> xyz(antenna.p_body_m.data(), 3);
      const FieldList fields{{prefix + "xyz_m", xyz, -kMaxLever_m, kMaxLever_m, ""}};
      Origins given;
      if (Status status = apply_map(child, prefix, "", fields, given); !status) return status;
      read.push_back(std::move(antenna));
    }
    antennas = std::move(read);
    return {};
  };
  target.encode = [&antennas] {
    std::string text = "{";
    for (const AntennaConfig& antenna : antennas) {
      text +=
          fmt::format("{}{}: {{xyz_m: {}}}", text.size() > 1 ? ", " : "", yaml_quoted(antenna.name),
                      encode_list(std::span<const double>(antenna.p_body_m.data(), 3)));
    }
    return text + "}";
  };
  return target;
}

CustomTarget range_sources_target(std::vector<RangeSource>& sources, const std::string& base_dir) {
  CustomTarget target;
  target.type = "a list of {file, vehicle}, {topic, ids} or {serial_log, vehicle, ids}";
  target.decode = [&sources, base_dir, type = target.type](const Node& node,
                                                           const std::string& key) -> Status {
    if (node.kind != Node::Kind::kSequence) return not_allowed(node, key, type);
    std::vector<RangeSource> read;
    for (const Node& child : node.children) {
      RangeSource source;
      const std::string prefix = fmt::format("{}[{}].", key, read.size());
      Origins given;
      const FieldList fields = source_fields(source, prefix, base_dir);
      if (Status status = apply_map(child, prefix, "", fields, given); !status) return status;
      if (Status status = check_source(source, child, fmt::format("{}[{}]", key, read.size()));
          !status) {
        return status;
      }
      read.push_back(std::move(source));
    }
    sources = std::move(read);
    return {};
  };
  target.encode = [&sources, base_dir] {
    std::string text = "[";
    for (RangeSource& source : sources) {
      RangeSource none;
      text += (text.size() > 1 ? ", " : "") + encode_item(source_fields(source, "", base_dir),
                                                          source_fields(none, "", base_dir), 0);
    }
    return text + "]";
  };
  return target;
}

CustomTarget range_bias_target(RangesConfig& ranges) {
  CustomTarget target;
  target.type = "estimate, a number, or {v1-v2: number, ...}";
  target.decode = [&ranges, type = target.type](const Node& node,
                                                const std::string& key) -> Status {
    std::optional<double> bias;
    std::map<std::string, double> pairs;
    if (node.kind == Node::Kind::kMap) {
      for (const Node& child : node.children) {
        const Field field{key + '.' + child.key, &pairs[child.key], -100.0, 100.0, ""};
        if (Status status = decode_field(field, child); !status) return status;
      }
    } else if (Status status = number_or(bias, "estimate", -100.0, 100.0).decode(node, key);
               !status) {
      return not_allowed(node, key, type);
    }
    ranges.bias_m = bias;
    ranges.pair_bias_m = std::move(pairs);
    return {};
  };
  target.encode = [&ranges] {
    if (ranges.pair_bias_m.empty()) return ranges.bias_m ? yaml_number(*ranges.bias_m) : "estimate";
    std::string text = "{";
    for (const auto& [pair, bias] : ranges.pair_bias_m) {
      text += fmt::format("{}{}: {}", text.size() > 1 ? ", " : "", yaml_quoted(pair),
                          yaml_number(bias));
    }
    return text + "}";
  };
  return target;
}

CustomTarget priors_target(std::vector<PriorConfig>& priors) {
  CustomTarget target;
  target.type = "a list of {vehicle, relative_to, xyz_m, yaw_deg, sigma_m, sigma_deg}";
  target.decode = [&priors, type = target.type](const Node& node,
                                                const std::string& key) -> Status {
    if (node.kind != Node::Kind::kSequence) return not_allowed(node, key, type);
    std::vector<PriorConfig> read;
    for (const Node& child : node.children) {
      PriorConfig prior;
      const std::string prefix = fmt::format("{}[{}].", key, read.size());
      Origins given;
      const FieldList fields = prior_fields(prior, prefix);
      if (Status status = apply_map(child, prefix, "", fields, given); !status) return status;
      if (prior.vehicle.empty()) {
        return fail(ErrorCode::kUsage, child.where, prefix + "vehicle is missing");
      }
      read.push_back(std::move(prior));
    }
    priors = std::move(read);
    return {};
  };
  target.encode = [&priors] {
    std::string text = "[";
    for (PriorConfig& prior : priors) {
      PriorConfig none;
      text += (text.size() > 1 ? ", " : "") +
              encode_item(prior_fields(prior, ""), prior_fields(none, ""), 0);
    }
    return text + "]";
  };
  return target;
}

}  // namespace rali::config
