#include "suites.hpp"

#include <fmt/format.h>

namespace rali::tunnel {

namespace {

constexpr double kBlockedFraction = 0.2;
constexpr double kSilence_s = 30.0;

Row row_of(const Case& on) {
  Row row;
  row.label = on.name;
  row.on = on;
  return row;
}

Row without_ranges(const Case& on) {
  Row row = row_of(on);
  row.label = on.name + ", ranges off";
  row.ranges = false;
  return row;
}

Case in_middle(const std::string& name) {
  Case c;
  c.name = name;
  return c;
}

Case blocked() {
  Case c = in_middle("middle, 20 % blocked");
  c.burst_fraction = kBlockedFraction;
  return c;
}

Suite acceptance() {
  Case unknown = in_middle("middle, no prior");
  unknown.prior = false;
  Case silent = in_middle("middle, 30 s silent");
  silent.loss_s = kSilence_s;
  Case start = in_middle("start, while heard");
  start.anchor = AnchorPlace::kStart;
  start.until_received = true;
  Case start_unknown = start;
  start_unknown.name = "start, while heard, no prior";
  start_unknown.prior = false;
  const Case middle = in_middle("middle");
  return {"acceptance",
          {row_of(middle), without_ranges(middle), row_of(unknown), row_of(blocked()),
           row_of(silent), row_of(start), row_of(start_unknown)}};
}

Suite harm() {
  Suite suite{"harm", {}};
  for (const sim::Scene scene : {sim::Scene::kLoop, sim::Scene::kFloor, sim::Scene::kYard,
                                 sim::Scene::kGarage, sim::Scene::kCorridor}) {
    Case c;
    c.name = sim::kSceneNames[static_cast<std::size_t>(scene)];
    c.scene = scene;
    suite.rows.push_back(row_of(c));
    suite.rows.push_back(without_ranges(c));
  }
  return suite;
}

Suite ablation() {
  const auto less = [](const std::string& label, std::vector<std::string> settings) {
    Row row = row_of(blocked());
    row.label = label;
    row.settings = std::move(settings);
    return row;
  };
  return {"ablation",
          {less("robust", {}), less("no bias state", {"ranging.bias.sigma_m=1e-4"}),
           less("no line-of-sight test", {"ranging.line_of_sight.use=false"}),
           less("no excess watch", {"ranging.excess.use=false"}),
           less("no thinning", {"ranging.slow.slow_sigma_m=0"}),
           less("raw Hessian",
                {"odometry.robust.aware.kappa=0", "odometry.robust.aware.kappa_supported=0"}),
           less("paper", {"odometry.preset=paper"})}};
}

Suite mesh() {
  Suite suite = harm();
  suite.name = "mesh";
  std::erase_if(suite.rows, [](const Row& r) { return r.on.scene != sim::Scene::kCorridor; });
  for (Row& row : suite.rows) row.mesh = true;
  return suite;
}

}  // namespace

Result<Suite> suite_of(const std::string& name) {
  for (Suite suite : {acceptance(), harm(), ablation(), mesh()}) {
    if (suite.name == name) return suite;
  }
  return fail(ErrorCode::kUsage, "--suite", fmt::format("there is no suite \"{}\"", name),
              "There are acceptance, harm, ablation and mesh.");
}

}  // namespace rali::tunnel
