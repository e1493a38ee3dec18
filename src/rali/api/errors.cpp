#include "rali/api/errors.hpp"

#include "rali/version.hpp"

namespace rali {
namespace {

std::string sentence(const std::string& where, const std::string& problem,
                     const std::string& remedy) {
  return Error{ErrorCode::kInput, problem, where, remedy}.message();
}

}  // namespace

Exception::Exception(std::string where, std::string problem, std::string remedy)
    : std::runtime_error(sentence(where, problem, remedy)),
      where_(std::move(where)),
      problem_(std::move(problem)),
      remedy_(std::move(remedy)) {}

Exception::~Exception() = default;
InputError::~InputError() = default;
SettingsError::~SettingsError() = default;
NoAnswerError::~NoAnswerError() = default;
MachineError::~MachineError() = default;

std::string version() { return RALI_VERSION_TEXT; }

namespace api {

void throw_error(const Error& error) {
  switch (error.code) {
    case ErrorCode::kUsage:
      throw SettingsError(error.where, error.what, error.remedy);
    case ErrorCode::kInput:
      throw InputError(error.where, error.what, error.remedy);
    case ErrorCode::kNoAnswer:
      throw NoAnswerError(error.where, error.what, error.remedy);
    case ErrorCode::kMachine:
      throw MachineError(error.where, error.what, error.remedy);
    case ErrorCode::kInterrupted:
      break;
  }
  throw Exception(error.where, error.what, error.remedy);
}

}  // namespace api
}  // namespace rali
