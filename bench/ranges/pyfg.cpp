#include "pyfg.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include "number_rows.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::ranges_bench {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

namespace {

using Numbers = std::span<const double>;

std::optional<PyfgName> name_of(std::string_view word) {
  if (word.size() < 2 || word.size() > 9 || word[0] < 'A' || word[0] > 'Z') return std::nullopt;
  const double number = number_of(word.substr(1));
  const bool digits =
      std::all_of(word.begin() + 1, word.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!digits) return std::nullopt;
  return PyfgName{word[0], static_cast<int>(number)};
}

SE3 planar_pose(Numbers n) {
  return {geometry::rotation_from_rpy(0.0, 0.0, n[2]), Vec3(n[0], n[1], 0.0)};
}

/// x y z qx qy qz qw
std::optional<SE3> spatial_pose(Numbers n) {
  const Eigen::Quaterniond q(n[6], n[3], n[4], n[5]);
  if (std::abs(q.norm() - 1.0) > 0.01) return std::nullopt;
  return SE3{q.normalized().toRotationMatrix(), Vec3(n[0], n[1], n[2])};
}

/// Covariance of x y theta, upper triangle by rows.
Mat6 planar_covariance(Numbers n) {
  Mat6 C = kPlanarSigma * kPlanarSigma * Mat6::Identity();
  constexpr int kPlace[] = {3, 4, 2};
  for (int r = 0, k = 0; r < 3; ++r) {
    for (int c = r; c < 3; ++c, ++k) {
      C(kPlace[r], kPlace[c]) = C(kPlace[c], kPlace[r]) = n[static_cast<std::size_t>(k)];
    }
  }
  return C;
}

/// Covariance of x y z and rotation, upper triangle by rows.
Mat6 spatial_covariance(Numbers n) {
  Mat6 C;
  for (int r = 0, k = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c, ++k) {
      const int row = (r + 3) % 6;
      const int column = (c + 3) % 6;
      C(row, column) = C(column, row) = n[static_cast<std::size_t>(k)];
    }
  }
  return C;
}

/// One pass over the lines; a method returns the fault of its line, or nothing.
class Reader {
 public:
  Result<Pyfg> read(std::string_view text, const std::string& name) {
    std::size_t line = 0;
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      ++line;
      const std::string wrong = read_line(text.substr(0, end));
      if (!wrong.empty()) return fail(ErrorCode::kInput, fmt::format("{}:{}", name, line), wrong);
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (out_.poses.empty()) return fail(ErrorCode::kInput, name, "there is no pose in it");
    return std::move(out_);
  }

 private:
  struct Tag {
    std::string_view tag;
    std::size_t names, numbers;
    bool planar, either;
    std::string (Reader::*take)(Numbers);
  };

  static std::span<const Tag> tags() {
    static const Tag kTags[] = {
        {"VERTEX_SE2", 1, 3, true, false, &Reader::pose},
        {"VERTEX_SE3:QUAT", 1, 7, false, false, &Reader::pose},
        {"VERTEX_XY", 1, 2, true, false, &Reader::landmark},
        {"VERTEX_XYZ", 1, 3, false, false, &Reader::landmark},
        {"EDGE_SE2", 2, 9, true, false, &Reader::step},
        {"EDGE_SE3:QUAT", 2, 28, false, false, &Reader::step},
        {"EDGE_RANGE", 2, 2, false, true, &Reader::range},
    };
    return kTags;
  }

  std::string read_line(std::string_view line) {
    const auto words = split(line, ' ');
    if (words.empty()) return {};
    const auto tag =
        std::find_if(tags().begin(), tags().end(), [&](const Tag& t) { return t.tag == words[0]; });
    if (tag == tags().end()) {
      ++out_.left_out;
      return {};
    }
    // A landmark has no time of its own: VERTEX_XY L0 x y.
    const bool timed = tag->take != &Reader::landmark;
    const std::size_t expected = 1 + (timed ? 1 : 0) + tag->names + tag->numbers;
    if (words.size() != expected) {
      return fmt::format("{} has {} words and should have {}", tag->tag, words.size(), expected);
    }
    names_.clear();
    numbers_.clear();
    const std::size_t first = timed ? 2 : 1;
    for (std::size_t k = 1; k < words.size(); ++k) {
      if (k >= first && k < first + tag->names) {
        const auto name = name_of(words[k]);
        if (!name) return fmt::format("\"{}\" is no name of a pose or landmark", words[k]);
        names_.push_back(*name);
        continue;
      }
      const double value = number_of(words[k]);
      if (!std::isfinite(value)) return fmt::format("\"{}\" is no finite number", words[k]);
      numbers_.push_back(value);
    }
    t_ = timed ? Time::from_s(numbers_.front()) : Time();
    if (!tag->either && planar_ && *planar_ != tag->planar) {
      return "planar and spatial lines are mixed";
    }
    if (!tag->either) planar_ = tag->planar;
    out_.planar = planar_.value_or(false);
    return (this->*tag->take)(Numbers(numbers_).subspan(timed ? 1 : 0));
  }

  std::string pose(Numbers n) {
    const auto T = out_.planar ? std::optional(planar_pose(n)) : spatial_pose(n);
    if (!T) return "the quaternion is not of length 1";
    if (names_[0].robot == 'L') return "L is for landmarks";
    return out_.poses.emplace(names_[0], PyfgPose{t_, *T}).second ? "" : "this pose is there twice";
  }

  std::string landmark(Numbers n) {
    if (names_[0].robot != 'L') return "a landmark's name begins with L";
    const Vec3 p(n[0], n[1], out_.planar ? 0.0 : n[2]);
    return out_.landmarks_m.emplace(names_[0], p).second ? "" : "this landmark is there twice";
  }

  std::string step(Numbers n) {
    PyfgStep s;
    s.from = names_[0];
    s.to = names_[1];
    const auto T = out_.planar ? std::optional(planar_pose(n)) : spatial_pose(n);
    if (!T) return "the quaternion is not of length 1";
    if (!known(s.from) || !known(s.to)) return "it names a pose that is not there above";
    s.T_from_to = *T;
    s.covariance = out_.planar ? planar_covariance(n.subspan(3)) : spatial_covariance(n.subspan(7));
    const Eigen::LLT<Mat6> factor(s.covariance);
    if (factor.info() != Eigen::Success) return "the covariance is not positive";
    out_.steps.push_back(s);
    return {};
  }

  std::string range(Numbers n) {
    if (!known(names_[0]) || !known(names_[1])) return "it names what is not there above";
    if (!(n[1] > 0.0)) return "the variance is not positive";
    if (n[0] < 0.0) return "the range is negative";
    out_.ranges.push_back({t_, names_[0], names_[1], n[0], n[1]});
    return {};
  }

  [[nodiscard]] bool known(const PyfgName& name) const {
    return out_.poses.contains(name) || out_.landmarks_m.contains(name);
  }

  Pyfg out_;
  std::optional<bool> planar_;
  Time t_;
  std::vector<PyfgName> names_;
  std::vector<double> numbers_;
};

}  // namespace

Result<Pyfg> parse_pyfg(std::string_view text, const std::string& name) {
  return Reader().read(text, name);
}

Result<Pyfg> read_pyfg(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(ErrorCode::kInput, path.string(), "this file cannot be read");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  return parse_pyfg(text, path.filename().string());
}

}  // namespace rali::ranges_bench
