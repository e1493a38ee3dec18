#include "arguments.hpp"

#include <functional>
#include <map>

#include <fmt/format.h>

#include "common/words.hpp"
#include "rali/config/apply.hpp"

namespace rali::accuracy {

namespace {

Status set_seeds(const std::string& text, Arguments& a) {
  auto seeds = bench::parse_seeds(text);
  if (!seeds) return tl::make_unexpected(seeds.error());
  a.seeds = std::move(*seeds);
  return {};
}

Status set_scenes(const std::string& text, Arguments& a) {
  a.scenes.clear();
  for (const std::string& name : bench::split(text)) {
    const auto scene = sim::scene_of(name);
    if (!scene) return tl::make_unexpected(scene.error());
    a.scenes.push_back(*scene);
  }
  if (a.scenes.empty()) return fail(ErrorCode::kUsage, "--scenes", "there is no scene in the list");
  return {};
}

/// One option of the simulation, e.g. motion.rest_s=0, by the names of its visit().
Status set_sim(const std::string& assignment, Arguments& a) {
  const auto node = config::parse_assignment(assignment);
  if (!node) return tl::make_unexpected(node.error());
  config::FieldList fields;
  config::collect_fields("motion.", a.sim.motion, fields);
  config::collect_fields("ranging.", a.sim.ranging, fields);
  config::collect_fields("imu.", a.sim.imu, fields);
  fields.push_back({"duration_s", &a.sim.duration_s, 0.0, 36000.0, "0: the whole route"});
  fields.push_back({"pedestrians", &a.sim.pedestrians, 0.0, 1000.0, "people who walk about"});
  fields.push_back(
      {"calibration_error_m", &a.sim.calibration_error_m, 0.0, 1.0, "of T_body_lidar"});
  fields.push_back(
      {"calibration_error_deg", &a.sim.calibration_error_deg, 0.0, 45.0, "of T_body_lidar"});
  fields.push_back({"imu_apart", &a.sim.imu_apart, 0.0, 0.0, "IMU turned and beside the body"});
  config::Origins origins;
  return config::apply_map(*node, "", "--sim", fields, origins);
}

Status set_lidar(const std::string& text, Arguments& a) {
  const auto lidar = sim::lidar_of(text);
  if (!lidar) return tl::make_unexpected(lidar.error());
  a.sim.lidar = *lidar;
  return {};
}

using Setter = std::function<Status(const std::string&, Arguments&)>;

const std::map<std::string, Setter>& setters() {
  static const std::map<std::string, Setter> kSetters{
      {"--scenes", set_scenes},
      {"--seeds", set_seeds},
      {"--lidar", set_lidar},
      {"--sim", set_sim},
      {"--pedestrians",
       [](const std::string& v, Arguments& a) { return set_sim("pedestrians=" + v, a); }},
      {"--duration",
       [](const std::string& v, Arguments& a) { return set_sim("duration_s=" + v, a); }},
      {"--preset",
       [](const std::string& v, Arguments& a) -> Status {
         a.presets = bench::split(v);
         return {};
       }},
      {"--set",
       [](const std::string& v, Arguments& a) -> Status {
         a.settings.push_back(v);
         return {};
       }},
      {"--dump",
       [](const std::string& v, Arguments& a) -> Status {
         a.dump_dir = v;
         return {};
       }},
      {"--into",
       [](const std::string& v, Arguments& a) -> Status {
         a.into = v;
         return {};
       }},
      {"--cache", [](const std::string& v, Arguments& a) -> Status {
         a.cache_dir = v;
         return {};
       }}};
  return kSetters;
}

}  // namespace

Result<Arguments> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  for (std::size_t i = 0; i < sim::kSceneNames.size(); ++i) {
    a.scenes.push_back(static_cast<sim::Scene>(i));
  }
  a.words.assign(argv + 1, argv + argc);
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--help" || name == "-h") {
      a.help = true;
      return a;
    }
    if (name == "--no-imu") {
      a.sim.with_imu = false;
    } else if (name == "--per-run") {
      a.per_run = true;
    } else if (const auto setter = setters().find(name); setter == setters().end()) {
      return fail(ErrorCode::kUsage, {}, fmt::format("there is no option \"{}\"", name),
                  "--help lists the options.");
    } else if (i + 1 == argc) {
      return fail(ErrorCode::kUsage, name, "this option needs a value");
    } else if (auto ok = setter->second(argv[++i], a); !ok) {
      return tl::make_unexpected(ok.error());
    }
  }
  return a;
}

std::string help_text() {
  return "accuracy: simulated recordings through the vehicle's software, errors as a table\n"
         "  --scenes loop,corridor   default: all\n"
         "  --seeds 1,2,5-8          default: 1-3\n"
         "  --preset robust,paper    default: robust\n"
         "  --lidar rs16             or vlp16, hdl32e, hdl64e, os1_64, os0_128, livox\n"
         "  --no-imu                 LiDAR alone\n"
         "  --pedestrians N          people who walk about\n"
         "  --duration S             the first S seconds of each recording\n"
         "  --sim key=value          of the simulation, e.g. motion.rest_s=0, "
         "motion.carrier=drone\n"
         "  --set key=value          of the vehicle, e.g. odometry.robust.voxel_m=0.4\n"
         "  --cache DIR              keep cast recordings there (rs16: 90 kB per sweep)\n"
         "  --dump DIR               trajectories (TUM) and errors per sweep (CSV)\n"
         "  --into FILE:NAME         the table also between '<!-- accuracy NAME -->' and\n"
         "                           '<!-- end -->' of a Markdown file\n"
         "  --per-run                one row for each run before the summary\n";
}

}  // namespace rali::accuracy
