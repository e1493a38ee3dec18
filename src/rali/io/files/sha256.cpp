#include "rali/io/files/sha256.hpp"

#include <vector>

#include <openssl/evp.h>

#include "rali/base/assert.hpp"
#include "rali/io/files/input_file.hpp"

namespace rali::io {
namespace {

std::string hex(const Sha256::Digest& digest) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * digest.size());
  for (const std::uint8_t byte : digest) {
    text.push_back(kDigits[byte >> 4]);
    text.push_back(kDigits[byte & 15]);
  }
  return text;
}

}  // namespace

void Sha256::Free::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  RALI_ASSERT(context_ != nullptr);
  RALI_ASSERT(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
}

void Sha256::update(std::span<const std::byte> bytes) {
  RALI_ASSERT(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1);
}

Sha256::Digest Sha256::finish() {
  Digest digest{};
  RALI_ASSERT(EVP_DigestFinal_ex(context_.get(), digest.data(), nullptr) == 1);
  return digest;
}

std::string sha256_hex(std::span<const std::byte> bytes) {
  Sha256 hash;
  hash.update(bytes);
  return hex(hash.finish());
}

Result<std::string> sha256_file(const std::string& path) {
  auto file = InputFile::open(path);
  if (!file) return tl::make_unexpected(file.error());
  Sha256 hash;
  std::vector<std::byte> buffer(std::size_t{1} << 18);
  while (true) {
    const auto n = file->read(buffer);
    if (!n) return tl::make_unexpected(n.error());
    if (*n == 0) return hex(hash.finish());
    hash.update(std::span(buffer).first(*n));
  }
}

}  // namespace rali::io
