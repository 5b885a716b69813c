#include "proto/convert/bounded_parse.h"

#include <absl/strings/str_cat.h>
#include <google/protobuf/descriptor.h>

#include <cstdint>

#include "common/base/status_macros.h"

namespace shutterline::convert {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

constexpr int kMaxLevels = 32;

absl::Status Malformed(const char* why) {
  return absl::InvalidArgumentError(absl::StrCat("malformed message: ", why));
}

/// Counts what a message holds. https://protobuf.dev/programming-guides/encoding
class FieldCounter {
 public:
  explicit FieldCounter(size_t budget) : left_(budget) {}

  absl::Status Count(absl::string_view bytes, const Descriptor& type, int level) {
    if (level > kMaxLevels) return Malformed("too many levels");
    while (!bytes.empty()) {
      uint64_t tag = 0, value = 0;
      if (!ReadVarint(bytes, tag) || tag > UINT32_MAX || tag >> 3 == 0) return Malformed("a bad tag");
      SL_RETURN_IF_ERROR(Spend(1));
      switch (tag & 7) {
        case 0:
          if (!ReadVarint(bytes, value)) return Malformed("a bad number");
          break;
        case 1:
        case 5: {
          const size_t size = (tag & 7) == 1 ? 8 : 4;
          if (bytes.size() < size) return Malformed("it is cut off");
          bytes.remove_prefix(size);
          break;
        }
        case 2: {
          if (!ReadVarint(bytes, value) || value > bytes.size()) return Malformed("it is cut off");
          const absl::string_view content = bytes.substr(0, size_t(value));
          bytes.remove_prefix(size_t(value));
          SL_RETURN_IF_ERROR(CountContent(content, type.FindFieldByNumber(int(tag >> 3)), level));
          break;
        }
        default:
          return Malformed("it has groups");
      }
    }
    return absl::OkStatus();
  }

 private:
  absl::Status CountContent(absl::string_view content, const FieldDescriptor* field, int level) {
    if (field == nullptr) return absl::OkStatus();
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      return Count(content, *field->message_type(), level + 1);
    }
    // A packed number takes a byte at least.
    return field->is_packable() ? Spend(content.size()) : absl::OkStatus();
  }

  absl::Status Spend(size_t count) {
    if (count > left_)
      return absl::InvalidArgumentError("the message has more fields than any request needs");
    left_ -= count;
    return absl::OkStatus();
  }

  static bool ReadVarint(absl::string_view& bytes, uint64_t& value) {
    value = 0;
    for (int shift = 0; shift < 64 && !bytes.empty(); shift += 7) {
      const auto byte = uint8_t(bytes.front());
      bytes.remove_prefix(1);
      value |= uint64_t(byte & 0x7f) << shift;
      if (byte < 0x80) return true;
    }
    return false;
  }

  size_t left_;
};

}  // namespace

absl::Status ParseBounded(absl::string_view bytes, size_t max_fields, google::protobuf::Message& message) {
  message.Clear();
  SL_RETURN_IF_ERROR(FieldCounter(max_fields).Count(bytes, *message.GetDescriptor(), 1));
  if (bytes.size() > INT32_MAX || !message.ParseFromArray(bytes.data(), int(bytes.size()))) {
    return Malformed("it cannot be parsed");
  }
  return absl::OkStatus();
}

}  // namespace shutterline::convert
