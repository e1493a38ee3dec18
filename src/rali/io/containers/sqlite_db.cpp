#include "rali/io/containers/sqlite_db.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/mman.h>
#include <unistd.h>

namespace rali::io {
namespace {

// Instructions of SQLite's virtual machine. A full read takes some fifty per row, and a row has at
// least thirty bytes: only a damaged tree with cycles needs more.
constexpr std::uint64_t kBudgetBase = 2'000'000;
constexpr std::uint64_t kBudgetPerByte = 8;
constexpr int kBudgetTick = 1'000;

/// Called every kBudgetTick instructions; a nonzero result stops the statement.
int spend(void* budget) {
  auto& left = *static_cast<std::uint64_t*>(budget);
  if (left == 0) return 1;
  --left;
  return 0;
}

/// A path in the form of a URI, which is required for the option "immutable".
std::string uri_of(const std::string& path, std::string_view options) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).string()) {
    if (c == '?' || c == '#' || c == '%') {
      const auto byte = static_cast<unsigned char>(c);
      uri += '%';
      uri += kHex[byte >> 4];
      uri += kHex[byte & 15];
    } else {
      uri += c;
    }
  }
  return uri.append(options);
}

Result<sqlite3*> open(const std::string& where, const std::string& name, int flags) {
  sqlite3* database = nullptr;
  const int status = sqlite3_open_v2(where.c_str(), &database, flags, nullptr);
  if (status == SQLITE_OK) return database;
  const std::string reason = database ? sqlite3_errmsg(database) : "out of memory";
  sqlite3_close(database);
  return fail(ErrorCode::kMachine, name, "cannot be opened by SQLite: " + reason);
}

/// A killed recorder may leave its last messages in a write-ahead log next to the file.
bool has_write_ahead_log(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path + "-wal", error);
  return !error && size > 0;
}

// Offsets in the first page (sqlite.org/fileformat2.html).
constexpr std::size_t kPageSizeAt = 16;
constexpr std::size_t kWriteVersionAt = 18;
constexpr std::size_t kReadVersionAt = 19;

/// Bytes of whole pages. SQLite would pad the last page of a truncated file with zeros and return
/// them as data.
std::uint64_t whole_pages(std::span<const std::byte> start, std::uint64_t bytes) {
  if (start.size() < kPageSizeAt + 2) return bytes;
  const auto high = std::to_integer<std::uint64_t>(start[kPageSizeAt]);
  const auto low = std::to_integer<std::uint64_t>(start[kPageSizeAt + 1]);
  const std::uint64_t page = high == 0 && low == 1 ? 65536 : high << 8 | low;
  return page < 512 ? bytes : bytes - bytes % page;
}

std::array<char, 20> start_of(const std::string& path) {
  std::array<char, 20> start{};
  std::ifstream(path, std::ios::binary).read(start.data(), start.size());
  return start;
}

}  // namespace

SqlStatement::SqlStatement(sqlite3_stmt* statement) : statement_(statement) {}

void SqlStatement::Finalize::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

SqlStatement::Step SqlStatement::step() {
  const int status = sqlite3_step(statement_.get());
  if (status == SQLITE_ROW) return Step::kRow;
  return status == SQLITE_DONE ? Step::kDone : Step::kFailed;
}

void SqlStatement::reset() { sqlite3_reset(statement_.get()); }

void SqlStatement::bind(int parameter, std::int64_t value) {
  sqlite3_bind_int64(statement_.get(), parameter, value);
}

void SqlStatement::bind(int parameter, const std::string& value) {
  sqlite3_bind_text64(statement_.get(), parameter, value.data(), value.size(), SQLITE_TRANSIENT,
                      SQLITE_UTF8);
}

void SqlStatement::bind(int parameter, std::span<const std::byte> value) {
  // A null pointer would bind NULL instead of an empty blob.
  const void* data = value.empty() ? static_cast<const void*>("") : value.data();
  sqlite3_bind_blob64(statement_.get(), parameter, data, value.size(), SQLITE_TRANSIENT);
}

std::int64_t SqlStatement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

std::string SqlStatement::text(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_.get(), column);
  const int bytes = sqlite3_column_bytes(statement_.get(), column);
  if (text == nullptr) return {};
  return {reinterpret_cast<const char*>(text), static_cast<std::size_t>(bytes)};
}

std::optional<std::span<const std::byte>> SqlStatement::blob(int column) const {
  if (sqlite3_column_type(statement_.get(), column) == SQLITE_NULL) return std::nullopt;
  const void* data = sqlite3_column_blob(statement_.get(), column);
  const int bytes = sqlite3_column_bytes(statement_.get(), column);
  if (data == nullptr && bytes > 0) return std::nullopt;
  return std::span(static_cast<const std::byte*>(data), static_cast<std::size_t>(bytes));
}

SqlDatabase::SqlDatabase(sqlite3* database, std::string name)
    : budget_(std::make_unique<std::uint64_t>(0)), database_(database), name_(std::move(name)) {}

void SqlDatabase::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

Result<SqlDatabase> SqlDatabase::open_file(const std::string& path, std::uint64_t value_bytes_max) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  if (error) return fail(ErrorCode::kInput, path, "cannot be opened: " + error.message());
  const auto start = start_of(path);
  const std::uint64_t whole = whole_pages(std::as_bytes(std::span(start)), bytes);
  if (whole != bytes) return open_cut_file(path, whole, value_bytes_max);
  constexpr int kFlags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
  if (has_write_ahead_log(path)) {
    // Needs a lock file next to the database; without write permission the log is ignored.
    auto handle = open(uri_of(path, "?mode=ro"), path, kFlags);
    if (handle) {
      SqlDatabase database(*handle, path);
      const Status status = database.prepare_for_reading(bytes, value_bytes_max);
      if (status && database.prepare("SELECT count(*) FROM sqlite_master")) return database;
    }
  }
  // "immutable": no lock and no journal, so that a read-only folder can be read.
  auto handle = open(uri_of(path, "?mode=ro&immutable=1"), path, kFlags);
  if (!handle) return tl::make_unexpected(handle.error());
  SqlDatabase database(*handle, path);
  const Status status = database.prepare_for_reading(bytes, value_bytes_max);
  if (!status) return tl::make_unexpected(status.error());
  return database;
}

/// Passes the whole pages to SQLite as an image in memory, which the system reads as needed.
Result<SqlDatabase> SqlDatabase::open_cut_file(const std::string& path,
                                               std::uint64_t whole_pages_bytes,
                                               std::uint64_t value_bytes_max) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return fail(ErrorCode::kMachine, path, "cannot be opened");
  const auto size = static_cast<std::size_t>(whole_pages_bytes);
  // Private and writable: attach() changes two bytes of this copy only.
  void* image =
      size == 0 ? MAP_FAILED
                : ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_NORESERVE, fd, 0);
  ::close(fd);
  if (image == MAP_FAILED) {
    return fail(ErrorCode::kInput, path, "SQLite database cut within its first page");
  }
  std::shared_ptr<void> mapping(image, [size](void* begin) { ::munmap(begin, size); });
  auto handle = open(":memory:", path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX);
  if (!handle) return tl::make_unexpected(handle.error());
  SqlDatabase database(*handle, path);
  database.mapping_ = std::move(mapping);
  Status status = database.attach({static_cast<std::byte*>(image), size}, /*owned=*/false);
  if (status) status = database.prepare_for_reading(whole_pages_bytes, value_bytes_max);
  if (!status) return tl::make_unexpected(status.error());
  return database;
}

Result<SqlDatabase> SqlDatabase::open_bytes(std::span<const std::byte> bytes,
                                            std::uint64_t value_bytes_max) {
  const std::uint64_t whole = whole_pages(bytes, bytes.size());
  bytes = bytes.first(static_cast<std::size_t>(whole));
  auto handle = open(":memory:", "memory", SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX);
  if (!handle) return tl::make_unexpected(handle.error());
  SqlDatabase database(*handle, "memory");
  auto* copy = static_cast<std::byte*>(sqlite3_malloc64(bytes.size() + 1));
  if (copy == nullptr) return fail(ErrorCode::kMachine, "memory", "out of memory");
  std::copy(bytes.begin(), bytes.end(), copy);
  Status status = database.attach({copy, bytes.size()}, /*owned=*/true);
  if (status) status = database.prepare_for_reading(bytes.size(), value_bytes_max);
  if (!status) return tl::make_unexpected(status.error());
  return database;
}

/// Attaches the image as the database. SQLite frees it if `owned`, also on failure.
Status SqlDatabase::attach(std::span<std::byte> image, bool owned) {
  // An image in memory cannot have a write-ahead log; version 1 declares that there is none.
  if (image.size() > kReadVersionAt) {
    image[kWriteVersionAt] = image[kReadVersionAt] = std::byte{1};
  }
  const auto size = static_cast<sqlite3_int64>(image.size());
  const unsigned flags = SQLITE_DESERIALIZE_READONLY |
                         (owned ? static_cast<unsigned>(SQLITE_DESERIALIZE_FREEONCLOSE) : 0U);
  const int status = sqlite3_deserialize(
      database_.get(), "main", reinterpret_cast<unsigned char*>(image.data()), size, size, flags);
  if (status == SQLITE_OK) return {};
  return fail(ErrorCode::kMachine, name_, "cannot be opened by SQLite: " + last_error());
}

Result<SqlDatabase> SqlDatabase::create(const std::string& path) {
  constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  auto handle = open(path, path, kFlags);
  if (!handle) return tl::make_unexpected(handle.error());
  return SqlDatabase(*handle, path);
}

Status SqlDatabase::prepare_for_reading(std::uint64_t file_bytes, std::uint64_t value_bytes_max) {
  *budget_ = (kBudgetBase + kBudgetPerByte * file_bytes) / kBudgetTick;
  sqlite3_progress_handler(database_.get(), kBudgetTick, spend, budget_.get());
  const auto limit = std::min<std::uint64_t>(value_bytes_max, std::numeric_limits<int>::max());
  sqlite3_limit(database_.get(), SQLITE_LIMIT_LENGTH, static_cast<int>(limit));
  // writable_schema: needed to open a file that is shorter than its header claims. It stays
  // read-only. trusted_schema: no function in an untrusted schema is run.
  return run("PRAGMA writable_schema=ON; PRAGMA trusted_schema=OFF; PRAGMA cell_size_check=ON;");
}

std::optional<SqlStatement> SqlDatabase::prepare(const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  const int status = sqlite3_prepare_v2(database_.get(), sql.c_str(), static_cast<int>(sql.size()),
                                        &statement, nullptr);
  if (status != SQLITE_OK) return std::nullopt;
  return SqlStatement(statement);
}

Status SqlDatabase::run(const std::string& sql) {
  if (sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK) return {};
  return fail(ErrorCode::kMachine, name_, last_error());
}

std::string SqlDatabase::last_error() const { return sqlite3_errmsg(database_.get()); }

}  // namespace rali::io
