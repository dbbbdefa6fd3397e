#pragma once

#include <CLI/CLI.hpp>

namespace metronome::kernels {

/// `--isa`, of every command that computes a policy or an update: ChooseIsa, as the command line is
/// parsed. Another word, or what the processor does not have, is an error of the command line.
void AddIsaOption(CLI::App& command);

}  // namespace metronome::kernels
