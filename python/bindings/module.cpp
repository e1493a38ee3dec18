#include <map>

#include "arrays.hpp"
#include "rali/error.hpp"
#include "rali/version.hpp"

namespace rali::python {
namespace {

/// Raises the class of this name from rali._errors, with the parts of the message.
void raise(const char* name, const Exception& error) {
  const py::object type = py::module_::import("rali._errors").attr(name);
  const py::object value = type(error.what(), error.where(), error.problem(), error.remedy());
  PyErr_SetObject(type.ptr(), value.ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const SettingsError& error) {
    raise("SettingsError", error);
  } catch (const InputError& error) {
    raise("InputError", error);
  } catch (const NoAnswerError& error) {
    raise("NoAnswerError", error);
  } catch (const MachineError& error) {
    raise("MachineError", error);
  } catch (const Exception& error) {
    raise("Error", error);
  }
}

}  // namespace

py::array_t<double> array_of(const Pose3& T) {
  py::array_t<double> result({4, 4});
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) result.mutable_at(row, column) = T(row, column);
  }
  return result;
}

py::array_t<double> array_of(const Covariance6& covariance) {
  py::array_t<double> result({6, 6});
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      result.mutable_at(row, column) = covariance(row, column);
    }
  }
  return result;
}

py::array_t<double> array_of(const Vec3& v) {
  py::array_t<double> result(3);
  for (int row = 0; row < 3; ++row) result.mutable_at(row) = v[row];
  return result;
}

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

Pose3 pose_of(const py::object& matrix, const std::string& what) {
  Pose3 T = Pose3::Identity();
  if (matrix.is_none()) return T;
  const auto values = Doubles::ensure(matrix);
  if (!values || values.ndim() != 2 || values.shape(0) != 4 || values.shape(1) != 4) {
    throw SettingsError(what, "is no array of shape (4, 4)", "Give a homogeneous matrix.");
  }
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) T(row, column) = values.at(row, column);
  }
  const Eigen::Matrix3d R = T.linear();
  if (!T.matrix().allFinite() || !(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0.0) {
    throw SettingsError(what, "is no rotation and translation", "Check the upper left 3x3.");
  }
  return T;
}

std::vector<Vec3> points_of(const py::object& points, const std::string& what) {
  const auto values = Doubles::ensure(points);
  const bool one = values && values.ndim() == 1 && values.shape(0) == 3;
  if (!one && (!values || values.ndim() != 2 || values.shape(1) != 3)) {
    throw SettingsError(what, "is no array of shape (N, 3)", "Give x, y, z of each point.");
  }
  if (one) return {Vec3(values.at(0), values.at(1), values.at(2))};
  std::vector<Vec3> result;
  for (py::ssize_t i = 0; i < values.shape(0); ++i) {
    result.emplace_back(values.at(i, 0), values.at(i, 1), values.at(i, 2));
  }
  return result;
}

std::string path_of(const py::object& path) {
  return py::module_::import("os").attr("fspath")(path).cast<std::string>();
}

std::map<std::string, std::string> settings_of(const py::object& settings) {
  std::map<std::string, std::string> result;
  if (settings.is_none()) return result;
  const py::object dumps = py::module_::import("json").attr("dumps");
  for (const auto& [key, value] : settings.cast<py::dict>()) {
    result[py::str(key)] = py::isinstance<py::str>(value) ? value.cast<std::string>()
                                                          : dumps(value).cast<std::string>();
  }
  return result;
}

void bind_errors(py::module_& module) {
  py::register_exception_translator(&translate);
  module.def("version", &version);
}

}  // namespace rali::python

PYBIND11_MODULE(_rali, module) {
  rali::python::bind_errors(module);
  rali::python::bind_vehicle(module);
  rali::python::bind_results(module);
  rali::python::bind_map(module);
}
