#include "rali/net/internal/blob.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <utility>
#include <vector>

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

#ifdef __SANITIZE_THREAD__
/// Debian's Cyclone is not instrumented, so the sanitizer does not see its locks and reference
/// counts; our own code is fully checked.
extern "C" const char* __tsan_default_suppressions() {
  return "race:libddsc.so\nrace:free_blob\nmutex:libddsc.so\n";
}
#endif

namespace rali::net {
namespace {

constexpr std::size_t kHeaderBytes = 4;
constexpr std::size_t kTakeMax = 32;

struct BlobType : ddsi_sertype {
  std::size_t bytes_max = 0;
  std::shared_ptr<BlobCounts> counts;
};

/// `bytes` is padded to a multiple of four, as Cyclone may require; `size` is without padding.
struct Blob : ddsi_serdata {
  std::vector<std::uint8_t> bytes;
  std::uint32_t size = 0;
};

const Blob& as_blob(const ddsi_serdata* data) { return *static_cast<const Blob*>(data); }

Blob* new_blob(const ddsi_sertype* type, ddsi_serdata_kind kind, std::size_t size) {
  auto blob = std::make_unique<Blob>();
  ddsi_serdata_init(blob.get(), type, kind);
  blob->bytes.resize((size + 3) / 4 * 4);
  blob->size = static_cast<std::uint32_t>(size);
  return blob.release();
}

/// Plain CDR of either byte order (XCDR1), or delimited and plain XCDR2: second byte 0, 1, 6 to 11.
bool is_known_header(const std::uint8_t* bytes) {
  return bytes[0] == 0 && (bytes[1] <= 1 || (bytes[1] >= 6 && bytes[1] <= 11));
}

ddsi_serdata* refuse(const ddsi_sertype* type) {
  static_cast<const BlobType*>(type)->counts->malformed.fetch_add(1, std::memory_order_relaxed);
  return nullptr;
}

bool fits(const ddsi_sertype* type, std::size_t size) {
  return size >= kHeaderBytes && size <= static_cast<const BlobType*>(type)->bytes_max;
}

/// Checks a reassembled sample and counts it if it is invalid.
ddsi_serdata* accept(const ddsi_sertype* type, Blob* blob, bool whole) {
  if (whole && (blob->kind != SDK_DATA || is_known_header(blob->bytes.data()))) return blob;
  delete blob;
  return refuse(type);
}

ddsi_serdata* join(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment,
                   std::size_t size) {
  Blob* blob = new_blob(type, kind, size);
  std::size_t at = 0;
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    if (fragment->min > at || fragment->maxp1 > size) return accept(type, blob, false);
    if (fragment->maxp1 <= at) continue;  // fragments may overlap
    const unsigned char* payload =
        NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    std::memcpy(blob->bytes.data() + at, payload + (at - fragment->min), fragment->maxp1 - at);
    at = fragment->maxp1;
  }
  return accept(type, blob, at == size);
}

ddsi_serdata* from_network(const ddsi_sertype* type, ddsi_serdata_kind kind,
                           const nn_rdata* fragment, std::size_t size) noexcept {
  if (!fits(type, size)) return refuse(type);
  try {
    return join(type, kind, fragment, size);
  } catch (const std::bad_alloc&) {
    return refuse(type);
  }
}

ddsi_serdata* from_pieces(const ddsi_sertype* type, ddsi_serdata_kind kind,
                          ddsrt_msg_iovlen_t pieces, const ddsrt_iovec_t* piece,
                          std::size_t size) noexcept {
  if (!fits(type, size)) return refuse(type);
  try {
    Blob* blob = new_blob(type, kind, size);
    std::size_t at = 0;
    for (ddsrt_msg_iovlen_t i = 0; i < pieces && at < size; ++i) {
      const std::size_t n = std::min<std::size_t>(piece[i].iov_len, size - at);
      std::memcpy(blob->bytes.data() + at, piece[i].iov_base, n);
      at += n;
    }
    return accept(type, blob, at == size);
  } catch (const std::bad_alloc&) {
    return refuse(type);
  }
}

ddsi_serdata* empty_blob(const ddsi_sertype* type) noexcept {
  try {
    return new_blob(type, SDK_KEY, 0);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

ddsi_serdata* from_keyhash(const ddsi_sertype* type, const ddsi_keyhash*) {
  return empty_blob(type);
}

ddsi_serdata* from_sample(const ddsi_sertype* type, ddsi_serdata_kind kind, const void*) {
  return kind == SDK_KEY ? empty_blob(type) : nullptr;  // data come as bytes only
}

ddsi_serdata* to_untyped(const ddsi_serdata* data) {
  ddsi_serdata* untyped = empty_blob(data->type);
  if (untyped != nullptr) untyped->type = nullptr;
  return untyped;
}

bool same_key(const ddsi_serdata*, const ddsi_serdata*) { return true; }  // no type has a key

std::uint32_t size_of(const ddsi_serdata* data) { return as_blob(data).size; }

void copy_out(const ddsi_serdata* data, std::size_t at, std::size_t n, void* to) {
  const std::vector<std::uint8_t>& bytes = as_blob(data).bytes;
  if (at > bytes.size()) return;
  std::memcpy(to, bytes.data() + at, std::min(n, bytes.size() - at));
}

ddsi_serdata* lend(const ddsi_serdata* data, std::size_t at, std::size_t n, ddsrt_iovec_t* ref) {
  ref->iov_base = const_cast<std::uint8_t*>(as_blob(data).bytes.data()) + at;
  ref->iov_len = n;
  return ddsi_serdata_ref(data);
}

void give_back(ddsi_serdata* data, const ddsrt_iovec_t*) { ddsi_serdata_unref(data); }

bool to_sample(const ddsi_serdata*, void*, void**, void*) { return false; }

bool untyped_to_sample(const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) {
  return false;
}

void free_blob(ddsi_serdata* data) { delete static_cast<Blob*>(data); }

std::size_t print_blob(const ddsi_sertype*, const ddsi_serdata*, char* text, std::size_t size) {
  constexpr std::array<char, 7> kText{"(blob)"};
  const std::size_t n = std::min(size, kText.size());
  std::copy_n(kText.data(), n, text);
  if (n > 0) text[n - 1] = '\0';
  return kText.size() - 1;
}

void no_keyhash(const ddsi_serdata*, ddsi_keyhash* hash, bool) { *hash = {}; }

const ddsi_serdata_ops& blob_ops() {
  static const ddsi_serdata_ops kOps = [] {
    ddsi_serdata_ops ops{};
    ops.eqkey = same_key;
    ops.get_size = size_of;
    ops.from_ser = from_network;
    ops.from_ser_iov = from_pieces;
    ops.from_keyhash = from_keyhash;
    ops.from_sample = from_sample;
    ops.to_ser = copy_out;
    ops.to_ser_ref = lend;
    ops.to_ser_unref = give_back;
    ops.to_sample = to_sample;
    ops.to_untyped = to_untyped;
    ops.untyped_to_sample = untyped_to_sample;
    ops.free = free_blob;
    ops.print = print_blob;
    ops.get_keyhash = no_keyhash;
    return ops;
  }();
  return kOps;
}

void free_type(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete static_cast<BlobType*>(type);
}

void zero_samples(const ddsi_sertype*, void*, std::size_t) {}

void realloc_samples(void**, const ddsi_sertype*, void*, std::size_t, std::size_t) {}

void free_samples(const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {}

bool same_type(const ddsi_sertype* a, const ddsi_sertype* b) {
  const auto* x = static_cast<const BlobType*>(a);
  const auto* y = static_cast<const BlobType*>(b);
  return x->bytes_max == y->bytes_max && x->counts == y->counts;
}

std::uint32_t hash_type(const ddsi_sertype*) { return 0; }

const ddsi_sertype_ops& type_ops() {
  static const ddsi_sertype_ops kOps = [] {
    ddsi_sertype_ops ops{};
    ops.version = ddsi_sertype_v0;
    ops.free = free_type;
    ops.zero_samples = zero_samples;
    ops.realloc_samples = realloc_samples;
    ops.free_samples = free_samples;
    ops.equal = same_type;
    ops.hash = hash_type;
    return ops;
  }();
  return kOps;
}

}  // namespace

ddsi_sertype* new_blob_type(const std::string& type_name, std::size_t bytes_max,
                            std::shared_ptr<BlobCounts> counts) {
  auto type = std::make_unique<BlobType>();
  ddsi_sertype_init(type.get(), type_name.c_str(), &type_ops(), &blob_ops(), true);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  type->bytes_max = bytes_max;
  type->counts = std::move(counts);
  return type.release();
}

dds_entity_t create_blob_topic(dds_entity_t participant, const std::string& topic,
                               const std::string& type, std::size_t bytes_max,
                               std::shared_ptr<BlobCounts> counts, const ddsi_sertype** used) {
  ddsi_sertype* blob_type = new_blob_type(type, bytes_max, std::move(counts));
  const dds_entity_t entity =
      dds_create_topic_sertype(participant, topic.c_str(), &blob_type, nullptr, nullptr, nullptr);
  if (entity < 0) {
    ddsi_sertype_unref(blob_type);
  } else {
    *used = blob_type;
  }
  return entity;
}

dds_return_t write_blob(dds_entity_t writer, const ddsi_sertype* type,
                        std::span<const std::uint8_t> cdr) {
  if (!fits(type, cdr.size())) return DDS_RETCODE_BAD_PARAMETER;
  try {
    Blob* blob = new_blob(type, SDK_DATA, cdr.size());
    std::copy(cdr.begin(), cdr.end(), blob->bytes.begin());
    return dds_writecdr(writer, blob);
  } catch (const std::bad_alloc&) {
    return DDS_RETCODE_OUT_OF_RESOURCES;
  }
}

void take_blobs(dds_entity_t reader,
                const std::function<void(std::span<const std::uint8_t>)>& give) {
  std::array<ddsi_serdata*, kTakeMax> samples{};
  std::array<dds_sample_info_t, kTakeMax> infos{};
  for (;;) {
    const dds_return_t n =
        dds_takecdr(reader, samples.data(), kTakeMax, infos.data(), DDS_ANY_STATE);
    for (std::size_t i = 0; n > 0 && i < static_cast<std::size_t>(n); ++i) {
      if (infos[i].valid_data) {
        const Blob& blob = as_blob(samples[i]);
        give(std::span(blob.bytes).first(blob.size));
      }
      ddsi_serdata_unref(samples[i]);
    }
    if (n < static_cast<dds_return_t>(kTakeMax)) return;
  }
}

}  // namespace rali::net
