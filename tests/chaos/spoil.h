#pragma once

#include <string>
#include <vector>

#include "common/messages/messages.h"

namespace metronome::chaos {

/// Makes of each true episode what a broken or hostile actor might send. Not thread-safe.
class Spoiler {
 public:
  /// The kinds that the constructor takes.
  static std::vector<std::string> Kinds();

  /// @throws std::invalid_argument for an unknown kind.
  explicit Spoiler(const std::string& kind);

  /// @param truth  an episode as the run wants it.
  /// @return what to send in its place, in this order; true episodes among them where the kind is a
  ///         nuisance and no lie.
  std::vector<EpisodeMessage> Spoil(EpisodeMessage truth);

 private:
  using Function = std::vector<EpisodeMessage> (*)(EpisodeMessage truth, EpisodeMessage& before);
  struct Kind {
    const char* name;
    Function spoil;
  };
  static const std::vector<Kind>& Table();

  Function spoil_ = nullptr;
  EpisodeMessage before_;  // the last true one
};

}  // namespace metronome::chaos
