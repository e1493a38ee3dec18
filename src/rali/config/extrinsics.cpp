#include "rali/config/extrinsics.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "rali/config/apply.hpp"

namespace rali::config {
namespace {

constexpr double kRadPerDeg = 3.14159265358979323846 / 180.0;
constexpr double kMaxLever_m = 100.0;
constexpr double kRotationTolerance = 2e-3;  // allows numbers rounded to three decimals
constexpr double kExact = 1e-9;              // below this no normalisation is needed

struct PoseText {
  std::array<double, 3> xyz_m = {0.0, 0.0, 0.0};
  std::array<double, 3> rpy_deg = {0.0, 0.0, 0.0};
  std::array<double, 4> quat_xyzw = {0.0, 0.0, 0.0, 1.0};
  std::array<double, 9> matrix = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  std::string from_tf;
};

tl::unexpected<Error> refuse(const Node& node, const std::string& key, const std::string& what,
                             const std::string& remedy = {}) {
  return fail(ErrorCode::kUsage, node.where, key + ' ' + what, remedy);
}

CustomTarget matrix_target(std::array<double, 9>& matrix) {
  CustomTarget target;
  target.type = "three rows of three numbers, each -1.1 to 1.1";
  target.decode = [&matrix](const Node& node, const std::string& key) -> Status {
    if (node.kind != Node::Kind::kSequence || node.children.size() != 3) {
      return refuse(node, key, "is not three rows of three numbers",
                    "Give the 3x3 rotation here and the translation as xyz_m.");
    }
    for (std::size_t row = 0; row < 3; ++row) {
      std::array<double, 3> values{};
      const Field field{key, std::span<double>(values), -1.1, 1.1, ""};
      if (Status status = decode_field(field, node.children[row]); !status) return status;
      std::copy(values.begin(), values.end(),
                matrix.begin() + static_cast<std::ptrdiff_t>(3 * row));
    }
    return {};
  };
  target.encode = [] { return std::string(); };
  return target;
}

Result<geometry::Mat3> rotation_of_matrix(const std::array<double, 9>& m, const Node& node,
                                          const std::string& key) {
  geometry::Mat3 R;
  R << m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8];
  const double off = (R.transpose() * R - geometry::Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(off < kRotationTolerance)) {
    return refuse(node, key + ".matrix",
                  fmt::format("is no rotation: its rows are not orthonormal (off by {:.2g})", off));
  }
  if (R.determinant() < 0.0) {
    return refuse(node, key + ".matrix", "has determinant -1: it mirrors",
                  "One axis has the wrong sign, or the sensor's frame is left-handed.");
  }
  return off > kExact ? geometry::so3_normalised(R) : R;
}

Result<geometry::Mat3> rotation_of(const PoseText& pose, const std::string& form, const Node& node,
                                   const std::string& key) {
  if (form == "matrix") return rotation_of_matrix(pose.matrix, node, key);
  if (form == "quat_xyzw") {
    const auto& q = pose.quat_xyzw;
    Eigen::Quaterniond quat(q[3], q[0], q[1], q[2]);
    if (!(std::abs(quat.norm() - 1.0) < kRotationTolerance)) {
      return refuse(node, key + ".quat_xyzw", fmt::format("has length {:.4g}, not 1", quat.norm()),
                    "The order is x, y, z, w.");
    }
    return quat.normalized().toRotationMatrix();
  }
  const auto& a = pose.rpy_deg;
  return geometry::rotation_from_rpy(a[0] * kRadPerDeg, a[1] * kRadPerDeg, a[2] * kRadPerDeg);
}

std::string list_text(std::span<const double> values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + yaml_number(value);
  return text + "]";
}

std::string spelling(const PoseText& pose, const std::string& form) {
  std::string text = "{xyz_m: " + list_text(pose.xyz_m);
  const std::span<const double> m(pose.matrix);
  if (form == "rpy_deg") text += ", rpy_deg: " + list_text(pose.rpy_deg);
  if (form == "quat_xyzw") text += ", quat_xyzw: " + list_text(pose.quat_xyzw);
  if (form == "matrix") {
    text += fmt::format(", matrix: [{}, {}, {}]", list_text(m.subspan(0, 3)),
                        list_text(m.subspan(3, 3)), list_text(m.subspan(6, 3)));
  }
  return text + "}";
}

Status decode_pose(Extrinsics& extrinsics, const Node& node, const std::string& key) {
  PoseText pose;
  const std::string prefix = key + '.';
  const FieldList fields{
      {prefix + "xyz_m", std::span<double>(pose.xyz_m), -kMaxLever_m, kMaxLever_m, ""},
      {prefix + "rpy_deg", std::span<double>(pose.rpy_deg), -360.0, 360.0, ""},
      {prefix + "quat_xyzw", std::span<double>(pose.quat_xyzw), -1.1, 1.1, ""},
      {prefix + "matrix", matrix_target(pose.matrix), 0.0, 0.0, ""},
      {prefix + "from_tf", &pose.from_tf, 0.0, 0.0, ""}};
  Origins given;
  if (Status status = apply_map(node, prefix, "", fields, given); !status) return status;

  if (given.count(prefix + "from_tf") > 0) {
    if (given.size() > 1) return refuse(node, key, "has from_tf and numbers", "Keep one of them.");
    if (pose.from_tf.empty()) return refuse(node, key + ".from_tf", "names no frame");
    extrinsics = {Extrinsics::Source::kFromTf, {}, pose.from_tf, {}};
    return {};
  }
  std::string form;
  for (const char* const rotation : {"rpy_deg", "quat_xyzw", "matrix"}) {
    if (given.count(prefix + rotation) == 0) continue;
    if (!form.empty()) {
      return refuse(node, key, fmt::format("has two rotations, {} and {}", form, rotation),
                    "Keep one of them.");
    }
    form = rotation;
  }
  if (given.empty()) {
    return refuse(node, key, "is empty", "Write {xyz_m: [x, y, z], rpy_deg: [roll, pitch, yaw]}.");
  }
  const Result<geometry::Mat3> R = rotation_of(pose, form, node, key);
  if (!R) return tl::make_unexpected(R.error());
  extrinsics.source = Extrinsics::Source::kGiven;
  extrinsics.T = {*R, geometry::Vec3(pose.xyz_m[0], pose.xyz_m[1], pose.xyz_m[2])};
  extrinsics.tf_frame.clear();
  extrinsics.form = spelling(pose, form);
  return {};
}

std::string encode_extrinsics(const Extrinsics& extrinsics) {
  if (extrinsics.source == Extrinsics::Source::kAuto) return "auto";
  if (extrinsics.source == Extrinsics::Source::kFromTf) {
    return "{from_tf: " + yaml_quoted(extrinsics.tf_frame) + "}";
  }
  if (!extrinsics.form.empty()) return extrinsics.form;
  PoseText pose;
  for (std::size_t i = 0; i < 9; ++i) {
    pose.matrix[i] = extrinsics.T.R(static_cast<int>(i / 3), static_cast<int>(i % 3));
  }
  for (std::size_t i = 0; i < 3; ++i) pose.xyz_m[i] = extrinsics.T.p(static_cast<int>(i));
  return spelling(pose, extrinsics.T.R.isIdentity(0.0) ? "" : "matrix");
}

void add_words(std::string& text, double value, double minimum, std::string_view positive,
               std::string_view negative) {
  if (std::abs(value) < minimum) return;
  if (!text.empty()) text += ", ";
  text += fmt::format(fmt::runtime(value > 0.0 ? positive : negative), std::abs(value));
}

}  // namespace

CustomTarget extrinsics_target(Extrinsics& extrinsics, bool auto_allowed) {
  CustomTarget target;
  target.type = auto_allowed ? "auto, {xyz_m, rpy_deg | quat_xyzw | matrix} or {from_tf: FRAME}"
                             : "{xyz_m, rpy_deg | quat_xyzw | matrix} or {from_tf: FRAME}";
  target.decode = [&extrinsics, auto_allowed, type = target.type](
                      const Node& node, const std::string& key) -> Status {
    if (auto_allowed && node.kind == Node::Kind::kScalar && node.text == "auto") {
      extrinsics = {};
      return {};
    }
    if (node.kind != Node::Kind::kMap) return refuse(node, key, "is no pose; allowed is " + type);
    return decode_pose(extrinsics, node, key);
  };
  target.encode = [&extrinsics] { return encode_extrinsics(extrinsics); };
  return target;
}

std::string pose_in_words(const geometry::SE3& T_body_sensor) {
  constexpr double kMin_m = 0.005, kMin_deg = 0.05;
  std::string where;
  add_words(where, T_body_sensor.p.x(), kMin_m, "{:.2f} m forward", "{:.2f} m back");
  add_words(where, T_body_sensor.p.y(), kMin_m, "{:.2f} m left", "{:.2f} m right");
  add_words(where, T_body_sensor.p.z(), kMin_m, "{:.2f} m up", "{:.2f} m down");
  const geometry::Vec3 rpy = geometry::rpy_from_rotation(T_body_sensor.R) / kRadPerDeg;
  std::string turned;
  add_words(turned, rpy.z(), kMin_deg, "turned {:.1f} deg left", "turned {:.1f} deg right");
  add_words(turned, rpy.y(), kMin_deg, "nose {:.1f} deg down", "nose {:.1f} deg up");
  add_words(turned, rpy.x(), kMin_deg, "rolled {:.1f} deg right", "rolled {:.1f} deg left");
  const std::string place =
      where.empty() ? "at the origin of the body" : where + " of the body's origin";
  return place + ", " + (turned.empty() ? "not turned" : turned);
}

}  // namespace rali::config
