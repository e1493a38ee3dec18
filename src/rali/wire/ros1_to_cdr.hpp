#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/wire/byte_reader.hpp"
#include "rali/wire/byte_writer.hpp"

namespace rali::wire {

/// Converts messages of one ROS 1 type to CDR, field by field by the type's definition, so that
/// nothing is lost for any type. The ROS 2 definition is assumed to have the same fields in the
/// same order. The sequence number of std_msgs/Header is dropped, as ROS 2 has none.
class Ros1ToCdr {
 public:
  /// @param type_name "sensor_msgs/Imu"
  /// @param definition its text, followed by those of the messages in it ("MSG: std_msgs/Header"
  /// after a line of `=`), as bags store it
  /// Errors: kInput (a type that is not defined, contains itself, or is no text of a definition).
  [[nodiscard]] static Result<Ros1ToCdr> make(std::string_view type_name,
                                              std::string_view definition);

  /// Errors: kInput (the message is shorter than its fields).
  [[nodiscard]] Result<Bytes> convert(std::span<const std::byte> message) const;

 private:
  enum class Kind : std::uint8_t { kPlain, kTime, kString, kMessage };
  enum class Count : std::uint8_t { kOne, kFixed, kAny };

  struct Field {
    Kind kind = Kind::kPlain;
    Count count = Count::kOne;
    bool dropped = false;
    std::size_t bytes = 1;    ///< of one element; the minimum in ROS 1
    std::size_t n = 1;        ///< of kFixed
    std::size_t message = 0;  ///< index in messages_
  };

  struct Message {
    std::vector<Field> fields;
    std::size_t bytes_min = 0;
  };

  class Parser;

  void copy(const Field& field, ByteReader& in, ByteWriter& out) const;
  void copy_elements(const Field& field, std::size_t n, ByteReader& in, ByteWriter& out) const;
  void copy(const Message& message, ByteReader& in, ByteWriter& out) const;

  std::string type_;
  std::vector<Message> messages_;
  std::size_t root_ = 0;
};

}  // namespace rali::wire
