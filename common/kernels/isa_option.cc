#include "common/kernels/isa_option.h"

#include <stdexcept>
#include <string>

#include "common/kernels/isa.h"
#include "common/text/near_miss.h"

namespace metronome::kernels {
namespace {

void Choose(const std::string& name) {
  const auto isa = IsaNamed(name);
  if (!isa) {
    throw CLI::ValidationError(
        "--isa", text::UnknownName("instruction set", name, NamesOf(kEveryIsa)) +
                     "; this processor has: " + text::JoinNames(NamesOf(SupportedIsas())));
  }
  try {
    ChooseIsa(*isa);
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError("--isa", error.what());
  }
}

}  // namespace

void AddIsaOption(CLI::App& command) {
  command
      .add_option_function<std::string>(
          "--isa", Choose,
          "Instructions that compute policies and updates: " + text::JoinNames(NamesOf(kEveryIsa)) +
              "; all give the same bits [default: the fastest that the processor has]")
      ->type_name("X");
}

}  // namespace metronome::kernels
