#include "common/config/config_fields.h"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cctype>

#include "common/text/near_miss.h"

namespace metronome::config {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;

bool IsMessage(const FieldDescriptor& field) {
  return field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
}

/// "CRITIC_HEADS_" for the enum CriticHeads.
std::string PrefixOf(const EnumDescriptor& type) {
  std::string prefix;
  for (const char c : type.name()) {
    if (!prefix.empty() && std::isupper(static_cast<unsigned char>(c))) prefix += '_';
    prefix += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return prefix + "_";
}

std::string Word(const EnumValueDescriptor& value) {
  std::string word = value.name();
  const std::string prefix = PrefixOf(*value.type());
  if (word.starts_with(prefix)) word.erase(0, prefix.size());
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return c == '_' ? '-' : std::tolower(c); });
  return word;
}

const EnumValueDescriptor* FindEnumValue(const EnumDescriptor& type, const std::string& text) {
  for (int i = 0; i < type.value_count(); ++i) {
    const EnumValueDescriptor* value = type.value(i);
    if (text::EditDistance(text, value->name()) == 0 || text::EditDistance(text, Word(*value)) == 0)
      return value;
  }
  return nullptr;
}

std::string Expected(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return "an integer from -2147483648 to 2147483647";
    case FieldDescriptor::CPPTYPE_UINT32:
      return "an integer from 0 to 4294967295";
    case FieldDescriptor::CPPTYPE_UINT64:
      return "an integer from 0 to 18446744073709551615";
    case FieldDescriptor::CPPTYPE_BOOL:
      return "true or false";
    default:
      return "a number";
  }
}

/// Whoever reads a value says what is wrong with it; without this Protobuf would log it too.
class NoErrors : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int, google::protobuf::io::ColumnNumber, const std::string&) override {}
};

/// Reads one value in text format; a repeated field gets one more.
bool ParseValue(Message& owner, const FieldDescriptor& field, const std::string& text) {
  NoErrors errors;
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&errors);
  return parser.ParseFieldValueFromString(text, &field, &owner);
}

/// @param index  -1 unless the field is repeated.
std::string PrintValue(const Message& owner, const FieldDescriptor& field, int index) {
  std::string text;
  TextFormat::PrintFieldValueToString(owner, &field, index, &text);
  return text;
}

// Of alternatives (a oneof) the one that is set; where none is, the first.
bool IsChosen(const Message& message, const FieldDescriptor& field) {
  const auto* alternatives = field.containing_oneof();
  if (alternatives == nullptr) return true;
  const auto* reflection = message.GetReflection();
  if (!reflection->HasOneof(message, alternatives)) return &field == alternatives->field(0);
  return reflection->HasField(message, &field);
}

/// Sets one value from what people write; a repeated field gets one more.
void AddValue(Message& owner, const std::string& path, const std::string& text,
              const FieldDescriptor& field) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
    return owner.GetReflection()->AddString(&owner, &field, text);
  }
  std::string value = text;
  if (const EnumDescriptor* type = field.enum_type()) {
    const EnumValueDescriptor* found = FindEnumValue(*type, text);
    if (!found) throw ConfigError(text::UnknownName("value of " + path, text, EnumWords(*type)));
    value = found->name();
  }
  if (ParseValue(owner, field, value)) return;
  throw ConfigError(path + " is \"" + text + "\": must be " + Expected(field));
}

void SetLeaf(Message& owner, const std::string& path, const std::string& text,
             const FieldDescriptor& field) {
  const auto* reflection = owner.GetReflection();
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING && !field.is_repeated()) {
    return reflection->SetString(&owner, &field, text);
  }
  reflection->ClearField(&owner, &field);
  if (!field.is_repeated()) return AddValue(owner, path, text, field);
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    AddValue(owner, path, text.substr(begin, end - begin), field);
    begin = end + 1;
  }
}

void Visit(const Message& message, const std::string& prefix, const FieldVisitor& visit) {
  const Descriptor& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    const std::string path = prefix + field.name();
    if (!IsChosen(message, field)) continue;
    if (IsMessage(field))
      Visit(message.GetReflection()->GetMessage(message, &field), path + ".", visit);
    else
      visit(path, message, field);
  }
}

// The field that path[begin, end) names in `owner`: a leaf at the path's end, a group before it.
const FieldDescriptor& FindStep(const Message& owner, const std::string& path, std::size_t begin,
                                std::size_t end) {
  const Descriptor& type = *owner.GetDescriptor();
  const std::string name = path.substr(begin, end - begin);
  const FieldDescriptor* field = type.FindFieldByName(name);
  if (!field) {
    throw ConfigError(UnknownSetting(path.substr(0, begin), name, type));
  }
  const bool last = end == path.size();
  if (IsMessage(*field) && last) {
    std::vector<std::string> members = FieldNames(*field->message_type());
    for (std::string& member : members) member.insert(0, path + ".");
    throw ConfigError(path + " is a group of settings: name one of " + text::JoinNames(members));
  }
  if (!IsMessage(*field) && !last) {
    throw ConfigError(path + ": " + path.substr(0, end) + " is one setting, nothing lies in it");
  }
  return *field;
}

// A value for an alternative beside the one that is chosen would choose it without a word.
void RequireNoOther(const Message& owner, const std::string& path, const FieldDescriptor& field) {
  const auto* alternatives = field.containing_oneof();
  if (alternatives == nullptr) return;
  const auto* chosen = owner.GetReflection()->GetOneofFieldDescriptor(owner, alternatives);
  if (chosen == nullptr || chosen == &field) return;
  throw ConfigError(path + ": " + chosen->name() + " is set already, and the " +
                    alternatives->name() + " is one alone");
}

/// Clears in `base` each list that `top` sets; merging would append to it.
void ClearLists(Message& base, const Message& top) {
  std::vector<const FieldDescriptor*> fields;
  top.GetReflection()->ListFields(top, &fields);
  for (const FieldDescriptor* field : fields) {
    if (field->is_repeated())
      base.GetReflection()->ClearField(&base, field);
    else if (IsMessage(*field))
      ClearLists(*base.GetReflection()->MutableMessage(&base, field),
                 top.GetReflection()->GetMessage(top, field));
  }
}

}  // namespace

std::vector<std::string> FieldNames(const Descriptor& message) {
  std::vector<std::string> names;
  names.reserve(static_cast<std::size_t>(message.field_count()));
  for (int i = 0; i < message.field_count(); ++i) names.push_back(message.field(i)->name());
  return names;
}

std::string UnknownSetting(const std::string& prefix, const std::string& name,
                           const Descriptor& type) {
  if (prefix + name == "ppo.success_reward") {
    return prefix + name + " is environment.success_reward now, with environment.reward=success";
  }
  const std::string where =
      prefix.empty() ? "setting" : "setting of " + prefix.substr(0, prefix.size() - 1);
  return text::UnknownName(where, name, FieldNames(type));
}

std::vector<std::string> EnumWords(const EnumDescriptor& type) {
  std::vector<std::string> words;
  words.reserve(static_cast<std::size_t>(type.value_count()));
  for (int i = 0; i < type.value_count(); ++i) words.push_back(Word(*type.value(i)));
  return words;
}

void VisitFields(const Message& message, const FieldVisitor& visit) { Visit(message, "", visit); }

std::string FieldText(const Message& owner, const FieldDescriptor& field) {
  const auto* reflection = owner.GetReflection();
  if (field.is_repeated()) {
    std::string text;
    for (int i = 0; i < reflection->FieldSize(owner, &field); ++i) {
      if (i > 0) text += ',';
      text += field.cpp_type() == FieldDescriptor::CPPTYPE_STRING
                  ? reflection->GetRepeatedString(owner, &field, i)
                  : PrintValue(owner, field, i);
    }
    return text;
  }
  if (field.enum_type()) return Word(*reflection->GetEnum(owner, &field));
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
    return reflection->GetString(owner, &field);
  }
  return PrintValue(owner, field, -1);
}

void SetField(Message& message, const std::string& path, const std::string& text) {
  Message* owner = &message;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const FieldDescriptor& field = FindStep(*owner, path, begin, end);
    RequireNoOther(*owner, path, field);
    if (end == path.size()) return SetLeaf(*owner, path, text, field);
    owner = owner->GetReflection()->MutableMessage(owner, &field);
    begin = end + 1;
  }
}

void Overlay(Message& base, const Message& top) {
  ClearLists(base, top);
  base.MergeFrom(top);
}

void FillDefaults(Message& message) {
  const Descriptor& type = *message.GetDescriptor();
  const auto* reflection = message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    if (!IsChosen(message, field)) continue;
    if (IsMessage(field))
      FillDefaults(*reflection->MutableMessage(&message, &field));
    else if (field.has_default_value() && !reflection->HasField(message, &field))
      ParseValue(message, field, PrintValue(message, field, -1));
  }
}

}  // namespace metronome::config
