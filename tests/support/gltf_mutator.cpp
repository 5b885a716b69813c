#include "tests/support/gltf_mutator.h"

#include <algorithm>
#include <vector>

namespace shutterline {
namespace {

using Json = nlohmann::json;

// std::uniform_int_distribution may differ between standard libraries.
size_t Below(size_t count, std::mt19937_64* random) {
  return size_t((*random)() % count);
}

struct Spot {
  Json* parent;
  Json* value;
  std::string key;
};

void Collect(Json* json, std::vector<Spot>* spots) {
  if (!json->is_structured()) return;
  for (auto it = json->begin(); it != json->end(); ++it) {
    spots->push_back({json, &*it, json->is_object() ? it.key() : ""});
    Collect(&*it, spots);
  }
}

Json Nasty(const Json& old, std::mt19937_64* random) {
  const int64_t number = old.is_number() ? int64_t(std::clamp(old.get<double>(), -1e15, 1e15)) : 0;
  const std::vector<Json> choices = {number + 1,
                                     number - 1,
                                     number * 2 + 3,
                                     -1,
                                     0,
                                     1,
                                     2,
                                     255,
                                     65535,
                                     5121,
                                     5125,
                                     5126,
                                     (int64_t{1} << 31) - 1,
                                     int64_t{1} << 31,
                                     (int64_t{1} << 32) - 1,
                                     int64_t{1} << 32,
                                     int64_t{1} << 53,
                                     INT64_MIN,
                                     UINT64_MAX,
                                     0.5,
                                     1e300,
                                     -1e300,
                                     1e-300,
                                     nullptr,
                                     true,
                                     "",
                                     "../x",
                                     "data:,",
                                     "MAT3",
                                     "SCALAR",
                                     Json::array(),
                                     Json::object(),
                                     Json::array({0, 0, 0}),
                                     Json::object({{"index", 0}})};
  return choices[Below(choices.size(), random)];
}

}  // namespace

void MutateJson(Json* json, std::mt19937_64* random) {
  const size_t changes = 1 + Below(3, random);
  for (size_t i = 0; i < changes; ++i) {
    std::vector<Spot> spots;
    Collect(json, &spots);
    if (spots.empty()) return;
    const Spot spot = spots[Below(spots.size(), random)];
    switch (Below(8, random)) {
      case 0:
        if (spot.parent->is_object()) {
          spot.parent->erase(spot.key);
        } else {
          spot.parent->erase(spot.parent->size() - 1);
        }
        break;
      case 1:  // Another value of the same document in its place.
        *spot.value = Json(*spots[Below(spots.size(), random)].value);
        break;
      case 2:
        if (spot.value->is_array() && !spot.value->empty()) {
          spot.value->push_back(Json((*spot.value)[Below(spot.value->size(), random)]));
          break;
        }
        [[fallthrough]];
      default:
        *spot.value = Nasty(*spot.value, random);
        break;
    }
  }
}

void MutateBytes(std::string* bytes, std::mt19937_64* random) {
  const size_t changes = 1 + Below(8, random);
  for (size_t i = 0; i < changes && !bytes->empty(); ++i) {
    const size_t at = Below(bytes->size(), random);
    const size_t run = std::min(bytes->size() - at, 1 + Below(8, random));
    switch (Below(8, random)) {
      case 0:
        bytes->erase(at, run);
        break;
      case 1:
        bytes->insert(at, bytes->substr(at, run));
        break;
      case 2:
        std::fill_n(bytes->begin() + std::ptrdiff_t(at), run, Below(2, random) == 0 ? '\0' : '\xff');
        break;
      case 3:
        (*bytes)[at] = char((*bytes)[at] ^ char(1 << Below(8, random)));
        break;
      default:
        (*bytes)[at] = char(Below(256, random));
        break;
    }
  }
}

std::string MutateGltf(const GltfBuilder& seed, std::mt19937_64* random) {
  GltfBuilder mutant = seed;
  const size_t kind = Below(8, random);
  if (kind < 5) MutateJson(&mutant.json, random);
  if (kind == 4 || kind == 5) MutateBytes(&mutant.buffer, random);
  std::string file;
  try {
    file = Below(4, random) == 0 ? mutant.Gltf() : mutant.Glb();
  } catch (const Json::exception&) {
    file = seed.Glb();  // The mutant's own `buffers` cannot be indexed; the bytes are mutated instead.
    MutateBytes(&file, random);
  }
  if (kind > 5) MutateBytes(&file, random);
  return file;
}

}  // namespace shutterline
