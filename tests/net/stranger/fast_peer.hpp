#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace rali::net {

/// A participant made with Fast DDS, the other DDS implementation used with ROS 2. Like a driver or
/// viewer of ROS 2, it shares only names of topics and types, and CDR.
class FastPeer {
 public:
  FastPeer(int domain, const std::string& topic, const std::string& type, bool is_reliable);
  ~FastPeer();
  FastPeer(const FastPeer&) = delete;
  FastPeer& operator=(const FastPeer&) = delete;

  [[nodiscard]] bool is_open() const;
  [[nodiscard]] int matched_readers() const;
  [[nodiscard]] int matched_writers() const;

  /// @param cdr with the encapsulation header
  [[nodiscard]] bool write(const std::vector<std::uint8_t>& cdr);

  /// The next sample; empty: none.
  [[nodiscard]] std::vector<std::uint8_t> take();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace rali::net
