#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "rali/base/result.hpp"
#include "rali/factlog/record.hpp"

namespace rali::factlog {

/// An open file or directory, closed by the destructor.
class File {
 public:
  enum class Mode {
    kFolder,     ///< a directory, for its lock and to sync its entries
    kExisting,   ///< read and write
    kRead,       ///< read only
    kCreate,     ///< as kExisting; created if absent
    kCreateNew,  ///< as kExisting; must not exist yet
  };

  /// Errors: kMachine.
  [[nodiscard]] static Result<File> open(const std::string& path, Mode mode);

  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;
  ~File();

  [[nodiscard]] Result<std::uint64_t> size() const;

  /// Reads this many bytes from `offset` on; fewer only at the end of the file.
  [[nodiscard]] Result<Bytes> read(std::uint64_t offset, std::size_t bytes) const;

  enum class Written { kAll, kNoRoom };

  /// kNoRoom: the disk, a quota or a limit of the process is exhausted; a part may be written.
  [[nodiscard]] Result<Written> write(std::uint64_t offset, std::span<const std::byte> bytes);

  [[nodiscard]] Status cut(std::uint64_t size);

  /// Returns when data and size, or the entries of a directory, are on the disk.
  [[nodiscard]] Status sync();

  /// False: another process, or another open file, has the lock.
  [[nodiscard]] Result<bool> lock();

  [[nodiscard]] const std::string& path() const { return path_; }

  [[nodiscard]] std::uint64_t free_bytes() const;

 private:
  File(int descriptor, std::string path, bool folder)
      : descriptor_(descriptor), path_(std::move(path)), folder_(folder) {}

  [[nodiscard]] tl::unexpected<Error> failed(const char* doing) const;

  int descriptor_ = -1;
  std::string path_;
  bool folder_ = false;
};

}  // namespace rali::factlog
