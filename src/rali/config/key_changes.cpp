#include "rali/config/key_changes.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace rali::config {
namespace {

/// The current name of a key or group.
std::string current_key(std::span<const RenamedKey> renamed, std::string_view key) {
  std::string_view group, renamed_group;
  for (const RenamedKey& entry : renamed) {
    if (entry.old_key == key) return std::string(entry.key);
    const bool within = key.starts_with(entry.old_key) && key[entry.old_key.size()] == '.';
    if (!within || entry.old_key.size() <= group.size()) continue;
    group = entry.old_key;
    renamed_group = entry.key;
  }
  return std::string(renamed_group) + std::string(key.substr(group.size()));
}

const RemovedKey* removed_key(std::span<const RemovedKey> removed, std::string_view key) {
  const auto at = std::find_if(removed.begin(), removed.end(),
                               [&](const RemovedKey& r) { return r.key == key; });
  return at == removed.end() ? nullptr : &*at;
}

struct Moved {
  std::string key;
  Node value;
};

/// Stores a value below `group`, unless the key exists already.
void put(Node& group, std::string_view key, Node value) {
  Node* at = &group;
  for (std::size_t dot = key.find('.'); dot != std::string_view::npos; dot = key.find('.')) {
    const std::string_view name = key.substr(0, dot);
    auto child = std::find_if(at->children.begin(), at->children.end(),
                              [&](const Node& node) { return node.key == name; });
    if (child == at->children.end()) {
      Node made;
      made.kind = Node::Kind::kMap;
      made.key = std::string(name);
      made.key_where = made.where = value.where;
      at->children.push_back(std::move(made));
      child = at->children.end() - 1;
    }
    at = &*child;
    key.remove_prefix(dot + 1);
  }
  // A value of another type in place of a group is reported when the keys are applied.
  if (at->kind != Node::Kind::kMap || at->find(key) != nullptr) return;
  value.key = std::string(key);
  at->children.push_back(std::move(value));
}

/// Moves the values with an old name in a tree to their current keys; groups that become empty are
/// removed.
class OldKeys {
 public:
  OldKeys(const KeyChanges& changes, std::vector<std::string>& notices)
      : changes_(changes), notices_(notices) {}

  /// @param prefix of the keys in `root`, with its dot; keys keep this prefix.
  void rename(Node& root, const std::string& prefix) {
    std::vector<Moved> moved;
    take(root, prefix, moved);
    for (Moved& one : moved) {
      put(root, std::string_view(one.key).substr(prefix.size()), std::move(one.value));
    }
  }

 private:
  void take(Node& group, const std::string& prefix, std::vector<Moved>& moved) {
    std::vector<Node> kept;
    for (Node& child : group.children) {
      const std::string key = prefix + child.key;
      const bool removed = removed_key(changes_.removed, key) != nullptr;
      const bool was_group = !removed && child.kind == Node::Kind::kMap && !child.children.empty();
      if (was_group) take(child, key + '.', moved);
      if (was_group ? child.children.empty() : is_old(child, key, moved)) continue;
      if (child.kind == Node::Kind::kSequence) {
        for (Node& item : child.children) {
          if (item.kind == Node::Kind::kMap) rename(item, key + '.');
        }
      }
      kept.push_back(std::move(child));
    }
    group.children = std::move(kept);
  }

  bool is_old(Node& value, const std::string& key, std::vector<Moved>& moved) {
    const RemovedKey* const removed = removed_key(changes_.removed, key);
    if (removed != nullptr) {
      notices_.push_back(fmt::format("{}: {}{} was removed and is ignored. {}", value.key_where,
                                     changes_.prefix, key, removed->reason));
      return true;
    }
    std::string now = current_key(changes_.renamed, key);
    if (now == key) return false;
    notices_.push_back(
        fmt::format("{}: {}{} is called {}{} now. The old name is read in this release only",
                    value.key_where, changes_.prefix, key, changes_.prefix, now));
    moved.push_back({std::move(now), std::move(value)});
    return true;
  }

  const KeyChanges& changes_;
  std::vector<std::string>& notices_;
};

}  // namespace

void apply_key_changes(const KeyChanges& changes, Node& root, std::vector<std::string>& notices) {
  OldKeys(changes, notices).rename(root, "");
}

}  // namespace rali::config
