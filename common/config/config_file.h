#pragma once

#include <map>
#include <string>

#include "common/config/config_fields.h"
#include "common/schema/config.pb.h"

/// Configuration files: RunConfig in Protobuf text format.
namespace metronome::config {

/// Where values came from: dotted path -> "run.cfg:3:5" or "--heads".
using ConfigOrigins = std::map<std::string, std::string>;

struct ParsedConfig {
  RunConfig config;       // only what the text sets
  ConfigOrigins origins;  // one entry per leaf that it sets
};

/// Parses text format, in UTF-8, with or without a byte-order mark. Positions are 1-based; columns
/// count bytes (without the mark).
/// @param name  of the source, for messages.
/// @throws ConfigError "name:line:column: message" - for an unknown field or enum value with the
///         near miss and the list.
ParsedConfig ParseConfigText(const std::string& text, const std::string& name);

/// The same from a file. @throws ConfigError also when it cannot be read.
ParsedConfig ParseConfigFile(const std::string& path);

}  // namespace metronome::config
