#include "rali/map.hpp"

#include <array>

#include <pybind11/stl.h>

#include "arrays.hpp"
#include "docs.hpp"
#include "rali/evaluate.hpp"

namespace rali::python {
namespace {

std::vector<std::string> inputs_of(const py::object& inputs) {
  if (py::isinstance<py::str>(inputs) || py::hasattr(inputs, "__fspath__")) {
    return {path_of(inputs)};
  }
  std::vector<std::string> paths;
  for (const py::handle input : inputs) {
    paths.push_back(path_of(py::reinterpret_borrow<py::object>(input)));
  }
  return paths;
}

const char* status_name(MapStatus status) {
  constexpr std::array kNames{"complete", "partial", "interrupted"};
  return kNames.at(static_cast<std::size_t>(status));
}

/// The callbacks hold the GIL while they run; an exception, Ctrl-C included, stops the run.
MapCallbacks callbacks_of(const py::object& progress, const py::object& finding) {
  MapCallbacks callbacks;
  callbacks.progress = [progress](const MapProgress& state) {
    const py::gil_scoped_acquire held;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (progress.is_none()) return true;
    const py::object answer = progress(state);
    return answer.is_none() || answer.cast<bool>();
  };
  if (!finding.is_none()) {
    callbacks.finding = [finding](const RunFinding& found) {
      const py::gil_scoped_acquire held;
      finding(found);
    };
  }
  return callbacks;
}

MapSummary map(const py::object& inputs, const py::object& out, const std::string& preset,
               const py::object& settings, const std::vector<std::string>& formats, bool overwrite,
               bool strict, int threads, bool session_mcap, bool keyframe_clouds, bool report,
               const py::object& progress, const py::object& finding) {
  MapOptions options;
  options.out = path_of(out);
  options.formats = formats;
  options.overwrite = overwrite;
  options.strict = strict;
  options.threads = threads;
  options.session_mcap = session_mcap;
  options.keyframe_clouds = keyframe_clouds;
  options.report = report;
  const FleetConfig config = load_inputs(inputs_of(inputs), {preset, settings_of(settings)});
  const MapCallbacks callbacks = callbacks_of(progress, finding);
  const py::gil_scoped_release released;
  return map_recordings(config, options, callbacks);
}

Alignment alignment_of(const std::string& name) {
  if (name == "se3") return Alignment::kSe3;
  if (name == "yaw") return Alignment::kYaw;
  if (name == "origin") return Alignment::kOrigin;
  if (name == "none") return Alignment::kNone;
  throw SettingsError("alignment", "'" + name.substr(0, 60) + "' is no alignment",
                      "Known here: se3, yaw, origin, none.");
}

Evaluation evaluate_paths(const py::object& input, const py::object& truth, const py::object& mesh,
                          const std::string& alignment, bool each,
                          const std::vector<double>& distances_m, const py::object& T_body_truth,
                          int threads, const py::object& out) {
  EvaluateOptions options;
  options.truth = path_of(truth);
  options.mesh = path_of(mesh);
  options.alignment = alignment_of(alignment);
  options.each = each;
  options.distances_m = distances_m;
  options.T_body_truth = pose_of(T_body_truth, "T_body_truth");
  options.threads = threads;
  options.out = path_of(out);
  const std::string path = path_of(input);
  const py::gil_scoped_release released;
  return evaluate(path, options);
}

void bind_summaries(py::module_& module) {
  py::class_<MapProgress>(module, "MapProgress")
      .def_readonly("vehicle", &MapProgress::vehicle)
      .def_readonly("stage", &MapProgress::stage)
      .def_readonly("fraction", &MapProgress::fraction)
      .def_readonly("speed", &MapProgress::speed)
      .def_readonly("distance_m", &MapProgress::distance_m)
      .def_readonly("degenerate_fraction", &MapProgress::degenerate_fraction)
      .def_readonly("stamp_ns", &MapProgress::stamp_ns);
  py::class_<VehicleSummary>(module, "VehicleSummary")
      .def_readonly("name", &VehicleSummary::name)
      .def_readonly("distance_m", &VehicleSummary::distance_m)
      .def_readonly("scans", &VehicleSummary::scans)
      .def_readonly("scans_dropped", &VehicleSummary::scans_dropped)
      .def_readonly("keyframes", &VehicleSummary::keyframes)
      .def_readonly("degenerate_fraction", &VehicleSummary::degenerate_fraction)
      .def_readonly("sigma_median_m", &VehicleSummary::sigma_median_m)
      .def_readonly("sigma_max_m", &VehicleSummary::sigma_max_m);
  py::class_<MapSummary>(module, "MapSummary")
      .def_property_readonly("status", [](const MapSummary& s) { return status_name(s.status); })
      .def_readonly("out", &MapSummary::out)
      .def_readonly("vehicles", &MapSummary::vehicles)
      .def_readonly("connected", &MapSummary::connected)
      .def_readonly("gaps", &MapSummary::gaps)
      .def_readonly("map_points", &MapSummary::map_points)
      .def_readonly("ranges", &MapSummary::ranges)
      .def_readonly("ranges_used", &MapSummary::ranges_used)
      .def_readonly("loops_closed", &MapSummary::loops_closed)
      .def_readonly("findings", &MapSummary::findings)
      .def_readonly("metrics_json", &MapSummary::metrics_json);
}

void bind_evaluation(py::module_& module) {
  py::class_<ErrorStatistics>(module, "ErrorStatistics")
      .def_readonly("count", &ErrorStatistics::count)
      .def_readonly("rmse", &ErrorStatistics::rmse)
      .def_readonly("mean", &ErrorStatistics::mean)
      .def_readonly("median", &ErrorStatistics::median)
      .def_readonly("std", &ErrorStatistics::std)
      .def_readonly("min", &ErrorStatistics::min)
      .def_readonly("max", &ErrorStatistics::max);
  py::class_<RelativeError>(module, "RelativeError")
      .def_readonly("distance_m", &RelativeError::distance_m)
      .def_readonly("translation_m", &RelativeError::translation_m)
      .def_readonly("rotation_rad", &RelativeError::rotation_rad);
  py::class_<TrackErrors>(module, "TrackErrors")
      .def_readonly("name", &TrackErrors::name)
      .def_readonly("poses", &TrackErrors::poses)
      .def_readonly("distance_m", &TrackErrors::distance_m)
      .def_readonly("ape_m", &TrackErrors::ape_m)
      .def_readonly("rotation_rad", &TrackErrors::rotation_rad)
      .def_readonly("rpe", &TrackErrors::rpe)
      .def_readonly("nees", &TrackErrors::nees);
  py::class_<CloudErrors>(module, "CloudErrors")
      .def_readonly("points", &CloudErrors::points)
      .def_readonly("to_mesh_m", &CloudErrors::to_mesh_m)
      .def_readonly("fraction_beyond", &CloudErrors::fraction_beyond);
  py::class_<Evaluation>(module, "Evaluation")
      .def_readonly("fleet", &Evaluation::fleet)
      .def_readonly("vehicles", &Evaluation::vehicles)
      .def_readonly("cloud", &Evaluation::cloud)
      .def_readonly("warnings", &Evaluation::warnings)
      .def_readonly("json", &Evaluation::json)
      .def_readonly("table", &Evaluation::table)
      .def("__str__", [](const Evaluation& e) { return e.table; });
}

}  // namespace

void bind_map(py::module_& module) {
  bind_summaries(module);
  bind_evaluation(module);
  module.def("map", &map, kMapDoc, py::arg("inputs"), py::arg("out") = "out", py::kw_only(),
             py::arg("preset") = "", py::arg("settings") = py::none(),
             py::arg("formats") = std::vector<std::string>{"pcd", "ply"},
             py::arg("overwrite") = false, py::arg("strict") = false, py::arg("threads") = 0,
             py::arg("session_mcap") = true, py::arg("keyframe_clouds") = true,
             py::arg("report") = true, py::arg("progress") = py::none(),
             py::arg("finding") = py::none());
  module.def("evaluate", &evaluate_paths, kEvaluateDoc, py::arg("input"), py::arg("truth") = "",
             py::kw_only(), py::arg("mesh") = "", py::arg("alignment") = "se3",
             py::arg("each") = false, py::arg("distances_m") = std::vector<double>{1.0, 10.0, 50.0},
             py::arg("T_body_truth") = py::none(), py::arg("threads") = 0, py::arg("out") = "");
}

}  // namespace rali::python
