#include "rali/io/files/png_writer.hpp"

#include <png.h>

#include "rali/base/assert.hpp"

namespace rali::io {

std::vector<std::byte> png_bytes(const IndexedImage& image) {
  RALI_ASSERT(!image.index.empty() &&
              image.index.size() == std::size_t{image.width} * image.height);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.width;
  png.height = image.height;
  png.format = PNG_FORMAT_RGB_COLORMAP;
  png.colormap_entries = static_cast<png_uint_32>(image.palette.size());
  std::vector<std::byte> bytes(PNG_IMAGE_PNG_SIZE_MAX(png));
  png_alloc_size_t size = bytes.size();
  const int written = png_image_write_to_memory(&png, bytes.data(), &size, 0, image.index.data(), 0,
                                                image.palette.data());
  RALI_ASSERT(written != 0);
  bytes.resize(size);
  return bytes;
}

}  // namespace rali::io
