#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "actor/environment/registry.h"
#include "actor/play/evaluate.h"
#include "actor/render/render.h"
#include "actor/replay/placements.h"
#include "actor/replay/trace.h"
#include "common/messages/bus_options.h"
#include "common/process/logging.h"

namespace metronome::actor {

/// `metronome-actor run`.
struct JoinOptions {
  BusOptions bus;
  std::string network = "loopback";  // as typed
  int envs = 1;                      // episodes at once, a thread each
  bool stay = false;
  std::optional<double> learner_timeout;  // seconds
  process::LogOptions log;
};

/// `metronome-actor environment`.
struct DescribeOptions {
  std::string name;  // empty: all names
};

/// `metronome-actor tasks`.
struct TasksOptions {
  std::string picture;  // PNG file of all scenes; empty: none
};

using ActorCommand =
    std::variant<JoinOptions, DescribeOptions, TasksOptions, replay::TraceOptions,
                 replay::PlacementsOptions, play::EvaluateOptions, render::RenderOptions>;

/// The command line of an actor program with these environments. Prints help and complaints itself.
/// @return the command, or the exit status: 0 (help), 2 (usage).
std::variant<ActorCommand, int> ParseActorCommand(int argc, const char* const* argv,
                                                  const environment::EnvironmentRegistry& registry);

}  // namespace metronome::actor
