#include "actor/environment/registry.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include "common/text/near_miss.h"

namespace metronome::environment {
namespace {

std::vector<std::string> NamesOf(const EnvironmentEntry& entry) {
  std::vector<std::string> names = {entry.spec.short_name(), entry.spec.name()};
  names.insert(names.end(), entry.aliases.begin(), entry.aliases.end());
  if (names[0] == names[1]) names.erase(names.begin());
  return names;
}

bool HasName(const EnvironmentEntry& entry, const std::string& name) {
  const auto names = NamesOf(entry);
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

EnvironmentRegistry::EnvironmentRegistry(std::vector<EnvironmentEntry> entries,
                                         std::function<void()> require_machine)
    : entries_(std::move(entries)), require_machine_(std::move(require_machine)) {
  std::map<std::string, int> times;
  for (const EnvironmentEntry& entry : entries_) {
    for (const std::string& name : NamesOf(entry)) {
      if (++times[name] > 1) throw std::logic_error("two environments are called " + name);
    }
  }
}

const EnvironmentEntry& EnvironmentRegistry::Find(const std::string& name) const {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&name](const auto& entry) { return HasName(entry, name); });
  if (found != entries_.end()) return *found;
  std::vector<std::string> known;
  std::vector<std::string> spellings;
  for (const EnvironmentEntry& entry : entries_) {
    known.push_back(entry.spec.short_name());
    for (const std::string& spelling : NamesOf(entry)) spellings.push_back(spelling);
  }
  auto near = text::NearMiss(name, known);
  if (!near) near = text::NearMiss(name, spellings);
  throw std::invalid_argument(text::UnknownName("environment", name, known, near));
}

std::unique_ptr<Environment> EnvironmentRegistry::Make(const EnvironmentConfig& config) const {
  const EnvironmentEntry& entry = Find(config.task());
  if (config.spec().SerializeAsString() != entry.spec.SerializeAsString()) {
    throw std::invalid_argument("the run's " + config.task() + " is " +
                                config.spec().ShortDebugString() + ", the one here is " +
                                entry.spec.ShortDebugString() +
                                ": build both from the same sources");
  }
  return entry.make(config);
}

void EnvironmentRegistry::RequireMachine() const {
  if (require_machine_) require_machine_();
}

}  // namespace metronome::environment
