#include "common/config/config_file.h"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <system_error>
#include <vector>

#include "common/process/files.h"
#include "common/text/near_miss.h"

namespace metronome {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::TextFormat;

/// The text by lines, to turn Protobuf's columns (a tab advances to the next multiple of 8) into
/// bytes and to find words.
class SourceText {
 public:
  SourceText(const std::string& text, std::string name) : name_(std::move(name)) {
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      lines_.push_back(text.substr(begin, end - begin));
      begin = end + 1;
    }
  }

  /// "name:line:column" of a zero-based Protobuf position.
  [[nodiscard]] std::string At(int line, int column) const {
    return Format(line, Byte(line, column));
  }

  /// Position of the last whole `word` that starts at or before the given one: Protobuf reports
  /// some errors only after it has read on to the next token.
  [[nodiscard]] std::string AtWord(const std::string& word, int line, int column) const {
    std::size_t from = Byte(line, column);
    for (int l = std::min(line, static_cast<int>(lines_.size()) - 1); l >= 0; --l) {
      for (std::size_t at = lines_[l].rfind(word, from); at != std::string::npos;
           at = at == 0 ? std::string::npos : lines_[l].rfind(word, at - 1)) {
        if (IsWhole(lines_[l], at, word.size())) return Format(l, at);
      }
      from = std::string::npos;
    }
    return At(line, column);
  }

 private:
  static bool IsNameByte(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

  static bool IsWhole(const std::string& line, std::size_t at, std::size_t size) {
    return (at == 0 || !IsNameByte(line[at - 1])) &&
           (at + size >= line.size() || !IsNameByte(line[at + size]));
  }

  [[nodiscard]] std::size_t Byte(int line, int column) const {
    if (line < 0 || line >= static_cast<int>(lines_.size())) return 0;
    std::size_t byte = 0;
    for (int at = 0; at < column && byte < lines_[line].size(); ++byte) {
      at = lines_[line][byte] == '\t' ? at + 8 - at % 8 : at + 1;
    }
    return byte;
  }

  [[nodiscard]] std::string Format(int line, std::size_t byte) const {
    return name_ + ":" + std::to_string(line + 1) + ":" + std::to_string(byte + 1);
  }

  std::string name_;
  std::vector<std::string> lines_;
};

struct Owner {
  const Descriptor* type = nullptr;
  std::string prefix;  // dotted path of its fields: "" or "policy."
};

// The configuration's groups lie one level deep and each type occurs once.
std::vector<Owner> Groups() {
  std::vector<Owner> groups = {{RunConfig::descriptor(), ""}};
  const Descriptor& root = *RunConfig::descriptor();
  groups.reserve(1 + static_cast<std::size_t>(root.field_count()));
  for (int i = 0; i < root.field_count(); ++i) {
    if (const auto* type = root.field(i)->message_type()) {
      groups.push_back({type, root.field(i)->name() + "."});
    }
  }
  return groups;
}

/// What stands between the literal pieces that `text` is made of; std::nullopt if it is not.
std::optional<std::vector<std::string>> Holes(const std::string& text,
                                              const std::vector<std::string>& pieces) {
  if (!text.starts_with(pieces.front()) || !text.ends_with(pieces.back())) return std::nullopt;
  std::vector<std::string> holes;
  std::size_t begin = pieces.front().size();
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    const bool last = i + 1 == pieces.size();
    const std::size_t end = last ? text.size() - pieces[i].size() : text.find(pieces[i], begin);
    if (end == std::string::npos || end < begin) return std::nullopt;
    holes.push_back(text.substr(begin, end - begin));
    begin = end + pieces[i].size();
  }
  return holes;
}

std::string UnknownFieldMessage(const std::string& type_name, const std::string& field) {
  for (const Owner& group : Groups()) {
    if (group.type->full_name() != type_name) continue;
    const std::string where = group.prefix.empty()
                                  ? "setting"
                                  : "setting of " + group.prefix.substr(0, group.prefix.size() - 1);
    return UnknownName(where, field, FieldNames(*group.type));
  }
  return "unknown setting \"" + field + "\"";
}

std::string UnknownEnumMessage(const std::string& value, const std::string& field_name) {
  for (const Owner& group : Groups()) {
    const FieldDescriptor* field = group.type->FindFieldByName(field_name);
    if (!field || !field->enum_type()) continue;
    std::vector<std::string> known;
    known.reserve(static_cast<std::size_t>(field->enum_type()->value_count()));
    for (int i = 0; i < field->enum_type()->value_count(); ++i) {
      known.push_back(field->enum_type()->value(i)->name());
    }
    return UnknownName("value of " + group.prefix + field_name, value, known);
  }
  return "unknown value \"" + value + "\" of " + field_name;
}

/// Keeps the first error; what follows it is mostly its consequence.
class FirstError : public google::protobuf::io::ErrorCollector {
 public:
  explicit FirstError(const SourceText& source) : source_(source) {}

  void AddError(int line, google::protobuf::io::ColumnNumber column,
                const std::string& message) override {
    if (error_.empty()) error_ = Explain(line, column, message);
  }

  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  [[nodiscard]] std::string Explain(int line, int column, const std::string& message) const {
    if (const auto part = Holes(message, {"Message type \"", "\" has no field named \"", "\"."}))
      return source_.AtWord(part->back(), line, column) + ": " +
             UnknownFieldMessage(part->front(), part->back());
    if (const auto part =
            Holes(message, {"Unknown enumeration value of \"", "\" for field \"", "\"."}))
      return source_.AtWord(part->front(), line, column) + ": " +
             UnknownEnumMessage(part->front(), part->back());
    if (const auto part =
            Holes(message, {"Invalid value for boolean field \"", "\". Value: \"", "\"."}))
      return source_.AtWord(part->back(), line, column) + ": " + message;
    if (const auto part =
            Holes(message, {"Non-repeated field \"", "\" is specified multiple times."}))
      return source_.AtWord(part->front(), line, column) + ": " + message;
    return source_.At(line, column) + ": " + message;
  }

  const SourceText& source_;
  std::string error_;
};

// One origin per leaf that `group` sets.
void RecordOrigins(const google::protobuf::Message& group, const TextFormat::ParseInfoTree& tree,
                   const std::string& prefix, const SourceText& source, ConfigOrigins& origins) {
  std::vector<const FieldDescriptor*> fields;
  group.GetReflection()->ListFields(group, &fields);
  for (const FieldDescriptor* field : fields) {
    const std::string path = prefix + field->name();
    if (field->message_type()) {
      RecordOrigins(group.GetReflection()->GetMessage(group, field),
                    *tree.GetTreeForNested(field, -1), path + ".", source, origins);
      continue;
    }
    const auto at = tree.GetLocation(field, field->is_repeated() ? 0 : -1);
    origins[path] = source.At(at.line, at.column);
  }
}

// Editors of Windows mark their encoding by the first bytes. @return the text behind the mark.
std::string WithoutByteOrderMark(const std::string& text, const std::string& name) {
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
    throw ConfigError(name + ":1:1: the file is saved as UTF-16: save it as UTF-8");
  }
  return text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text;
}

}  // namespace

ParsedConfig ParseConfigText(const std::string& whole, const std::string& name) {
  const std::string text = WithoutByteOrderMark(whole, name);
  const SourceText source(text, name);
  FirstError errors(source);
  TextFormat::ParseInfoTree tree;
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&errors);
  parser.WriteLocationsTo(&tree);
  ParsedConfig parsed;
  if (!parser.ParseFromString(text, &parsed.config) || !errors.error().empty()) {
    throw ConfigError(errors.error().empty() ? name + ":1:1: not a configuration" : errors.error());
  }
  RecordOrigins(parsed.config, tree, "", source, parsed.origins);
  return parsed;
}

ParsedConfig ParseConfigFile(const std::string& path) {
  std::string text;
  try {
    text = ReadFile(path);
  } catch (const std::system_error& error) {
    throw ConfigError("cannot read configuration file " + path + ": " + error.code().message());
  }
  return ParseConfigText(text, path);
}

}  // namespace metronome
