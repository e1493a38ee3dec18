// Steps one vehicle through its recording and prints each pose.
//   step_vehicle fleet.yaml [VEHICLE]
#include <cstdio>
#include <optional>
#include <utility>
#include <variant>

#include <rali/rali.hpp>

namespace {

void print_poses(const std::string& input, const std::string& name) {
  const rali::FleetConfig config = rali::load_inputs({input});
  rali::RecordingReader reader(config, name);  // events of one vehicle by time
  rali::Vehicle vehicle(reader.vehicle_options());
  while (std::optional<rali::Event> event = reader.next()) {
    for (const rali::Output& output : vehicle.step(std::move(*event))) {
      if (const auto* pose = std::get_if<rali::PoseEstimate>(&output)) {
        const rali::Vec3 p = pose->T_odom_body.translation();
        std::printf("%s %.9f %.3f %.3f %.3f degenerate=%d\n", pose->vehicle.c_str(), pose->t_s(),
                    p.x(), p.y(), p.z(), pose->degeneracy.degenerate ? 1 : 0);
      } else if (const auto* finding = std::get_if<rali::RunFinding>(&output)) {
        std::fprintf(stderr, "%s: %s\n", finding->vehicle.c_str(), finding->text.c_str());
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: step_vehicle INPUT [VEHICLE]\n");
    return 2;
  }
  try {
    print_poses(argv[1], argc > 2 ? argv[2] : "");
    return 0;
  } catch (const rali::InputError& error) {  // where, problem, remedy
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
