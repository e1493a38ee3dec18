#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "rali/base/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace rali::io {

/// A prepared SQL statement. Texts and blobs stay valid until the next step() or reset().
class SqlStatement {
 public:
  enum class Step { kRow, kDone, kFailed };

  explicit SqlStatement(sqlite3_stmt* statement);

  [[nodiscard]] Step step();
  void reset();
  void bind(int parameter, std::int64_t value);  ///< parameters count from 1
  void bind(int parameter, const std::string& value);
  void bind(int parameter, std::span<const std::byte> value);

  [[nodiscard]] std::int64_t integer(int column) const;  ///< columns count from 0
  [[nodiscard]] std::string text(int column) const;
  /// None if the value could not be read (damaged page, larger than the limit).
  [[nodiscard]] std::optional<std::span<const std::byte>> blob(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };

  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

/// An SQLite database. Reading never writes next to the file. Reading a damaged file always ends:
/// all steps together have a budget that grows with the size of the file.
class SqlDatabase {
 public:
  /// Reads even truncated files. `value_bytes_max` limits one text or blob.
  [[nodiscard]] static Result<SqlDatabase> open_file(const std::string& path,
                                                     std::uint64_t value_bytes_max);
  /// Reads from memory, which is copied.
  [[nodiscard]] static Result<SqlDatabase> open_bytes(std::span<const std::byte> bytes,
                                                      std::uint64_t value_bytes_max);
  [[nodiscard]] static Result<SqlDatabase> create(const std::string& path);

  /// None if the SQL does not match the tables, or these cannot be read.
  [[nodiscard]] std::optional<SqlStatement> prepare(const std::string& sql);
  [[nodiscard]] Status run(const std::string& sql);
  [[nodiscard]] std::string last_error() const;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };

  SqlDatabase(sqlite3* database, std::string name);

  static Result<SqlDatabase> open_cut_file(const std::string& path, std::uint64_t whole_pages_bytes,
                                           std::uint64_t value_bytes_max);
  Status attach(std::span<std::byte> image, bool owned);

  Status prepare_for_reading(std::uint64_t file_bytes, std::uint64_t value_bytes_max);

  std::unique_ptr<std::uint64_t> budget_;  ///< the database keeps a pointer to it
  std::shared_ptr<void> mapping_;          ///< of a cut file, for as long as it is read
  std::unique_ptr<sqlite3, Close> database_;
  std::string name_;
};

}  // namespace rali::io
