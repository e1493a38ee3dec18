#include "rali/factlog/file.hpp"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace rali::factlog {

namespace {

std::string reason(int code) { return std::generic_category().message(code); }

int flags_of(File::Mode mode) {
  switch (mode) {
    case File::Mode::kFolder:
      return O_RDONLY | O_DIRECTORY | O_CLOEXEC;
    case File::Mode::kExisting:
      return O_RDWR | O_CLOEXEC;
    case File::Mode::kRead:
      return O_RDONLY | O_CLOEXEC;
    case File::Mode::kCreate:
      return O_RDWR | O_CREAT | O_CLOEXEC;
    case File::Mode::kCreateNew:
      return O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC;
  }
  return O_RDONLY;
}

bool no_room(int code) { return code == ENOSPC || code == EFBIG || code == EDQUOT; }

}  // namespace

Result<File> File::open(const std::string& path, Mode mode) {
  constexpr mode_t kReadableByAll = 0644;
  const int descriptor = ::open(path.c_str(), flags_of(mode), kReadableByAll);
  if (descriptor >= 0) return File(descriptor, path, mode == Mode::kFolder);
  return fail(ErrorCode::kMachine, path, "could not be opened: " + reason(errno),
              "Check the folder's permissions and its disk.");
}

File::File(File&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      path_(std::move(other.path_)),
      folder_(other.folder_) {}

File& File::operator=(File&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  std::swap(folder_, other.folder_);
  return *this;
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

tl::unexpected<Error> File::failed(const char* doing) const {
  return fail(ErrorCode::kMachine, path_, fmt::format("could not be {}: {}", doing, reason(errno)),
              "Check the disk.");
}

Result<std::uint64_t> File::size() const {
  struct stat info = {};
  if (::fstat(descriptor_, &info) != 0) return failed("examined");
  return static_cast<std::uint64_t>(info.st_size);
}

Result<Bytes> File::read(std::uint64_t offset, std::size_t bytes) const {
  Bytes out(bytes);
  std::size_t done = 0;
  while (done < bytes) {
    const ssize_t n =
        ::pread(descriptor_, out.data() + done, bytes - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return failed("read");
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  out.resize(done);
  return out;
}

Result<File::Written> File::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::pwrite(descriptor_, bytes.data() + done, bytes.size() - done,
                               static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && no_room(errno)) return Written::kNoRoom;
    if (n < 0) return failed("written");
    if (n == 0) return Written::kNoRoom;
    done += static_cast<std::size_t>(n);
  }
  return Written::kAll;
}

Status File::cut(std::uint64_t size) {
  int result = 0;
  do {
    result = ::ftruncate(descriptor_, static_cast<off_t>(size));
  } while (result != 0 && errno == EINTR);
  if (result != 0) return failed("shortened");
  return {};
}

Status File::sync() {
  const int result = folder_ ? ::fsync(descriptor_) : ::fdatasync(descriptor_);
  if (result != 0) return failed("synced");
  return {};
}

Result<bool> File::lock() {
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return true;
  if (errno == EWOULDBLOCK) return false;
  return failed("locked");
}

std::uint64_t File::free_bytes() const {
  struct statvfs info = {};
  if (::fstatvfs(descriptor_, &info) != 0) return 0;
  return static_cast<std::uint64_t>(info.f_bavail) * info.f_frsize;
}

}  // namespace rali::factlog
