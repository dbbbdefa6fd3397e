#include "common/config/config_file.h"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <system_error>
#include <vector>

#include "common/config/word_fault.h"
#include "common/process/files.h"

namespace metronome::config {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::TextFormat;
using google::protobuf::io::ColumnNumber;
using google::protobuf::io::ErrorCollector;

/// The text by lines, to turn Protobuf's columns (a tab advances to the next multiple of 8) into
/// bytes.
class SourceText {
 public:
  SourceText(const std::string& text, std::string name) : name_(std::move(name)) {
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      lines_.push_back(text.substr(begin, end - begin));
      begin = end + 1;
    }
  }

  /// "name:line:column", as people and editors count.
  [[nodiscard]] std::string At(TextPosition at) const {
    return name_ + ":" + std::to_string(at.line + 1) + ":" +
           std::to_string(Byte(at.line, at.column) + 1);
  }

 private:
  [[nodiscard]] std::size_t Byte(int line, int column) const {
    if (line < 0 || line >= static_cast<int>(lines_.size())) return 0;
    std::size_t byte = 0;
    for (int at = 0; at < column && byte < lines_[line].size(); ++byte) {
      at = lines_[line][byte] == '\t' ? at + 8 - at % 8 : at + 1;
    }
    return byte;
  }

  std::string name_;
  std::vector<std::string> lines_;
};

/// Keeps the first error; what follows it is mostly its consequence.
class FirstError : public ErrorCollector {
 public:
  void AddError(int line, ColumnNumber column, const std::string& message) override {
    if (!message_.empty()) return;
    at_ = {line, column};
    message_ = message;
  }

  [[nodiscard]] TextPosition at() const { return at_; }
  [[nodiscard]] const std::string& message() const { return message_; }

 private:
  TextPosition at_;
  std::string message_;  // empty: no error
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
    origins[path] = source.At({at.line, at.column});
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
  FirstError error;
  TextFormat::ParseInfoTree tree;
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&error);
  parser.WriteLocationsTo(&tree);
  ParsedConfig parsed;
  if (!parser.ParseFromString(text, &parsed.config)) {
    const auto fault = FindWordFault(text, error.at());
    throw ConfigError(fault ? source.At(fault->at) + ": " + fault->what
                            : source.At(error.at()) + ": " + error.message());
  }
  RecordOrigins(parsed.config, tree, "", source, parsed.origins);
  return parsed;
}

ParsedConfig ParseConfigFile(const std::string& path) {
  std::string text;
  try {
    text = process::ReadFile(path);
  } catch (const std::system_error& error) {
    throw ConfigError("cannot read configuration file " + path + ": " + error.code().message());
  }
  return ParseConfigText(text, path);
}

}  // namespace metronome::config
