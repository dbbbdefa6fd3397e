#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <utility>

namespace metronome::collect::trust {

/// The newest `most` entries of a table that others could make grow for ever: with one more, the
/// one that was put in longest ago is forgotten. Not thread-safe.
template <class Key, class Value>
class Newest {
 public:
  explicit Newest(std::size_t most) : most_(most) {}

  /// Puts it in, or replaces it: it is the newest then. @return the kept value.
  Value& Put(const Key& key, Value value) {
    Erase(key);
    if (entries_.size() >= most_) Erase(Key(sequence_.front()));
    sequence_.push_back(key);
    return entries_.emplace(key, std::move(value)).first->second;
  }
  /// nullptr if it is not there (any more).
  [[nodiscard]] const Value* Find(const Key& key) const {
    const auto entry = entries_.find(key);
    return entry == entries_.end() ? nullptr : &entry->second;
  }
  void Erase(const Key& key) {
    if (entries_.erase(key) > 0) std::erase(sequence_, key);
  }

 private:
  std::size_t most_;
  std::map<Key, Value> entries_;
  std::deque<Key> sequence_;  // oldest first
};

}  // namespace metronome::collect::trust
