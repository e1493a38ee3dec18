#include "rali/io/containers/codec.hpp"

#include <algorithm>
#include <limits>

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include "rali/io/containers/cursor.hpp"

namespace rali::io {
namespace {

constexpr std::size_t kFirstOutput = 64 * 1024;
constexpr std::uint32_t kZstdMagic = 0xFD2FB528U;
/// Level 3 takes twice the time and saves 6 % of scans, whose floats are mostly noise.
constexpr int kZstdLevel = 1;
/// Memory is reserved for a claimed size up to this, or up to this multiple of the input.
constexpr std::uint64_t kAssumed = 16U << 20;
constexpr std::uint64_t kAssumedRatio = 32;

/// The output vector while it grows. It offers one byte beyond the limit, to distinguish a stream
/// that is too long from one that fits exactly.
class Growing {
 public:
  Growing(std::vector<std::byte>& out, std::uint64_t limit) : out_(out), limit_(limit) {
    // Not cleared: growing a cleared vector would zero it again for each chunk.
    if (out_.size() > limit_) out_.resize(static_cast<std::size_t>(limit_));
  }

  /// Space for at least one more byte; empty when the limit is exceeded.
  std::span<std::byte> room() {
    if (used_ > limit_) return {};
    if (used_ == out_.size()) {
      const std::uint64_t next = std::max<std::uint64_t>(kFirstOutput, 2 * used_);
      out_.resize(static_cast<std::size_t>(std::min(next, limit_ + 1)));
    }
    return std::span(out_).subspan(used_);
  }

  void took(std::size_t n) { used_ += n; }

  [[nodiscard]] bool full() const { return used_ == limit_; }

  DecodeEnd finish(DecodeEnd end) {
    if (used_ > limit_) end = DecodeEnd::kTooLong;
    out_.resize(end == DecodeEnd::kWhole || end == DecodeEnd::kCut ? used_ : 0);
    return end;
  }

 private:
  std::vector<std::byte>& out_;
  std::uint64_t limit_;
  std::size_t used_ = 0;
};

struct FreeZstd {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

struct FreeLz4 {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

/// Decompresses one frame of exactly the expected size directly into the output, without the window
/// that a stream is copied through. False: not such a frame, or damaged; the caller then decides.
bool run_zstd_at_once(ZSTD_DCtx* context, std::span<const std::byte> in, std::uint64_t limit,
                      std::vector<std::byte>& out) {
  if (limit > std::max(kAssumed, kAssumedRatio * in.size())) return false;
  if (ZSTD_getFrameContentSize(in.data(), in.size()) != limit) return false;
  if (ZSTD_findFrameCompressedSize(in.data(), in.size()) != in.size()) return false;
  out.resize(static_cast<std::size_t>(limit));
  return ZSTD_decompressDCtx(context, out.data(), out.size(), in.data(), in.size()) == limit;
}

DecodeEnd run_zstd(ZSTD_DCtx* context, std::span<const std::byte> in, Growing& out) {
  ZSTD_DCtx_reset(context, ZSTD_reset_session_only);
  ZSTD_inBuffer input{in.data(), in.size(), 0};
  std::size_t wanted = 1;  // 0: at the end of a frame
  while (true) {
    const auto room = out.room();
    if (room.empty()) return DecodeEnd::kTooLong;
    ZSTD_outBuffer output{room.data(), room.size(), 0};
    const std::size_t before = input.pos;
    wanted = ZSTD_decompressStream(context, &output, &input);
    if (ZSTD_isError(wanted) != 0) return DecodeEnd::kDamaged;
    out.took(output.pos);
    if (wanted == 0 && (input.pos == input.size || out.full())) return DecodeEnd::kWhole;
    if (input.pos == before && output.pos == 0) return DecodeEnd::kCut;
  }
}

DecodeEnd run_lz4(LZ4F_dctx* context, std::span<const std::byte> in, Growing& out) {
  LZ4F_resetDecompressionContext(context);
  while (true) {
    const auto room = out.room();
    if (room.empty()) return DecodeEnd::kTooLong;
    std::size_t taken = in.size();
    std::size_t given = room.size();
    const std::size_t wanted =
        LZ4F_decompress(context, room.data(), &given, in.data(), &taken, nullptr);
    if (LZ4F_isError(wanted) != 0) return DecodeEnd::kDamaged;
    in = in.subspan(taken);
    out.took(given);
    if (wanted == 0 && (in.empty() || out.full())) return DecodeEnd::kWhole;
    if (taken == 0 && given == 0) return DecodeEnd::kCut;
  }
}

/// One bz2 stream; the caller has initialised it.
DecodeEnd run_bz2_stream(bz_stream& stream, Growing& out) {
  while (true) {
    const auto room = out.room();
    if (room.empty()) return DecodeEnd::kTooLong;
    const auto offered = static_cast<unsigned>(
        std::min<std::size_t>(room.size(), std::numeric_limits<unsigned>::max()));
    const unsigned in_before = stream.avail_in;
    stream.next_out = reinterpret_cast<char*>(room.data());
    stream.avail_out = offered;
    const int status = BZ2_bzDecompress(&stream);
    out.took(offered - stream.avail_out);
    if (status == BZ_STREAM_END) return DecodeEnd::kWhole;
    if (status != BZ_OK) return DecodeEnd::kDamaged;
    if (stream.avail_in == in_before && stream.avail_out == offered) return DecodeEnd::kCut;
  }
}

DecodeEnd run_bz2(std::span<const std::byte> in, Growing& out) {
  if (in.size() > std::numeric_limits<unsigned>::max()) return DecodeEnd::kTooLong;
  do {
    bz_stream stream{};
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return DecodeEnd::kDamaged;
    // The library's interface is not const, but it only reads.
    stream.next_in = const_cast<char*>(text_of(in).data());
    stream.avail_in = static_cast<unsigned>(in.size());
    const DecodeEnd end = run_bz2_stream(stream, out);
    in = in.last(stream.avail_in);
    BZ2_bzDecompressEnd(&stream);
    if (end != DecodeEnd::kWhole) return end;
  } while (!in.empty() && !out.full());
  return DecodeEnd::kWhole;
}

Result<std::vector<std::byte>> compress_lz4(std::span<const std::byte> in) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = LZ4F_max1MB;
  preferences.frameInfo.blockMode = LZ4F_blockIndependent;
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  std::vector<std::byte> out(LZ4F_compressFrameBound(in.size(), &preferences));
  const std::size_t n =
      LZ4F_compressFrame(out.data(), out.size(), in.data(), in.size(), &preferences);
  if (LZ4F_isError(n) != 0) return fail(ErrorCode::kMachine, "lz4", LZ4F_getErrorName(n));
  out.resize(n);
  return out;
}

Result<std::vector<std::byte>> compress_zstd(std::span<const std::byte> in) {
  std::vector<std::byte> out(ZSTD_compressBound(in.size()));
  const std::size_t n = ZSTD_compress(out.data(), out.size(), in.data(), in.size(), kZstdLevel);
  if (ZSTD_isError(n) != 0) return fail(ErrorCode::kMachine, "zstd", ZSTD_getErrorName(n));
  out.resize(n);
  return out;
}

Result<std::vector<std::byte>> compress_bz2(std::span<const std::byte> in) {
  // 1 % and 600 bytes: the bound in the library's manual.
  std::vector<std::byte> out(in.size() + in.size() / 100 + 601);
  if (out.size() > std::numeric_limits<unsigned>::max()) {
    return fail(ErrorCode::kInput, "bz2", "a chunk must be smaller than 4 GB");
  }
  auto n = static_cast<unsigned>(out.size());
  // The library rejects a null pointer even for zero bytes.
  std::byte nothing{};
  const std::byte* data = in.empty() ? &nothing : in.data();
  const int status = BZ2_bzBuffToBuffCompress(
      reinterpret_cast<char*>(out.data()), &n,
      const_cast<char*>(reinterpret_cast<const char*>(data)), static_cast<unsigned>(in.size()),
      /*blockSize100k=*/9, /*verbosity=*/0, /*workFactor=*/0);
  if (status != BZ_OK) {
    return fail(ErrorCode::kMachine, "bz2", "compression failed: " + std::to_string(status));
  }
  out.resize(n);
  return out;
}

}  // namespace

std::optional<Compression> compression_named(std::string_view name) {
  if (name.empty() || name == "none") return Compression::kNone;
  if (name == "lz4") return Compression::kLz4;
  if (name == "bz2") return Compression::kBz2;
  if (name == "zstd") return Compression::kZstd;
  return std::nullopt;
}

std::string_view name_of(Compression compression) {
  switch (compression) {
    case Compression::kNone:
      return "none";
    case Compression::kLz4:
      return "lz4";
    case Compression::kBz2:
      return "bz2";
    case Compression::kZstd:
      return "zstd";
  }
  return "none";
}

struct Decompressor::Contexts {
  std::unique_ptr<ZSTD_DCtx, FreeZstd> zstd;
  std::unique_ptr<LZ4F_dctx, FreeLz4> lz4;
};

Decompressor::Decompressor() : contexts_(std::make_unique<Contexts>()) {}

Decompressor::~Decompressor() = default;

DecodeEnd Decompressor::decompress(Compression compression, std::span<const std::byte> in,
                                   std::uint64_t limit, std::vector<std::byte>& out) {
  if (compression == Compression::kNone) {
    if (in.size() > limit) return DecodeEnd::kTooLong;
    out.assign(in.begin(), in.end());
    return DecodeEnd::kWhole;
  }
  Growing growing(out, limit);
  if (in.empty()) return growing.finish(limit == 0 ? DecodeEnd::kWhole : DecodeEnd::kCut);
  if (compression == Compression::kBz2) return growing.finish(run_bz2(in, growing));
  if (compression == Compression::kZstd) {
    if (!contexts_->zstd) contexts_->zstd.reset(ZSTD_createDCtx());
    if (!contexts_->zstd) return growing.finish(DecodeEnd::kDamaged);
    if (run_zstd_at_once(contexts_->zstd.get(), in, limit, out)) return DecodeEnd::kWhole;
    return growing.finish(run_zstd(contexts_->zstd.get(), in, growing));
  }
  if (!contexts_->lz4) {
    LZ4F_dctx* context = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) {
      return growing.finish(DecodeEnd::kDamaged);
    }
    contexts_->lz4.reset(context);
  }
  return growing.finish(run_lz4(contexts_->lz4.get(), in, growing));
}

Result<std::vector<std::byte>> compress(Compression compression, std::span<const std::byte> in) {
  switch (compression) {
    case Compression::kLz4:
      return compress_lz4(in);
    case Compression::kBz2:
      return compress_bz2(in);
    case Compression::kZstd:
      return compress_zstd(in);
    case Compression::kNone:
      break;
  }
  return std::vector<std::byte>(in.begin(), in.end());
}

bool is_zstd(std::span<const std::byte> bytes) {
  Cursor cursor(bytes);
  return cursor.u32() == kZstdMagic && cursor.ok();
}

}  // namespace rali::io
