#pragma once

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

/// Configuration fields by dotted path ("ppo.learning_rate"), by Protobuf reflection.
/// All functions are free of state.
namespace metronome::config {

/// The configuration cannot be used as it is; what() names field, value and what is allowed, one
/// complaint a line. Processes print it and exit 2.
class ConfigError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Names of a message's fields, in declaration order.
std::vector<std::string> FieldNames(const google::protobuf::Descriptor& message);

/// What to say of a name that a group of settings does not have: where it went, or the near miss
/// and all names. @param prefix  of the group's paths: "" or "policy.".
std::string UnknownSetting(const std::string& prefix, const std::string& name,
                           const google::protobuf::Descriptor& type);

/// The words for an enum's values: "ppo-time" for PPO_TIME; a prefix that repeats the enum's own
/// name is left out ("random" for PLACEMENTS_RANDOM).
std::vector<std::string> EnumWords(const google::protobuf::EnumDescriptor& type);

/// Called with the dotted path of a leaf, the message that owns it and its field.
using FieldVisitor =
    std::function<void(const std::string& path, const google::protobuf::Message& owner,
                       const google::protobuf::FieldDescriptor& field)>;

/// Visits every leaf of the configuration, set or not, in declaration order; of alternatives (a
/// oneof) those of the one that is set, or of the first where none is.
void VisitFields(const google::protobuf::Message& message, const FieldVisitor& visit);

/// A leaf's value (its default if unset) as people write it: numbers as in a configuration file,
/// enums as words, strings without quotes, repeated fields joined by commas.
std::string FieldText(const google::protobuf::Message& owner,
                      const google::protobuf::FieldDescriptor& field);

/// Sets the leaf at `path` from text, which is written as FieldText does, numbers in any way that a
/// file takes; a repeated leaf takes a comma-separated list, which replaces what was there. If it
/// throws, the leaf may be unset. Types and ranges of types are checked, ranges of meaning are
/// Validate's.
/// @throws ConfigError for an unknown path (near miss and list of that message's fields), a path
///         that is no leaf, a text of another type, or an alternative beside the one that is set.
void SetField(google::protobuf::Message& message, const std::string& path, const std::string& text);

/// Sets in `base` every leaf that is set in `top`; repeated leaves are replaced, not appended to.
void Overlay(google::protobuf::Message& base, const google::protobuf::Message& top);

/// Sets every unset leaf that declares a default to it, so that a printout shows all; of
/// alternatives as in VisitFields.
void FillDefaults(google::protobuf::Message& message);

}  // namespace metronome::config
