#pragma once

#include <cstdint>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/base/settings.hpp"
#include "rali/geometry/types.hpp"

namespace rali::sim {

/// Steps of the body that are shorter than a sample period of the inertial sensor. Joints between
/// tiles lift the body; stick-slip of the tyres makes it lag behind its wheels and then jump. All
/// zero: no steps.
struct JoltOptions {
  double joint_every_m = 0.0;   ///< distance between joints; 0: none
  double joint_m = 0.0;         ///< height of a step, sd over joints
  double slip_every_m = 0.0;    ///< distance between slips; 0: none
  double slip_m = 0.0;          ///< length of a jump along the heading, sd over slips
  double step_s = 0.0;          ///< duration of a step
  double measured_ratio = 0.0;  ///< fraction of the steps that the inertial sensor measures

  template <class V>
  void visit(V& v) {
    v("joint_every_m", joint_every_m, 0.0, 100.0, "distance between joints of the floor, 0: none");
    v("joint_m", joint_m, 0.0, 0.05, "sd of the height of a joint");
    v("slip_every_m", slip_every_m, 0.0, 100.0, "distance between slips of the tyres, 0: none");
    v("slip_m", slip_m, 0.0, 0.05, "sd of the length of a slip");
    v("step_s", step_s, 0.0, 0.2, "duration of one step of the body");
    v("measured_ratio", measured_ratio, 0.0, 1.0,
      "part of the steps that the inertial sensor measures");
  }
};

/// Offsets of the body from its smooth trajectory as a function of the distance travelled, so there
/// are no jumps at standstill.
class Jolts {
 public:
  Jolts(const JoltOptions& options, std::uint64_t seed);

  /// Draws the steps up to this distance; at() is thread-safe up to there.
  void extend_to(double distance_m);

  /// Along the heading, left, up [m], roll, pitch, yaw [rad], after `distance_m` at `speed_mps`.
  [[nodiscard]] geometry::Vec6 at(double distance_m, double speed_mps) const;

  [[nodiscard]] bool empty() const { return joints_.every_m <= 0.0 && slips_.every_m <= 0.0; }

  [[nodiscard]] double measured_ratio() const { return options_.measured_ratio; }

 private:
  /// Steps at random distances with normally distributed sizes.
  struct Series {
    double every_m = 0.0, size_m = 0.0;
    Rng rng;
    std::vector<double> at_m, by_m;

    Series(double every, double size, Rng random)
        : every_m(size > 0.0 ? every : 0.0), size_m(size), rng(random) {}

    void extend_to(double distance_m);
    /// Index of the last step at or before this distance, -1 before the first.
    [[nodiscard]] std::ptrdiff_t last_before(double distance_m) const;
  };

  JoltOptions options_;
  Series joints_, slips_;
};

}  // namespace rali::sim
