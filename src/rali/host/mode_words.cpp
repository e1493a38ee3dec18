#include "rali/host/mode_words.hpp"

namespace rali::host {

using fleet::Mode;

std::string_view mode_word(Mode mode) {
  switch (mode) {
    case Mode::kStarting:
      return "start";
    case Mode::kUnplaced:
    case Mode::kHolding:
    case Mode::kCandidate:
    case Mode::kOrphan:
      return "wait";
    case Mode::kExploring:
      return "explore";
    case Mode::kAnchor:
    case Mode::kSealed:
      return "stand";
    case Mode::kFinished:
    case Mode::kDone:
      return "finished";
  }
  return "wait";
}

std::string_view role_word(Mode mode) {
  switch (mode) {
    case Mode::kAnchor:
      return "anchor";
    case Mode::kSealed:
      return "sealed";
    case Mode::kCandidate:
      return "candidate";
    case Mode::kOrphan:
      return "orphan";
    default:
      return "tag";
  }
}

std::string_view waiting_words(Mode mode, bool has_goal) {
  switch (mode) {
    case Mode::kStarting:
      return "waits for the direction of gravity: it has to stand still for some seconds";
    case Mode::kUnplaced:
      return "waits until the anchor has found where its frame lies in the map";
    case Mode::kExploring:
      return has_goal ? "waits for nothing" : "waits for a goal of the anchor";
    case Mode::kFinished:
      return "waits for the end of the round";
    case Mode::kAnchor:
      return "stands as the anchor until the others have finished the round";
    case Mode::kSealed:
      return "waits until the next anchor has all facts of the round";
    case Mode::kCandidate:
      return "waits for the votes of a majority";
    case Mode::kOrphan:
      return "waits for messages of a majority of the fleet";
    case Mode::kHolding:
      return "stands until the new anchor has its ranges to it";
    case Mode::kDone:
      return "waits for nothing: the mission is over";
  }
  return "waits for nothing";
}

}  // namespace rali::host
