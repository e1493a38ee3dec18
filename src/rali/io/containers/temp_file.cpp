#include "rali/io/containers/temp_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>
#include <zstd.h>

namespace rali::io {
namespace {

struct FreeZstd {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

}  // namespace

Result<TempFile> TempFile::create() {
  std::error_code error;
  const auto folder = std::filesystem::temp_directory_path(error);
  if (error) return fail(ErrorCode::kMachine, "TMPDIR", "no folder for temporary files");
  std::string path = (folder / "rali-XXXXXX").string();
  const int fd = ::mkstemp(path.data());
  if (fd < 0) {
    return fail(ErrorCode::kMachine, path,
                std::string("cannot be created: ") + std::strerror(errno),
                "Set TMPDIR to a folder with room.");
  }
  return TempFile(fd, path);
}

TempFile::TempFile(TempFile&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), path_(std::move(other.path_)) {}

TempFile& TempFile::operator=(TempFile&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(path_, other.path_);
  return *this;
}

TempFile::~TempFile() {
  if (fd_ < 0) return;
  ::close(fd_);
  ::unlink(path_.c_str());
}

Status TempFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      return fail(ErrorCode::kMachine, path_,
                  std::string("cannot be written: ") + std::strerror(errno),
                  "Set TMPDIR to a folder with room for the decompressed recording.");
    }
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return {};
}

Result<Unpacked> unpack_zstd_file(ByteSource& source, std::uint64_t bytes_max) {
  auto file = TempFile::create();
  if (!file) return tl::make_unexpected(file.error());
  Unpacked out{std::move(*file), {}};
  const std::unique_ptr<ZSTD_DCtx, FreeZstd> context(ZSTD_createDCtx());
  if (!context) return fail(ErrorCode::kMachine, source.name(), "out of memory");
  std::vector<std::byte> packed(ZSTD_DStreamInSize());
  std::vector<std::byte> plain(ZSTD_DStreamOutSize());
  std::uint64_t written = 0;
  std::size_t wanted = 1;  // 0: at the end of a frame
  for (std::uint64_t offset = 0; offset < source.size();) {
    const auto n =
        static_cast<std::size_t>(std::min<std::uint64_t>(packed.size(), source.size() - offset));
    const auto part = std::span(packed).first(n);
    if (const Status status = source.read(offset, part); !status) {
      return tl::make_unexpected(status.error());
    }
    offset += n;
    ZSTD_inBuffer input{part.data(), n, 0};
    bool more = true;
    while (more) {
      ZSTD_outBuffer output{plain.data(), plain.size(), 0};
      wanted = ZSTD_decompressStream(context.get(), &output, &input);
      if (ZSTD_isError(wanted) != 0) {
        out.trouble = fmt::format("is damaged near offset {}", offset - n + input.pos);
        return out;
      }
      written += output.pos;
      if (written > bytes_max) {
        return fail(ErrorCode::kInput, source.name(),
                    fmt::format("decompresses to more than {} bytes", bytes_max),
                    "Decompress it with zstd -d.");
      }
      const Status status = out.file.write(std::span(plain).first(output.pos));
      if (!status) return tl::make_unexpected(status.error());
      more = input.pos < input.size || output.pos == output.size;
    }
  }
  if (wanted != 0) out.trouble = "is cut";
  return out;
}

}  // namespace rali::io
