#pragma once

#include <map>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "rali/types.hpp"

namespace rali::python {

namespace py = pybind11;

/// An array that views the numbers of `values`, which belongs to `owner`; no copy. None if empty.
template <class T>
py::object view(const std::vector<T>& values, py::handle owner) {
  if (values.empty()) return py::none();
  return py::array_t<T>({static_cast<py::ssize_t>(values.size())},
                        {static_cast<py::ssize_t>(sizeof(T))}, values.data(), owner);
}

/// The same with three numbers per row.
template <class T>
py::object view_rows3(const std::vector<T>& values, py::handle owner) {
  constexpr py::ssize_t kStep = sizeof(T);
  return py::array_t<T>({static_cast<py::ssize_t>(values.size() / 3), py::ssize_t{3}},
                        {3 * kStep, kStep}, values.data(), owner);
}

/// Poses or covariances, stored contiguously column by column, as (N, n, n).
template <class Matrix>
py::object view_matrices(const std::vector<Matrix>& values, py::ssize_t n, py::handle owner) {
  constexpr py::ssize_t kStep = sizeof(double);
  static_assert(sizeof(Matrix) % sizeof(double) == 0);
  const auto* const data = reinterpret_cast<const double*>(values.data());
  return py::array_t<double>({static_cast<py::ssize_t>(values.size()), n, n},
                             {n * n * kStep, kStep, n * kStep}, data, owner);
}

[[nodiscard]] py::array_t<double> array_of(const Pose3& T);
[[nodiscard]] py::array_t<double> array_of(const Covariance6& covariance);
[[nodiscard]] py::array_t<double> array_of(const Vec3& v);

/// A pose from an array of shape (4, 4). Throws SettingsError that names `what`.
[[nodiscard]] Pose3 pose_of(const py::object& matrix, const std::string& what);

/// Positions from an array of shape (N, 3) or (3,).
[[nodiscard]] std::vector<Vec3> points_of(const py::object& points, const std::string& what);

/// Path-like objects and strings.
[[nodiscard]] std::string path_of(const py::object& path);

/// A dict of settings: strings are kept as YAML, other values become JSON, which is YAML too.
[[nodiscard]] std::map<std::string, std::string> settings_of(const py::object& settings);

void bind_errors(py::module_& module);
void bind_vehicle(py::module_& module);
void bind_map(py::module_& module);
void bind_results(py::module_& module);

}  // namespace rali::python
