#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace shutterline {

/// What mattes are named after, by the index of the node or material that pixels belong to. Empty: nothing is
/// drawn of it. What shares a name shares a matte.
struct MatteNames {
  std::vector<std::string> objects, materials;
};

/// The id under which a name stands in pixels, by the Cryptomatte specification 1.2: the name's MurmurHash3,
/// with one bit of the exponent turned where it would make a float that is infinite, not a number, denormal
/// or zero.
uint32_t MatteIdBits(absl::string_view name);
/// The same as the float that pixels hold.
float MatteId(absl::string_view name);

/// Adds the header attributes of the Cryptomatte `layer` ("CryptoObject"): its name, hash, conversion and the
/// manifest of `names`, a JSON object from names to ids. Bytes that are no UTF-8 appear there as U+FFFD.
void AddMatteMetadata(absl::string_view layer, const std::vector<std::string>& names,
                      std::map<std::string, std::string>& attributes);

}  // namespace shutterline
