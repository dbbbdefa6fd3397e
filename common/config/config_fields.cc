#include "common/config/config_fields.h"

#include <algorithm>
#include <cctype>
#include <optional>

#include "common/text/near_miss.h"
#include "common/text/number_text.h"

namespace metronome {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

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
    if (EditDistance(text, value->name()) == 0 || EditDistance(text, Word(*value)) == 0)
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

[[noreturn]] void FailType(const std::string& path, const std::string& text,
                           const FieldDescriptor& field) {
  throw ConfigError(path + " is \"" + text + "\": must be " + Expected(field));
}

template <typename T>
T Parse(const std::string& path, const std::string& text, const FieldDescriptor& field) {
  const auto value = ParseNumber<T>(text);
  if (!value) FailType(path, text, field);
  return *value;
}

bool ParseBool(const std::string& path, const std::string& text, const FieldDescriptor& field) {
  if (text == "true" || text == "1") return true;
  if (text == "false" || text == "0") return false;
  FailType(path, text, field);
}

// The configuration has one kind of list: int32.
void SetList(Message& owner, const std::string& path, const std::string& text,
             const FieldDescriptor& field) {
  std::vector<std::int32_t> values;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    values.push_back(Parse<std::int32_t>(path, text.substr(begin, end - begin), field));
    begin = end + 1;
  }
  owner.GetReflection()->ClearField(&owner, &field);
  for (const std::int32_t value : values) owner.GetReflection()->AddInt32(&owner, &field, value);
}

void SetLeaf(Message& owner, const std::string& path, const std::string& text,
             const FieldDescriptor& field) {
  if (field.is_repeated()) return SetList(owner, path, text, field);
  const auto* reflection = owner.GetReflection();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return reflection->SetInt32(&owner, &field, Parse<std::int32_t>(path, text, field));
    case FieldDescriptor::CPPTYPE_UINT32:
      return reflection->SetUInt32(&owner, &field, Parse<std::uint32_t>(path, text, field));
    case FieldDescriptor::CPPTYPE_UINT64:
      return reflection->SetUInt64(&owner, &field, Parse<std::uint64_t>(path, text, field));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection->SetDouble(&owner, &field, Parse<double>(path, text, field));
    case FieldDescriptor::CPPTYPE_BOOL:
      return reflection->SetBool(&owner, &field, ParseBool(path, text, field));
    case FieldDescriptor::CPPTYPE_STRING:
      return reflection->SetString(&owner, &field, text);
    case FieldDescriptor::CPPTYPE_ENUM: {
      const EnumValueDescriptor* value = FindEnumValue(*field.enum_type(), text);
      if (!value)
        throw ConfigError(UnknownName("value of " + path, text, EnumWords(*field.enum_type())));
      return reflection->SetEnum(&owner, &field, value);
    }
    default:
      throw std::logic_error(path + ": a field type that configurations do not have");
  }
}

void Visit(const Message& message, const std::string& prefix, const FieldVisitor& visit) {
  const Descriptor& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    const std::string path = prefix + field.name();
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
    const std::string where = begin == 0 ? "setting" : "setting of " + path.substr(0, begin - 1);
    throw ConfigError(UnknownName(where, name, FieldNames(type)));
  }
  const bool last = end == path.size();
  if (IsMessage(*field) && last) {
    std::vector<std::string> members = FieldNames(*field->message_type());
    for (std::string& member : members) member.insert(0, path + ".");
    throw ConfigError(path + " is a group of settings: name one of " + JoinNames(members));
  }
  if (!IsMessage(*field) && !last) {
    throw ConfigError(path + ": " + path.substr(0, end) + " is one setting, nothing lies in it");
  }
  return *field;
}

// Copies one set leaf; both messages have the same type.
void CopyLeaf(Message& to, const Message& from, const FieldDescriptor& field) {
  SetLeaf(to, field.name(), FieldText(from, field), field);
}

}  // namespace

std::vector<std::string> FieldNames(const Descriptor& message) {
  std::vector<std::string> names;
  names.reserve(static_cast<std::size_t>(message.field_count()));
  for (int i = 0; i < message.field_count(); ++i) names.push_back(message.field(i)->name());
  return names;
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
      text += std::to_string(reflection->GetRepeatedInt32(owner, &field, i));
    }
    return text;
  }
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return std::to_string(reflection->GetInt32(owner, &field));
    case FieldDescriptor::CPPTYPE_UINT32:
      return std::to_string(reflection->GetUInt32(owner, &field));
    case FieldDescriptor::CPPTYPE_UINT64:
      return std::to_string(reflection->GetUInt64(owner, &field));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return FormatNumber(reflection->GetDouble(owner, &field));
    case FieldDescriptor::CPPTYPE_BOOL:
      return reflection->GetBool(owner, &field) ? "true" : "false";
    case FieldDescriptor::CPPTYPE_ENUM:
      return Word(*reflection->GetEnum(owner, &field));
    case FieldDescriptor::CPPTYPE_STRING:
      return reflection->GetString(owner, &field);
    default:
      throw std::logic_error(field.name() + ": a field type that configurations do not have");
  }
}

void SetField(Message& message, const std::string& path, const std::string& text) {
  Message* owner = &message;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const FieldDescriptor& field = FindStep(*owner, path, begin, end);
    if (end == path.size()) return SetLeaf(*owner, path, text, field);
    owner = owner->GetReflection()->MutableMessage(owner, &field);
    begin = end + 1;
  }
}

void Overlay(Message& base, const Message& top) {
  const auto* reflection = top.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection->ListFields(top, &fields);
  for (const FieldDescriptor* field : fields) {
    if (IsMessage(*field))
      Overlay(*base.GetReflection()->MutableMessage(&base, field),
              reflection->GetMessage(top, field));
    else
      CopyLeaf(base, top, *field);
  }
}

void FillDefaults(Message& message) {
  const Descriptor& type = *message.GetDescriptor();
  const auto* reflection = message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    if (IsMessage(field))
      FillDefaults(*reflection->MutableMessage(&message, &field));
    else if (!field.is_repeated() && field.has_default_value() &&
             !reflection->HasField(message, &field))
      CopyLeaf(message, message, field);
  }
}

}  // namespace metronome
