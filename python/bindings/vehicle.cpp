#include "rali/vehicle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include <pybind11/stl.h>

#include "arrays.hpp"
#include "docs.hpp"
#include "rali/config.hpp"

namespace rali::python {
namespace {

std::int64_t nanoseconds(double stamp_s) {
  if (!(std::abs(stamp_s) < 9e9)) throw InputError("stamp_s", "is no time in seconds", "");
  return std::llround(stamp_s * 1e9);
}

const char* quality_name(PoseQuality quality) {
  constexpr std::array kNames{"good", "weak", "predicted", "diverged"};
  return kNames.at(static_cast<std::size_t>(quality));
}

using Floats = py::array_t<float, py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Columns x y z [intensity [dt_s [ring]]] of a scan.
Scan scan_of(const py::object& points, double stamp_s, bool deskewed) {
  const auto values = Floats::ensure(points);
  if (!values || values.ndim() != 2 || values.shape(1) < 3 || values.shape(1) > 6) {
    PyErr_Clear();
    throw InputError("points", "is no array of shape (N, 3) to (N, 6)",
                     "Give x, y, z, and where known intensity, dt_s, ring.");
  }
  const auto n = static_cast<std::size_t>(values.shape(0));
  const py::ssize_t columns = values.shape(1);
  const auto at = values.unchecked<2>();
  Scan scan;
  scan.stamp_ns = nanoseconds(stamp_s);
  scan.deskewed = deskewed;
  const std::array<std::vector<float>*, 5> targets{&scan.x_m, &scan.y_m, &scan.z_m, &scan.intensity,
                                                   &scan.dt_s};
  for (py::ssize_t c = 0; c < std::min<py::ssize_t>(columns, 5); ++c) {
    std::vector<float>& target = *targets[static_cast<std::size_t>(c)];
    target.resize(n);
    for (std::size_t i = 0; i < n; ++i) target[i] = at(static_cast<py::ssize_t>(i), c);
  }
  if (columns < 6) return scan;
  scan.ring.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const float ring = at(static_cast<py::ssize_t>(i), 5);
    if (!(ring >= 0.0F && ring < 65536.0F)) {
      throw InputError("points", "column 5 holds a ring that is not 0 to 65535", "");
    }
    scan.ring[i] = static_cast<std::uint16_t>(ring);
  }
  return scan;
}

std::vector<ImuSample> samples_of(const py::object& rows) {
  const auto values = Doubles::ensure(rows);
  const bool one = values && values.ndim() == 1 && values.shape(0) == 7;
  if (!one && (!values || values.ndim() != 2 || values.shape(1) != 7)) {
    PyErr_Clear();
    throw InputError("rows", "is no array of shape (N, 7)",
                     "Give stamp_s, gyro x y z [rad/s], accelerometer x y z [m/s^2].");
  }
  std::vector<ImuSample> samples;
  const py::ssize_t n = one ? 1 : values.shape(0);
  for (py::ssize_t i = 0; i < n; ++i) {
    const double* const row = values.data() + 7 * i;
    samples.push_back(
        {nanoseconds(row[0]), Vec3(row[1], row[2], row[3]), Vec3(row[4], row[5], row[6])});
  }
  return samples;
}

VehicleOptions options_of(const std::string& name, const py::object& T_body_lidar,
                          const py::object& T_body_imu, bool has_imu,
                          const std::array<double, 2>& range_m, const py::object& antennas,
                          const py::object& peers, const std::string& preset,
                          const py::object& settings) {
  VehicleOptions options;
  options.name = name;
  options.T_body_lidar = pose_of(T_body_lidar, "T_body_lidar");
  options.T_body_imu = pose_of(T_body_imu, "T_body_imu");
  options.has_imu = has_imu;
  options.range_m = range_m;
  if (!antennas.is_none()) options.antennas_body_m = points_of(antennas, "antennas_body_m");
  if (!peers.is_none()) {
    for (const auto& [peer, positions] : peers.cast<py::dict>()) {
      const std::string peer_name = py::str(peer);
      options.peers.push_back(
          {peer_name, points_of(py::reinterpret_borrow<py::object>(positions), peer_name)});
    }
  }
  return with_settings(std::move(options), {preset, settings_of(settings)});
}

/// The vehicle with a lock: the GIL is released, but only one thread at a time may use it.
class SharedVehicle {
 public:
  explicit SharedVehicle(const VehicleOptions& options) : vehicle_(options) {}

  std::vector<Output> step(std::vector<Event> events) {
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
    std::vector<Output> all;
    for (Event& event : events) {
      for (Output& output : vehicle_.step(std::move(event))) all.push_back(std::move(output));
    }
    return all;
  }

  [[nodiscard]] std::uint64_t state_hash() const { return vehicle_.state_hash(); }

 private:
  std::mutex mutex_;
  Vehicle vehicle_;
};

void bind_outputs(py::module_& module) {
  py::class_<Degeneracy>(module, "Degeneracy")
      .def_readonly("degenerate", &Degeneracy::degenerate)
      .def_property_readonly("direction_odom",
                             [](const Degeneracy& d) { return array_of(d.direction_odom); })
      .def_readonly("sigma_m", &Degeneracy::sigma_m)
      .def_property_readonly("translation_sigma_m",
                             [](const Degeneracy& d) { return py::cast(d.translation_sigma_m); })
      .def_readonly("degree", &Degeneracy::degree);
  py::class_<PoseEstimate>(module, "PoseEstimate")
      .def_readonly("vehicle", &PoseEstimate::vehicle)
      .def_readonly("stamp_ns", &PoseEstimate::stamp_ns)
      .def_property_readonly("t_s", &PoseEstimate::t_s)
      .def_property_readonly("T_odom_body",
                             [](const PoseEstimate& p) { return array_of(p.T_odom_body); })
      .def_property_readonly("T_local_body",
                             [](const PoseEstimate& p) { return array_of(p.T_local_body); })
      .def_property_readonly("v_odom_mps",
                             [](const PoseEstimate& p) { return array_of(p.v_odom_mps); })
      .def_property_readonly("covariance",
                             [](const PoseEstimate& p) { return array_of(p.covariance); })
      .def_property_readonly("covariance_local",
                             [](const PoseEstimate& p) { return array_of(p.covariance_local); })
      .def_property_readonly("quality",
                             [](const PoseEstimate& p) { return quality_name(p.quality); })
      .def_readonly("degeneracy", &PoseEstimate::degeneracy)
      .def_readonly("correspondences", &PoseEstimate::correspondences)
      .def_readonly("standstill", &PoseEstimate::standstill)
      .def_readonly("range_correction_m", &PoseEstimate::range_correction_m);
  py::class_<Keyframe>(module, "Keyframe")
      .def_readonly("vehicle", &Keyframe::vehicle)
      .def_readonly("index", &Keyframe::index)
      .def_readonly("stamp_ns", &Keyframe::stamp_ns)
      .def_property_readonly("T_local_body",
                             [](const Keyframe& k) { return array_of(k.T_local_body); })
      .def_property_readonly("x_m",
                             [](py::object self) { return view(self.cast<Keyframe&>().x_m, self); })
      .def_property_readonly("y_m",
                             [](py::object self) { return view(self.cast<Keyframe&>().y_m, self); })
      .def_property_readonly("z_m",
                             [](py::object self) { return view(self.cast<Keyframe&>().z_m, self); })
      .def_property_readonly("intensity", [](py::object self) {
        return view(self.cast<Keyframe&>().intensity, self);
      });
  py::class_<RangeResult>(module, "RangeResult")
      .def_property_readonly("stamp_ns",
                             [](const RangeResult& r) { return r.measurement.stamp_ns; })
      .def_property_readonly("from_vehicle",
                             [](const RangeResult& r) { return r.measurement.from; })
      .def_property_readonly("to_vehicle", [](const RangeResult& r) { return r.measurement.to; })
      .def_property_readonly("range_m", [](const RangeResult& r) { return r.measurement.range_m; })
      .def_readonly("used", &RangeResult::used)
      .def_readonly("reason", &RangeResult::reason)
      .def_readonly("predicted_m", &RangeResult::predicted_m)
      .def_readonly("residual_m", &RangeResult::residual_m)
      .def_readonly("sigma_m", &RangeResult::sigma_m);
}

}  // namespace

void bind_vehicle(py::module_& module) {
  bind_outputs(module);
  py::class_<SharedVehicle>(module, "Vehicle", kVehicleDoc)
      .def(py::init([](const std::string& name, const py::object& T_body_lidar,
                       const py::object& T_body_imu, bool has_imu,
                       const std::array<double, 2>& range_m, const py::object& antennas,
                       const py::object& peers, const std::string& preset,
                       const py::object& settings) {
             return std::make_unique<SharedVehicle>(options_of(name, T_body_lidar, T_body_imu,
                                                               has_imu, range_m, antennas, peers,
                                                               preset, settings));
           }),
           py::arg("name") = "v1", py::kw_only(), py::arg("T_body_lidar") = py::none(),
           py::arg("T_body_imu") = py::none(), py::arg("has_imu") = true,
           py::arg("range_m") = std::array<double, 2>{0.4, 100.0},
           py::arg("antennas_body_m") = py::none(), py::arg("peers") = py::none(),
           py::arg("preset") = "", py::arg("settings") = py::none())
      .def(
          "add_scan",
          [](SharedVehicle& v, const py::object& points, double stamp_s, bool deskewed) {
            std::vector<Event> events;
            events.emplace_back(scan_of(points, stamp_s, deskewed));
            return v.step(std::move(events));
          },
          py::arg("points"), py::arg("stamp_s"), py::kw_only(), py::arg("deskewed") = false,
          kAddScanDoc)
      .def(
          "add_imu",
          [](SharedVehicle& v, const py::object& rows) {
            std::vector<Event> events;
            for (ImuSample& sample : samples_of(rows)) events.emplace_back(sample);
            return v.step(std::move(events));
          },
          py::arg("rows"), kAddImuDoc)
      .def(
          "add_range",
          [](SharedVehicle& v, double stamp_s, const std::string& from, const std::string& to,
             double range_m, double sigma_m) {
            RangeMeasurement range;
            range.stamp_ns = nanoseconds(stamp_s);
            range.from = from;
            range.to = to;
            range.range_m = range_m;
            range.sigma_m = sigma_m;
            return v.step({range});
          },
          py::arg("stamp_s"), py::arg("from_vehicle"), py::arg("to_vehicle"), py::arg("range_m"),
          py::arg("sigma_m") = 0.0, kAddRangeDoc)
      .def(
          "add_peer_state",
          [](SharedVehicle& v, double stamp_s, const std::string& vehicle, bool standstill) {
            return v.step({PeerState{nanoseconds(stamp_s), vehicle, standstill}});
          },
          py::arg("stamp_s"), py::arg("vehicle"), py::arg("standstill"), kAddPeerStateDoc)
      .def(
          "finish", [](SharedVehicle& v) { return v.step({EndOfData{}}); }, kFinishDoc)
      .def("state_hash", &SharedVehicle::state_hash);
}

}  // namespace rali::python
