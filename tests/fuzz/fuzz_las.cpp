// LAS files of any content: no crash, no hang, and what is read is consistent.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rali/base/assert.hpp"
#include "rali/io/files/cloud_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto cloud = rali::io::parse_las({bytes.begin(), bytes.end()}, "fuzz.las");
  if (!cloud) return 0;
  RALI_ASSERT(cloud->data.size() == cloud->size() * cloud->point_step);
  for (std::size_t i = 0; i < cloud->fields.size(); ++i) {
    RALI_ASSERT(cloud->column(static_cast<int>(i)).size() == cloud->size());
  }
  return 0;
}
