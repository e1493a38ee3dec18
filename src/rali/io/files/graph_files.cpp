#include "rali/io/files/graph_files.hpp"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/core.h>

#include "rali/base/assert.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/content_kind.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/text.hpp"
#include "rali/io/files/tum.hpp"

namespace rali::io {
namespace {

constexpr int kDecimals = 9;
// PyFactorGraph's names: capitals except L, which marks a landmark.
constexpr std::string_view kLetters = "ABCDEFGHIJKMNOPQRSTUVWXYZ";

/// Upper triangle, row by row, with translation before rotation.
std::string upper_triangle(const geometry::Mat6& m) {
  std::string text;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) {
      text += fmt::format(" {:.9e}", m((row + 3) % 6, (col + 3) % 6) + 0.0);
    }
  }
  return text;
}

Status add_line(AtomicFile& file, std::string line) {
  line += '\n';
  return file.write(std::string_view(line));
}

constexpr std::uint64_t kG2oBytesMax = 1'000'000'000;
constexpr double kQuaternionSlack = 0.01;
// z, roll and pitch of a planar edge.
constexpr double kPlanarInformation = 1e4;

/// Reads a g2o file line by line; each function returns the error in its line.
class G2oReader {
 public:
  std::optional<std::string> line(std::string_view rest) {
    const std::string_view tag = take_word(rest);
    if (tag.empty() || tag.front() == '#' || tag == "FIX") return std::nullopt;
    if (tag == "VERTEX_SE3:QUAT") return vertex<7>(rest);
    if (tag == "VERTEX_SE2") return vertex<3>(rest);
    if (tag == "EDGE_SE3:QUAT") return edge<7, 6>(rest);
    if (tag == "EDGE_SE2") return edge<3, 3>(rest);
    return quoted(tag) + " is no tag of a pose graph";
  }

  G2oFile finish() {
    file_.planar = planar_ && !file_.graph.edges.empty();
    return std::move(file_);
  }

 private:
  template <std::size_t N>
  static std::optional<std::string> numbers(std::string_view& rest, std::array<double, N>& out) {
    for (double& value : out) {
      const std::string_view word = take_word(rest);
      if (word.empty()) return std::string("has too few numbers");
      const auto number = parse_number(word);
      if (!number || !std::isfinite(*number)) return quoted(word) + " is no finite number";
      value = *number;
    }
    return std::nullopt;
  }

  static std::optional<std::string> pose(const std::array<double, 3>& v, geometry::SE3& T) {
    T.p = {v[0], v[1], 0.0};
    T.R = geometry::so3_exp({0.0, 0.0, v[2]});
    return std::nullopt;
  }

  static std::optional<std::string> pose(const std::array<double, 7>& v, geometry::SE3& T) {
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (!(std::abs(q.norm() - 1.0) < kQuaternionSlack)) {
      return fmt::format("the quaternion has length {:.4g}, not 1", q.norm());
    }
    T.p = {v[0], v[1], v[2]};
    T.R = q.normalized().toRotationMatrix();
    return std::nullopt;
  }

  /// Index of a vertex; a new one has no pose yet.
  std::optional<std::string> index(std::string_view& rest, std::size_t& out) {
    const std::string_view word = take_word(rest);
    const auto id = parse_integer(word);
    if (!id) return quoted(word) + " is no number of a vertex";
    const auto [place, is_new] = index_.emplace(*id, file_.ids.size());
    if (is_new) {
      file_.ids.push_back(*id);
      file_.placed.push_back(false);
      file_.graph.vertices.emplace_back();
    }
    out = place->second;
    return std::nullopt;
  }

  template <std::size_t N>
  std::optional<std::string> vertex(std::string_view rest) {
    std::size_t at = 0;
    if (auto wrong = index(rest, at)) return wrong;
    if (file_.placed[at]) return fmt::format("vertex {} is there twice", file_.ids[at]);
    std::array<double, N> values = {};
    if (auto wrong = numbers(rest, values)) return wrong;
    if (auto wrong = pose(values, file_.graph.vertices[at].T)) return wrong;
    file_.placed[at] = true;
    planar_ = planar_ && N == 3;
    return at_end(rest);
  }

  /// Reads `Dim` rows of information, of which the file has the upper triangle.
  template <std::size_t N, int Dim>
  std::optional<std::string> edge(std::string_view rest) {
    GraphEdge edge;
    if (auto wrong = index(rest, edge.from)) return wrong;
    if (auto wrong = index(rest, edge.to)) return wrong;
    if (edge.from == edge.to) return std::string("an edge from a vertex to itself");
    std::array<double, N> values = {};
    if (auto wrong = numbers(rest, values)) return wrong;
    if (auto wrong = pose(values, edge.T_from_to)) return wrong;
    std::array<double, static_cast<std::size_t>(Dim * (Dim + 1) / 2)> triangle = {};
    if (auto wrong = numbers(rest, triangle)) return wrong;
    edge.information = (kPlanarInformation * geometry::Vec6::Ones()).asDiagonal();
    std::size_t k = 0;
    for (int row = 0; row < Dim; ++row) {
      for (int col = row; col < Dim; ++col) {
        const int r = place_of<Dim>(row);
        const int c = place_of<Dim>(col);
        edge.information(r, c) = edge.information(c, r) = triangle[k++];
      }
    }
    file_.graph.edges.push_back(edge);
    planar_ = planar_ && N == 3;
    return at_end(rest);
  }

  /// Index of a row of (x y z rx ry rz) or (x y rz) in (rotation, translation).
  template <int Dim>
  static int place_of(int row) {
    if (Dim == 6) return (row + 3) % 6;
    return row == 2 ? 2 : row + 3;
  }

  static std::optional<std::string> at_end(std::string_view rest) {
    if (trimmed(rest).empty()) return std::nullopt;
    return std::string("has too many numbers");
  }

  G2oFile file_;
  std::map<std::int64_t, std::size_t> index_;
  bool planar_ = true;
};

}  // namespace

Result<G2oFile> parse_g2o(std::string_view text, const std::string& name) {
  G2oReader reader;
  std::string_view line;
  for (std::uint64_t n = 1; take_line(text, line); ++n) {
    if (const auto wrong = reader.line(line)) {
      return fail(ErrorCode::kInput, fmt::format("{}:{}", name, n), *wrong);
    }
  }
  G2oFile file = reader.finish();
  if (file.ids.empty()) return fail(ErrorCode::kInput, name, "has no vertices");
  return file;
}

Result<G2oFile> read_g2o(const std::string& path) {
  const auto bytes = read_file(path, kG2oBytesMax);
  if (!bytes) return tl::make_unexpected(bytes.error());
  const std::string kind = content_kind(*bytes);
  if (kind != "text") return fail(ErrorCode::kInput, path, "is " + kind + ", not a pose graph");
  return parse_g2o(as_text(*bytes), path);
}

std::string pyfg_name(KeyframeId id) {
  if (id.vehicle.value >= kLetters.size()) return {};
  return fmt::format("{}{}", kLetters[id.vehicle.value], id.seq);
}

Status write_g2o(const std::string& path, const GraphFile& graph) {
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  for (std::size_t i = 0; i < graph.vertices.size(); ++i) {
    const std::string pose = pose_text(graph.vertices[i].T, kDecimals, kDecimals);
    if (auto status = add_line(*file, fmt::format("VERTEX_SE3:QUAT {} {}", i, pose)); !status) {
      return status;
    }
  }
  for (const GraphEdge& edge : graph.edges) {
    RALI_ASSERT(edge.from < graph.vertices.size() && edge.to < graph.vertices.size());
    const std::string pose = pose_text(edge.T_from_to, kDecimals, kDecimals);
    auto status = add_line(*file, fmt::format("EDGE_SE3:QUAT {} {} {}{}", edge.from, edge.to, pose,
                                              upper_triangle(edge.information)));
    if (!status) return status;
  }
  return file->commit();
}

Status write_pyfg(const std::string& path, const GraphFile& graph) {
  std::vector<std::string> names;
  for (const GraphVertex& vertex : graph.vertices) {
    names.push_back(pyfg_name(vertex.id));
    if (names.back().empty()) {
      return fail(ErrorCode::kNoAnswer, path,
                  fmt::format("vehicle {} has no letter; a pyfg file names at most {}",
                              vertex.id.vehicle.value, kLetters.size()));
    }
  }
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const GraphVertex& v = graph.vertices[i];
    auto status = add_line(*file, fmt::format("VERTEX_SE3:QUAT {} {} {}", format_stamp(v.t),
                                              names[i], pose_text(v.T, kDecimals, kDecimals)));
    if (!status) return status;
  }
  for (const GraphEdge& edge : graph.edges) {
    RALI_ASSERT(edge.from < names.size() && edge.to < names.size());
    auto status = add_line(
        *file, fmt::format("EDGE_SE3:QUAT {} {} {} {}{}", format_stamp(edge.t), names[edge.from],
                           names[edge.to], pose_text(edge.T_from_to, kDecimals, kDecimals),
                           upper_triangle(edge.covariance)));
    if (!status) return status;
  }
  for (const GraphRange& range : graph.ranges) {
    RALI_ASSERT(range.from < names.size() && range.to < names.size());
    auto status =
        add_line(*file, fmt::format("EDGE_RANGE {} {} {} {} {:.9e}", format_stamp(range.t),
                                    names[range.from], names[range.to],
                                    format_fixed(range.range_m, 6), range.variance_m2));
    if (!status) return status;
  }
  return file->commit();
}

}  // namespace rali::io
