#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/io/files/stream_file.hpp"

namespace rali::io {

struct StampedPose {
  Time t;
  geometry::SE3 T;  ///< which frames: see the file's header or the caller
};

/// `stamp_s x y z qx qy qz qw`, %.9f %.6f x3 %.9f x4, without line end; the quaternion has w >= 0,
/// so that each rotation has a unique text.
[[nodiscard]] std::string tum_line(const StampedPose& pose);

/// "x y z qx qy qz qw" with the given decimals, quaternion as in tum_line.
[[nodiscard]] std::string pose_text(const geometry::SE3& T, int decimals_position,
                                    int decimals_rotation);

/// Writes a trajectory as a stream (see StreamFile).
class TumWriter {
 public:
  /// `header`: comment lines, written with "# " before each.
  [[nodiscard]] static Result<TumWriter> create(const std::string& path,
                                                const std::vector<std::string>& header);

  [[nodiscard]] Status add(const StampedPose& pose);

  [[nodiscard]] Status finish() { return file_.finish(); }

 private:
  explicit TumWriter(StreamFile file) : file_(std::move(file)) {}

  StreamFile file_;
};

struct TumFile {
  std::vector<StampedPose> poses;   ///< in the order of the file
  std::vector<std::string> header;  ///< comment lines without "#"
  FindingList findings;             ///< stamps that go back, a truncated last line
};

/// Comment line of a trajectory's header: whether its frame is aligned with gravity.
[[nodiscard]] std::string frame_line(bool levelled);

/// Parses frame_line from a header; nothing if the header has no such line.
[[nodiscard]] std::optional<bool> is_levelled(const std::vector<std::string>& header);

/// Reads a trajectory; blanks, tabs or commas between the numbers. Quaternions are normalised;
/// deviations of more than 1 % from unit length are rejected. Errors: kInput with file and line.
[[nodiscard]] Result<TumFile> read_tum(const std::string& path);
[[nodiscard]] Result<TumFile> parse_tum(std::string_view text, const std::string& name);

}  // namespace rali::io
