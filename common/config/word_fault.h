#pragma once

#include <optional>
#include <string>

/// Words in a configuration file that mean nothing to the configuration.
namespace metronome::config {

/// As Protobuf counts: from zero, and a tab advances to the next multiple of 8.
struct TextPosition {
  int line = 0;
  int column = 0;
};

struct WordFault {
  TextPosition at;
  std::string what;
};

/// Looks for a name that the configuration does not have, an enumeration's or a boolean's word that
/// it does not take, and a setting that stands twice. Protobuf's parser finds these too, but tells
/// them in a sentence, and at the token after.
/// @param text   that the parser refused.
/// @param error  where it did; nothing behind it is looked at.
/// @return std::nullopt: the text is wrong in another way, which the parser's message says.
/// Pure function.
std::optional<WordFault> FindWordFault(const std::string& text, TextPosition error);

}  // namespace metronome::config
