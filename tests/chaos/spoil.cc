#include "tests/chaos/spoil.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace metronome::chaos {
namespace {

using Messages = std::vector<EpisodeMessage>;

std::size_t MiddleOf(const EpisodeMessage& message) { return message.episode.reward.size() / 2; }

Messages WrongHead(EpisodeMessage truth, EpisodeMessage&) {
  std::uint16_t& head = truth.episode.head[MiddleOf(truth)];
  head = static_cast<std::uint16_t>(head == 0 ? 1 : head - 1);
  return {std::move(truth)};
}

Messages NotANumber(EpisodeMessage truth, EpisodeMessage&) {
  truth.episode.reward[MiddleOf(truth)] = std::numeric_limits<float>::quiet_NaN();
  return {std::move(truth)};
}

Messages Infinite(EpisodeMessage truth, EpisodeMessage&) {
  truth.episode.observation.back() = std::numeric_limits<float>::infinity();
  return {std::move(truth)};
}

/// By the least that a float can differ.
Messages WrongLogProb(EpisodeMessage truth, EpisodeMessage&) {
  float& log_prob = truth.episode.log_prob[MiddleOf(truth)];
  log_prob = std::nextafter(log_prob, std::numeric_limits<float>::max());
  return {std::move(truth)};
}

/// By the least that a float can differ, where no check sees it: only an audit does.
Messages WrongReward(EpisodeMessage truth, EpisodeMessage&) {
  float& reward = truth.episode.reward[MiddleOf(truth)];
  reward = std::nextafter(reward, std::numeric_limits<float>::max());
  return {std::move(truth)};
}

Messages WrongAction(EpisodeMessage truth, EpisodeMessage&) {
  const std::size_t actions = truth.episode.action.size() / truth.episode.reward.size();
  truth.episode.action[MiddleOf(truth) * actions] += 0.25F;
  return {std::move(truth)};
}

/// Consistent in its lengths, but not of the run's T.
Messages TooShort(EpisodeMessage truth, EpisodeMessage&) {
  Episode& episode = truth.episode;
  const std::size_t steps = episode.reward.size() - 1;
  episode.observation.resize(episode.observation.size() / (steps + 2) * (steps + 1));
  episode.action.resize(episode.action.size() / (steps + 1) * steps);
  episode.log_prob.resize(steps);
  episode.reward.resize(steps);
  episode.head.resize(steps);
  episode.flags.resize(steps);
  episode.flags.back() |= kStepTruncated;
  return {std::move(truth)};
}

Messages WrongVersion(EpisodeMessage truth, EpisodeMessage&) {
  truth.episode.weights_version += 1;
  return {std::move(truth)};
}

/// The message of an actor that has not heard of the learner's restart.
Messages OldRun(EpisodeMessage truth, EpisodeMessage&) {
  EpisodeMessage old = truth;
  old.incarnation -= 1;
  old.episode.reward.front() += 1;  // it must not matter
  return {std::move(old), std::move(truth)};
}

Messages Replayed(EpisodeMessage truth, EpisodeMessage& before) {
  Messages messages;
  if (!before.episode.reward.empty()) messages.push_back(before);
  messages.push_back(truth);
  messages.push_back(truth);
  before = std::move(truth);
  return messages;
}

/// An old episode under the number that is wanted now.
Messages Renumbered(EpisodeMessage truth, EpisodeMessage& before) {
  EpisodeMessage lie = before;
  lie.incarnation = truth.incarnation;
  lie.episode.number = truth.episode.number;
  const bool first = before.episode.reward.empty();
  before = std::move(truth);
  return {first ? before : std::move(lie)};
}

Messages NotAssigned(EpisodeMessage truth, EpisodeMessage&) {
  EpisodeMessage extra = truth;
  extra.episode.number += 1'000'000;
  EpisodeMessage stranger = truth;
  stranger.actor_id += 1;
  return {std::move(extra), std::move(stranger), std::move(truth)};
}

}  // namespace

const std::vector<Spoiler::Kind>& Spoiler::Table() {
  static const std::vector<Kind> table = {
      {"wrong-head", WrongHead},       {"not-a-number", NotANumber},
      {"infinite", Infinite},          {"wrong-log-prob", WrongLogProb},
      {"wrong-action", WrongAction},   {"too-short", TooShort},
      {"wrong-version", WrongVersion}, {"old-run", OldRun},
      {"replayed", Replayed},          {"renumbered", Renumbered},
      {"not-assigned", NotAssigned},   {"wrong-reward", WrongReward},
  };
  return table;
}

std::vector<std::string> Spoiler::Kinds() {
  std::vector<std::string> names;
  for (const Kind& kind : Table()) names.emplace_back(kind.name);
  return names;
}

Spoiler::Spoiler(const std::string& name) {
  for (const Kind& kind : Table()) {
    if (name == kind.name) spoil_ = kind.spoil;
  }
  if (spoil_ == nullptr) throw std::invalid_argument("unknown kind '" + name + "'");
}

std::vector<EpisodeMessage> Spoiler::Spoil(EpisodeMessage truth) {
  return spoil_(std::move(truth), before_);
}

}  // namespace metronome::chaos
