#include "rali/net/fleet_key.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include "rali/net/envelope.hpp"

namespace rali::net {
namespace {

constexpr const char* kMakeOne =
    "Make one with `openssl rand -hex 32 > fleet.key; chmod 600 fleet.key`.";
constexpr std::size_t kFileBytesMax = 4096;

int digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

std::string_view without_blanks_around(std::string_view text) {
  constexpr const char* kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}

  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }

  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

tl::unexpected<Error> system_fault(const std::string& path, const char* what, std::string remedy) {
  return fail(ErrorCode::kMachine, path, std::string(what) + ": " + std::strerror(errno),
              std::move(remedy));
}

}  // namespace

Result<FleetKey> parse_fleet_key(std::string_view text, const std::string& where) {
  text = without_blanks_around(text);
  FleetKey key;
  bool good = text.size() == 2 * key.bytes.size();
  for (std::size_t i = 0; good && i < key.bytes.size(); ++i) {
    const int high = digit(text[2 * i]), low = digit(text[2 * i + 1]);
    good = high >= 0 && low >= 0;
    key.bytes[i] = static_cast<std::uint8_t>(16 * high + low);
  }
  if (good) return key;
  return fail(ErrorCode::kInput, where, "is not a key of 64 hexadecimal digits", kMakeOne);
}

Result<FleetKey> load_fleet_key(const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) return system_fault(path, "cannot be opened", kMakeOne);

  struct stat status {};

  if (::fstat(file.number(), &status) != 0) return system_fault(path, "cannot be examined", "");
  if (!S_ISREG(status.st_mode)) {
    return fail(ErrorCode::kInput, path, "is no file with a key", kMakeOne);
  }
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    return fail(ErrorCode::kInput, path, "may be read or written by others than its owner",
                "Run `chmod 600 " + path + "`; if others may have read it, make a new key.");
  }
  std::string text(kFileBytesMax, '\0');
  const ssize_t n = ::read(file.number(), text.data(), text.size());
  if (n < 0) return system_fault(path, "cannot be read", "");
  text.resize(static_cast<std::size_t>(n));
  return parse_fleet_key(text, path);
}

Result<FleetKey> create_fleet_key(const std::string& path) {
  if (!sodium_is_ready()) return fail(ErrorCode::kMachine, "libsodium", "has no random numbers");
  const Descriptor file(
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (file.number() < 0) {
    return system_fault(path, "cannot be made", "A key that is there already is never replaced.");
  }
  FleetKey key;
  randombytes_buf(key.bytes.data(), key.bytes.size());
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : key.bytes) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  text += '\n';
  const ssize_t n = ::write(file.number(), text.data(), text.size());
  if (n != static_cast<ssize_t>(text.size()) || ::fsync(file.number()) != 0) {
    return system_fault(path, "cannot be written", "");
  }
  return key;
}

}  // namespace rali::net
