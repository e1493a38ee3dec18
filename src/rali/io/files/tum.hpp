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
/// so that one rotation has one text.
[[nodiscard]] std::string tum_line(const StampedPose& pose);

/// "x y z qx qy qz qw" with the given decimals, quaternion as in tum_line.
[[nodiscard]] std::string pose_text(const geometry::SE3& T, int decimals_position,
                                    int decimals_rotation);

/// Writes a trajectory as a stream (see StreamFile).
class TumWriter {
 public:
  /// `header`: lines of comment, written with "# " before each.
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
  std::vector<std::string> header;  ///< lines of comment without "#"
  FindingList findings;             ///< time going back, a cut last line
};

/// Line of a trajectory's header that says whether gravity has levelled its frame.
[[nodiscard]] std::string frame_line(bool levelled);

/// What frame_line says in a header; nothing where the header has no such line.
[[nodiscard]] std::optional<bool> is_levelled(const std::vector<std::string>& header);

/// Reads a trajectory; blanks, tabs or commas between the numbers. Quaternions are normalised;
/// what is farther than 1 % from unit length is refused. Errors: kInput with file and line.
[[nodiscard]] Result<TumFile> read_tum(const std::string& path);
[[nodiscard]] Result<TumFile> parse_tum(std::string_view text, const std::string& name);

}  // namespace rali::io
