#pragma once

#include <random>
#include <string>

#include "tests/support/gltf_builder.h"

namespace shutterline {

/// Changes a few values of the document to others that are likely to hurt, or removes them.
void MutateJson(nlohmann::json* json, std::mt19937_64* random);

/// Changes, inserts, removes or repeats a few bytes.
void MutateBytes(std::string* bytes, std::mt19937_64* random);

/// A mutant of a seed file: of its document, its buffer, its bytes, or of several. The same for the same
/// state of `random`, on every machine.
std::string MutateGltf(const GltfBuilder& seed, std::mt19937_64* random);

}  // namespace shutterline
