#include "tests/fuzz/message_mutator.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace shutterline {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

int64_t OddInteger(std::mt19937_64& random) {
  constexpr int64_t kOdd[] = {0,         1,         -1,        2,         31,      32,      33,
                              64,        65,        1023,      1024,      16384,   32768,   65536,
                              INT32_MAX, INT32_MIN, INT64_MAX, INT64_MIN, 100'000, 1 << 20, -1000};
  if (random() % 3 == 0) return int64_t(random() >> (random() % 64));
  return kOdd[random() % std::size(kOdd)];
}

double OddReal(std::mt19937_64& random) {
  const double odd[] = {0.0,
                        -0.0,
                        1.0,
                        -1.0,
                        0.5,
                        1e-320,
                        1e-30,
                        1e30,
                        1e308,
                        -1e308,
                        std::nan(""),
                        std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity(),
                        24.0,
                        0.0025,
                        4.0};
  return odd[random() % std::size(odd)];
}

std::string OddText(std::mt19937_64& random) {
  const char* const odd[] = {"",
                             "a",
                             "fox.glb",
                             "../x",
                             "/etc/passwd",
                             "a/b",
                             "all",
                             "none",
                             "0",
                             "-1",
                             "a\nb",
                             "\xC3\xA4",
                             "99999999999999999999",
                             "environment.exr",
                             "a\\b",
                             "."};
  if (random() % 8 == 0) return std::string(random() % 5000, 'x');
  if (random() % 8 == 0) return std::string(random() % 2000, '\0');
  return odd[random() % std::size(odd)];
}

void SetScalar(Message& message, const FieldDescriptor* field, bool append, std::mt19937_64& random) {
  const Reflection& r = *message.GetReflection();
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      append ? r.AddInt32(&message, field, int32_t(OddInteger(random)))
             : r.SetInt32(&message, field, int32_t(OddInteger(random)));
      return;
    case FieldDescriptor::CPPTYPE_INT64:
      append ? r.AddInt64(&message, field, OddInteger(random))
             : r.SetInt64(&message, field, OddInteger(random));
      return;
    case FieldDescriptor::CPPTYPE_UINT32:
      append ? r.AddUInt32(&message, field, uint32_t(OddInteger(random)))
             : r.SetUInt32(&message, field, uint32_t(OddInteger(random)));
      return;
    case FieldDescriptor::CPPTYPE_UINT64:
      append ? r.AddUInt64(&message, field, uint64_t(OddInteger(random)))
             : r.SetUInt64(&message, field, uint64_t(OddInteger(random)));
      return;
    case FieldDescriptor::CPPTYPE_DOUBLE:
      append ? r.AddDouble(&message, field, OddReal(random)) : r.SetDouble(&message, field, OddReal(random));
      return;
    case FieldDescriptor::CPPTYPE_FLOAT:
      append ? r.AddFloat(&message, field, float(OddReal(random)))
             : r.SetFloat(&message, field, float(OddReal(random)));
      return;
    case FieldDescriptor::CPPTYPE_BOOL:
      append ? r.AddBool(&message, field, random() % 2 != 0) : r.SetBool(&message, field, random() % 2 != 0);
      return;
    case FieldDescriptor::CPPTYPE_ENUM: {
      const int value = random() % 4 == 0 ? int(int32_t(OddInteger(random))) : int(random() % 12);
      append ? r.AddEnumValue(&message, field, value) : r.SetEnumValue(&message, field, value);
      return;
    }
    case FieldDescriptor::CPPTYPE_STRING: {
      std::string text = OddText(random);
      if (field->type() == FieldDescriptor::TYPE_BYTES && random() % 2 == 0)
        text = std::string(32, char(random()));
      append ? r.AddString(&message, field, text) : r.SetString(&message, field, text);
      return;
    }
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return;
  }
}

void MutateOne(Message& message, std::mt19937_64& random) {
  const auto& type = *message.GetDescriptor();
  if (type.field_count() == 0) return;
  const Reflection& r = *message.GetReflection();
  const FieldDescriptor* field = type.field(int(random() % uint64_t(type.field_count())));
  const bool is_message = field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
  if (field->is_repeated()) {
    const int size = r.FieldSize(message, field);
    switch (random() % 4) {
      case 0:
        if (size > 0) r.RemoveLast(&message, field);
        return;
      case 1:
        if (is_message) {
          Message* added = r.AddMessage(&message, field);
          if (size > 0) added->CopyFrom(r.GetRepeatedMessage(message, field, int(random() % uint64_t(size))));
        } else {
          SetScalar(message, field, true, random);
        }
        return;
      case 2:
        if (size > 1) r.SwapElements(&message, field, 0, int(random() % uint64_t(size)));
        return;
      default:
        if (is_message && size > 0) {
          MutateOne(*r.MutableRepeatedMessage(&message, field, int(random() % uint64_t(size))), random);
        } else if (!is_message) {
          SetScalar(message, field, true, random);
        }
        return;
    }
  }
  if (random() % 12 == 0) {
    r.ClearField(&message, field);
  } else if (is_message) {
    MutateOne(*r.MutableMessage(&message, field), random);
  } else {
    SetScalar(message, field, false, random);
  }
}

}  // namespace

void MutateFields(Message& message, std::mt19937_64& random) {
  for (uint64_t i = 1 + random() % 4; i > 0; --i) MutateOne(message, random);
}

void MutateBytes(std::string& bytes, std::mt19937_64& random) {
  const std::string odd[] = {std::string(9, '\xff') + '\x01', std::string(1, '\0'), "\x7b\x7c",
                             "\xff\xff\xff\xff\x0f", "\x80"};
  for (uint64_t i = 1 + random() % 3; i > 0 && !bytes.empty(); --i) {
    const size_t at = random() % bytes.size();
    switch (random() % 6) {
      case 0:
        bytes[at] = char(bytes[at] ^ char(1 << random() % 8));
        break;
      case 1:
        bytes[at] = char(random());
        break;
      case 2:
        bytes.erase(at, 1 + random() % 8);
        break;
      case 3:
        bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 40));
        break;
      case 4:
        bytes.resize(at);
        break;
      default:
        bytes.insert(at, odd[random() % std::size(odd)]);
        break;
    }
  }
}

}  // namespace shutterline
