#include "arguments.hpp"

#include "common/command_line.hpp"
#include "common/words.hpp"
#include "rali/config/apply.hpp"

namespace rali::accuracy {

namespace {

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

/// Sets one option of the simulation, e.g. motion.standstill_s=0, by the names of its visit().
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

}  // namespace

tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  for (std::size_t i = 0; i < sim::kSceneNames.size(); ++i) {
    a.scenes.push_back(static_cast<sim::Scene>(i));
  }
  a.words.assign(argv + 1, argv + argc);
  CLI::App app("accuracy: simulated recordings through the vehicle's software, errors as a table");
  const auto with = [&a](Status (*set)(const std::string&, Arguments&)) {
    return [set, &a](const std::string& text) { return set(text, a); };
  };
  const auto simulated = [&a](const std::string& key) {
    return [key, &a](const std::string& text) { return set_sim(key + '=' + text, a); };
  };
  bench::add_text(app, "--scenes", with(set_scenes), "loop,corridor; default: all");
  bench::add_seeds(app, a.seeds);
  app.add_option("--preset", a.presets, "robust,paper; default: robust")->delimiter(',');
  bench::add_text(app, "--lidar", with(set_lidar),
                  "rs16, vlp16, hdl32e, hdl64e, os1_64, os0_128, livox; default: rs16");
  app.add_flag_callback(
      "--no-imu", [&a] { a.sim.with_imu = false; }, "LiDAR alone");
  bench::add_text(app, "--pedestrians", simulated("pedestrians"), "people who walk about");
  bench::add_text(app, "--duration", simulated("duration_s"),
                  "the first seconds of each recording");
  bench::add_texts(app, "--sim", with(set_sim),
                   "KEY=VALUE of the simulation, e.g. motion.standstill_s=0, motion.carrier=drone");
  app.add_option("--set", a.settings,
                 "KEY=VALUE of the vehicle, e.g. odometry.robust.map.voxel_m=0.4");
  app.add_option("--cache", a.cache_dir, "keep cast recordings there (rs16: 90 kB per scan)");
  app.add_option("--dump", a.dump_dir, "trajectories (TUM) and errors per scan (CSV)");
  bench::add_into(app, "accuracy", a.into);
  app.add_flag("--per-run", a.per_run, "one row for each run before the summary");
  if (const auto code = bench::ended_by(app, argc, argv)) return tl::make_unexpected(*code);
  return a;
}

}  // namespace rali::accuracy
