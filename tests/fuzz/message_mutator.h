#pragma once

#include <google/protobuf/message.h>

#include <random>
#include <string>

namespace shutterline {

/// Changes a few fields somewhere in `message`: extreme numbers, unknown enums, odd texts, elements added,
/// dropped or doubled.
void MutateFields(google::protobuf::Message& message, std::mt19937_64& random);

/// Changes a few bytes: flipped, dropped, doubled, cut off, or swapped for lengths and numbers that are
/// extreme.
void MutateBytes(std::string& bytes, std::mt19937_64& random);

}  // namespace shutterline
