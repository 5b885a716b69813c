#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>
#include <google/protobuf/message.h>

#include <cstddef>

namespace shutterline::convert {

/// Parses a stranger's `bytes` into `message`. Two bytes of the wire can become a hundred of memory (an empty
/// element of a repeated field, an unknown group), so the fields and elements of all levels are counted
/// first, without memory: more than `max_fields`, groups and more than 32 levels are refused.
/// INVALID_ARGUMENT then, and where the bytes are no message.
absl::Status ParseBounded(absl::string_view bytes, size_t max_fields, google::protobuf::Message& message);

}  // namespace shutterline::convert
