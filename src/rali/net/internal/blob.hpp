#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include <dds/dds.h>

struct ddsi_sertype;

/// Samples of any type as bytes. Cyclone requires a description of each type's fields. Like
/// rmw_cyclonedds, this gives it a custom type whose samples are opaque bytes. The bytes are CDR
/// with the four bytes of the encapsulation header.
namespace rali::net {

struct BlobCounts {
  std::atomic<std::uint64_t> malformed{0};
};

/// A type for dds_create_topic_sertype, which takes ownership. Samples larger than `bytes_max` or
/// without a known encapsulation header are counted and dropped before they are stored.
[[nodiscard]] ddsi_sertype* new_blob_type(const std::string& type_name, std::size_t bytes_max,
                                          std::shared_ptr<BlobCounts> counts);

/// Topic of opaque samples. Negative: an error of Cyclone.
[[nodiscard]] dds_entity_t create_blob_topic(dds_entity_t participant, const std::string& topic,
                                             const std::string& type, std::size_t bytes_max,
                                             std::shared_ptr<BlobCounts> counts,
                                             const ddsi_sertype** used);

/// Writes one sample. @param type the `used` of the writer's topic  @return an error of Cyclone or
/// 0
[[nodiscard]] dds_return_t write_blob(dds_entity_t writer, const ddsi_sertype* type,
                                      std::span<const std::uint8_t> cdr);

/// Takes all samples of a reader and passes each valid one to `give`; its span is valid during the
/// call.
void take_blobs(dds_entity_t reader,
                const std::function<void(std::span<const std::uint8_t>)>& give);

}  // namespace rali::net
