#pragma once

#include <map>
#include <memory>
#include <string>

#include "rali/io/containers/reader_state.hpp"
#include "rali/io/containers/sqlite_db.hpp"
#include "rali/io/message_source.hpp"

namespace rali::io {

/// What metadata.yaml may add to a .db3.
struct Db3Hints {
  /// Messages may be zstd frames whatever their encoding. (In CDR they are recognised by their
  /// first bytes without this flag.)
  bool zstd_messages = false;
};

/// Reads the SQLite storage of rosbag2 in the order of time. From a malformed file it returns the
/// readable rows. `name` is for messages. Errors: no tables of rosbag2, unreadable.
[[nodiscard]] Result<std::unique_ptr<MessageSource>> open_db3(SqlDatabase database,
                                                              std::string name,
                                                              std::uint64_t file_bytes,
                                                              const Db3Hints& hints = {},
                                                              const ReadLimits& limits = {});

}  // namespace rali::io
