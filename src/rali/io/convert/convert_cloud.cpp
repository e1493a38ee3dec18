#include <utility>

#include <fmt/format.h>

#include "rali/io/convert/convert.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/cloud_targets.hpp"
#include "rali/io/input_kind.hpp"

namespace rali::io {

Result<Conversion> convert_cloud(const std::string& in, const std::string& out,
                                 const std::string& to) {
  // A folder has its own error; a file is recognised by its content.
  if (const auto kind = input_kind(in); !kind) return tl::make_unexpected(kind.error());
  const auto cloud = read_cloud_file(in);
  if (!cloud) return tl::make_unexpected(cloud.error());
  Result<LostParts> lost = to == "pcd"   ? write_cloud_pcd(out, *cloud)
                           : to == "ply" ? write_cloud_ply(out, *cloud)
                           : to == "las" ? write_cloud_las(out, *cloud)
                                         : write_cloud_kitti(out, *cloud);
  if (!lost) return tl::make_unexpected(lost.error());
  Conversion done;
  done.done = fmt::format("{} points of {} fields", cloud->size(), cloud->fields.size());
  done.lost = std::move(*lost);
  done.findings = cloud->findings;
  for (const Finding& finding : cloud->findings) done.gaps |= finding.id == "cloud.cut";
  return done;
}

}  // namespace rali::io
