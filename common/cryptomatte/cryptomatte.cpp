#include "common/cryptomatte/cryptomatte.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <bit>
#include <nlohmann/json.hpp>

#include "common/cryptomatte/murmur_hash.h"

namespace shutterline {

uint32_t MatteIdBits(absl::string_view name) {
  const uint32_t bits = MurmurHash3(name);
  const uint32_t exponent = bits >> 23 & 0xff;
  return exponent == 0 || exponent == 0xff ? bits ^ 1u << 23 : bits;
}

float MatteId(absl::string_view name) {
  return std::bit_cast<float>(MatteIdBits(name));
}

void AddMatteMetadata(absl::string_view layer, const std::vector<std::string>& names,
                      std::map<std::string, std::string>& attributes) {
  nlohmann::json manifest = nlohmann::json::object();
  for (const std::string& name : names) {
    if (!name.empty()) manifest[name] = absl::StrFormat("%08x", MatteIdBits(name));
  }
  // Several Cryptomattes of a file are told apart by the hash of their names.
  const std::string prefix =
      absl::StrCat("cryptomatte/", absl::StrFormat("%08x", MurmurHash3(layer)).substr(0, 7), "/");
  attributes[prefix + "name"] = std::string(layer);
  attributes[prefix + "hash"] = "MurmurHash3_32";
  attributes[prefix + "conversion"] = "uint32_to_float32";
  attributes[prefix + "manifest"] = manifest.dump(/*indent=*/-1, /*indent_char=*/' ', /*ensure_ascii=*/false,
                                                  nlohmann::json::error_handler_t::replace);
}

}  // namespace shutterline
