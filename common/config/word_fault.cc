#include "common/config/word_fault.h"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "common/config/config_fields.h"
#include "common/schema/config.pb.h"
#include "common/text/near_miss.h"

namespace metronome::config {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::io::Tokenizer;

/// The parser has told them already.
class NoErrors : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int, google::protobuf::io::ColumnNumber, const std::string&) override {}
};

/// The words that text format takes as values of `field`; none: it takes no words, or any.
std::vector<std::string> WordsOf(const FieldDescriptor& field) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_BOOL) {
    return {"true", "false", "True", "False", "t", "f"};
  }
  std::vector<std::string> words;
  const auto* type = field.enum_type();
  for (int i = 0; type && i < type->value_count(); ++i) words.push_back(type->value(i)->name());
  return words;
}

/// Reads along the grammar of text format as far as it needs to know whose field a name is. Its
/// functions return whether to read on; they do not where a fault is found or the grammar is left.
class Reader {
 public:
  Reader(const std::string& text, TextPosition error)
      : error_(error),
        input_(text.data(), static_cast<int>(text.size())),
        tokens_(&input_, &errors_) {
    tokens_.set_comment_style(Tokenizer::SH_COMMENT_STYLE);  // these four: as the parser does
    tokens_.set_allow_f_after_float(true);
    tokens_.set_require_space_after_number(false);
    tokens_.set_allow_multiline_strings(true);
    tokens_.Next();
  }

  /// The fields of one group. @param prefix  of their paths: "" or "policy.".
  bool ReadFields(const Descriptor& type, const std::string& prefix) {
    std::set<std::string> seen;
    while (Now().type == Tokenizer::TYPE_IDENTIFIER && !BehindError()) {
      const FieldDescriptor* field = ReadName(type, prefix, seen);
      if (!field) return false;
      Skip(":");
      if (!(field->message_type() ? ReadGroup(*field, prefix) : ReadValues(*field, prefix))) {
        return false;
      }
      if (!Skip(",")) Skip(";");
    }
    return true;
  }

  [[nodiscard]] const std::optional<WordFault>& fault() const { return fault_; }

 private:
  using Token = Tokenizer::Token;

  const Token& Now() { return tokens_.current(); }
  bool Is(const std::string& text) { return Now().text == text; }
  bool Skip(const std::string& text) { return Is(text) && tokens_.Next(); }
  bool BehindError() {
    return std::pair(Now().line, Now().column) > std::pair(error_.line, error_.column);
  }
  void SetFault(const std::string& what) { fault_ = {{Now().line, Now().column}, what}; }

  /// @return nullptr: the name is at fault.
  const FieldDescriptor* ReadName(const Descriptor& type, const std::string& prefix,
                                  std::set<std::string>& seen) {
    const std::string name = Now().text;
    const FieldDescriptor* field = type.FindFieldByName(name);
    if (!field) {
      SetFault(UnknownSetting(prefix, name, type));
      return nullptr;
    }
    if (!seen.insert(name).second && !field->is_repeated()) {
      SetFault(prefix + name + " is set twice");
      return nullptr;
    }
    tokens_.Next();
    return field;
  }

  bool ReadGroup(const FieldDescriptor& field, const std::string& prefix) {
    if (!Skip("{") && !Skip("<")) return false;
    if (!ReadFields(*field.message_type(), prefix + field.name() + ".")) return false;
    return Skip("}") || Skip(">");
  }

  bool ReadValues(const FieldDescriptor& field, const std::string& prefix) {
    if (!Skip("[")) return ReadValue(field, prefix);
    while (!Is("]")) {
      if (!ReadValue(field, prefix)) return false;
      Skip(",");
    }
    return Skip("]");
  }

  bool ReadValue(const FieldDescriptor& field, const std::string& prefix) {
    if (BehindError()) return false;
    Skip("-");
    const auto type = Now().type;
    const std::vector<std::string> words = WordsOf(field);
    if (type == Tokenizer::TYPE_IDENTIFIER && !words.empty() &&
        std::find(words.begin(), words.end(), Now().text) == words.end()) {
      SetFault(text::UnknownName("value of " + prefix + field.name(), Now().text, words));
      return false;
    }
    if (!tokens_.Next()) return false;
    while (type == Tokenizer::TYPE_STRING && Now().type == type) tokens_.Next();  // side by side
    return true;
  }

  const TextPosition error_;
  NoErrors errors_;
  google::protobuf::io::ArrayInputStream input_;
  Tokenizer tokens_;
  std::optional<WordFault> fault_;
};

}  // namespace

std::optional<WordFault> FindWordFault(const std::string& text, TextPosition error) {
  Reader reader(text, error);
  reader.ReadFields(*RunConfig::descriptor(), "");
  return reader.fault();
}

}  // namespace metronome::config
