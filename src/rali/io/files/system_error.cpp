#include "rali/io/files/system_error.hpp"

#include <cerrno>

#include <fmt/core.h>

namespace rali::io {

std::string system_error_text(int error_number) {
  switch (error_number) {
    case ENOSPC:
      return "the disk is full";
    case EDQUOT:
      return "the disk quota is used up";
    case EACCES:
    case EPERM:
      return "no permission";
    case EROFS:
      return "the disk is mounted read-only";
    case ENOENT:
      return "no such file or folder";
    case ENOTDIR:
      return "a part of the path is no folder";
    case EISDIR:
      return "it is a folder";
    case EIO:
      return "the disk reports a fault";
    case EMFILE:
    case ENFILE:
      return "too many open files";
    case ENAMETOOLONG:
      return "the name is too long";
    case EFBIG:
      return "the file is larger than allowed";
    case ELOOP:
      return "its links lead in a circle";
    default:
      return fmt::format("system error {}", error_number);
  }
}

ErrorCode input_error_code(int error_number) {
  switch (error_number) {
    case EIO:
    case EMFILE:
    case ENFILE:
    case ENOMEM:
      return ErrorCode::kMachine;
    default:
      return ErrorCode::kInput;
  }
}

}  // namespace rali::io
