#include "rali/results.hpp"

#include <array>

#include <pybind11/stl.h>

#include "arrays.hpp"
#include "docs.hpp"

namespace rali::python {
namespace {

py::object flags(const std::vector<std::uint8_t>& values, py::handle owner) {
  const py::object bytes = view(values, owner);
  return bytes.is_none() ? bytes : bytes.attr("view")("bool");
}

py::object seconds_array(const py::object& stamp_ns) {
  if (stamp_ns.is_none()) return stamp_ns;
  return stamp_ns.attr("__mul__")(1e-9);
}

void bind_finding(py::module_& module) {
  py::class_<RunFinding>(module, "Finding")
      .def_readonly("id", &RunFinding::id)
      .def_property_readonly("level",
                             [](const RunFinding& f) {
                               constexpr std::array kNames{"info", "warning", "error"};
                               return kNames.at(static_cast<std::size_t>(f.level));
                             })
      .def_readonly("stamp_ns", &RunFinding::stamp_ns)
      .def_readonly("vehicle", &RunFinding::vehicle)
      .def_readonly("topic", &RunFinding::topic)
      .def_readonly("text", &RunFinding::text)
      .def_readonly("effect", &RunFinding::effect)
      .def_readonly("remedy", &RunFinding::remedy);
}

void bind_trajectory(py::module_& module) {
  py::class_<Trajectory>(module, "Trajectory")
      .def("__len__", &Trajectory::size)
      .def_property_readonly(
          "stamp_ns", [](py::object self) { return view(self.cast<Trajectory&>().stamp_ns, self); })
      .def_property_readonly("stamp_s",
                             [](py::object self) { return seconds_array(self.attr("stamp_ns")); })
      .def_property_readonly(
          "poses",
          [](py::object self) { return view_matrices(self.cast<Trajectory&>().poses, 4, self); })
      .def_property_readonly("covariances",
                             [](py::object self) -> py::object {
                               const Trajectory& trajectory = self.cast<Trajectory&>();
                               if (trajectory.covariances.empty()) return py::none();
                               return view_matrices(trajectory.covariances, 6, self);
                             })
      .def_readonly("header", &Trajectory::header);
}

void bind_cloud(py::module_& module) {
  py::class_<MapCloud>(module, "MapCloud")
      .def("__len__", &MapCloud::size)
      .def_property_readonly(
          "xyz_m", [](py::object self) { return view_rows3(self.cast<MapCloud&>().xyz_m, self); })
      .def_property_readonly(
          "intensity", [](py::object self) { return view(self.cast<MapCloud&>().intensity, self); })
      .def_property_readonly(
          "sigma_m", [](py::object self) { return view(self.cast<MapCloud&>().sigma_m, self); })
      .def_property_readonly(
          "seen", [](py::object self) { return view(self.cast<MapCloud&>().seen, self); })
      .def_property_readonly(
          "vehicle", [](py::object self) { return view(self.cast<MapCloud&>().vehicle, self); });
}

void bind_ranges(py::module_& module) {
  auto ranges = py::class_<RangeTable>(module, "RangeTable");
  ranges.def("__len__", &RangeTable::size)
      .def_readonly("from_vehicle", &RangeTable::from)
      .def_readonly("to_vehicle", &RangeTable::to)
      .def_readonly("reason", &RangeTable::reason)
      .def_property_readonly(
          "stamp_ns", [](py::object self) { return view(self.cast<RangeTable&>().stamp_ns, self); })
      .def_property_readonly("stamp_s",
                             [](py::object self) { return seconds_array(self.attr("stamp_ns")); })
      .def_property_readonly(
          "used", [](py::object self) { return flags(self.cast<RangeTable&>().used, self); });
  const auto column = [&](const char* name, std::vector<double> RangeTable::*member) {
    ranges.def_property_readonly(
        name, [member](py::object self) { return view(self.cast<RangeTable&>().*member, self); });
  };
  column("range_m", &RangeTable::range_m);
  column("predicted_m", &RangeTable::predicted_m);
  column("residual_m", &RangeTable::residual_m);
  column("sigma_m", &RangeTable::sigma_m);
  column("bias_m", &RangeTable::bias_m);
  column("p_los", &RangeTable::p_los);
}

void bind_readers(py::module_& module) {
  const auto reader = [&](const char* name, auto read, const char* doc) {
    module.def(
        name,
        [read](const py::object& path) {
          const std::string file = path_of(path);
          const py::gil_scoped_release released;
          return read(file);
        },
        py::arg("path"), doc);
  };
  reader("read_trajectory", &read_trajectory, kReadTrajectoryDoc);
  reader("read_map", &read_map, kReadMapDoc);
  reader("read_ranges", &read_ranges, kReadRangesDoc);
}

}  // namespace

void bind_results(py::module_& module) {
  bind_finding(module);
  bind_trajectory(module);
  bind_cloud(module);
  bind_ranges(module);
  bind_readers(module);
}

}  // namespace rali::python
