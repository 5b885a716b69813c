#include "worker/engine/scene/gltf_schema.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <cfloat>
#include <climits>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/status_macros.h"
#include "worker/engine/scene/gltf_schema_tables.h"

namespace shutterline::engine {
namespace {

using Json = nlohmann::json;

constexpr uint64_t kMaxSize = uint64_t{1} << 53;  // The largest whole number that JSON carries safely.

/// Where a value stands in the document; made into words only for errors.
struct Place {
  const Place* parent = nullptr;
  const char* name = nullptr;  ///< A property...
  size_t index = 0;            ///< ...or, where it is null, an element of the parent.

  std::string Text() const {
    if (parent == nullptr) return "glTF";
    if (name == nullptr) {
      // "accessor 7" for the document's own arrays, "primitives[2]" inside of them.
      if (parent->parent != nullptr && parent->parent->parent == nullptr) {
        std::string array = parent->name;
        if (array == "meshes") return absl::StrCat("mesh ", index);
        if (array.back() == 's') array.pop_back();
        return absl::StrCat(array, " ", index);
      }
      return absl::StrCat(parent->Text(), "[", index, "]");
    }
    if (parent->parent == nullptr) return name;
    // "accessor 7: count", "accessor 7: sparse.count", "mesh 0: primitives[2].mode".
    const bool in_element = parent->name == nullptr && parent->parent->parent->parent == nullptr;
    return absl::StrCat(parent->Text(), in_element ? ": " : ".", name);
  }
};

absl::Status Wrong(const Place& place, absl::string_view reason) {
  return absl::InvalidArgumentError(absl::StrCat(place.Text(), ": ", reason));
}

/// A value as people may read it in a message, cut where it is long.
std::string Shown(const Json& value) {
  if (value.is_structured()) return value.is_array() ? "an array" : "an object";
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > 40) text = text.substr(0, 37) + "...";
  return text;
}

class Conformer {
 public:
  Conformer(const Json& document, uint32_t max_elements) : document_(document), max_elements_(max_elements) {}

  absl::StatusOr<Json> Object(const Json& in, const GltfShape& shape, const Place& place) const {
    if (!in.is_object()) return Wrong(place, absl::StrCat(Shown(in), " is not an object"));
    Json out = Json::object();
    for (const GltfField& field : shape) {
      const auto found = in.find(field.name);
      if (found == in.end()) {
        if (field.required)
          return Wrong(place, absl::StrCat("required property ", field.name, " is missing"));
        continue;
      }
      SL_ASSIGN_OR_RETURN(out[field.name], Value(*found, field, Place{&place, field.name}));
    }
    return out;
  }

 private:
  absl::StatusOr<Json> Value(const Json& in, const GltfField& field, const Place& place) const {
    switch (field.kind) {
      case GltfKind::kIndex:
        return Index(in, field, place);
      case GltfKind::kIndexList:
        return List(in, place, [&](const Json& e, const Place& p) { return Index(e, field, p); });
      case GltfKind::kIndexMap:
        return IndexMap(in, field, place);
      case GltfKind::kIndexMaps:
        return List(in, place, [&](const Json& e, const Place& p) { return IndexMap(e, field, p); });
      case GltfKind::kSize:
        return Whole(in, kMaxSize, place);
      case GltfKind::kInt:
        return Code(in, field, place);
      case GltfKind::kNumber:
        return Number(in, place);
      case GltfKind::kNumberList:
        if (in.is_array() && field.length != 0 && in.size() != field.length) {
          return Wrong(place, absl::StrCat("it has ", in.size(), " numbers instead of ", field.length));
        }
        return List(in, place, [&](const Json& e, const Place& p) { return Number(e, p); });
      case GltfKind::kBool:
        if (!in.is_boolean()) return Wrong(place, absl::StrCat(Shown(in), " is neither true nor false"));
        return in;
      case GltfKind::kString:
        return String(in, place);
      case GltfKind::kWord:
        return Word(in, field, place);
      case GltfKind::kStringList:
        return List(in, place, [&](const Json& e, const Place& p) { return String(e, p); });
      case GltfKind::kObject:
        return Object(in, *field.shape, place);
      case GltfKind::kObjectList:
        return List(in, place, [&](const Json& e, const Place& p) { return Object(e, *field.shape, p); });
      case GltfKind::kPresence:
        if (!in.is_object()) return Wrong(place, absl::StrCat(Shown(in), " is not an object"));
        return Json::object();
    }
    return absl::InternalError("schema: unknown kind");
  }

  template <typename Element>
  absl::StatusOr<Json> List(const Json& in, const Place& place, const Element& element) const {
    if (!in.is_array()) return Wrong(place, absl::StrCat(Shown(in), " is not an array"));
    if (in.size() > max_elements_) {
      return absl::ResourceExhaustedError(
          absl::StrCat(place.Text(), ": ", in.size(), " elements, more than the limit of ", max_elements_));
    }
    Json out = Json::array();
    out.get_ref<Json::array_t&>().reserve(in.size());
    for (size_t i = 0; i < in.size(); ++i) {
      SL_ASSIGN_OR_RETURN(Json value, element(in[i], Place{&place, nullptr, i}));
      out.push_back(std::move(value));
    }
    return out;
  }

  absl::StatusOr<Json> Whole(const Json& in, uint64_t max, const Place& place) const {
    if (in.is_number_unsigned()) {
      if (const uint64_t value = in.get<uint64_t>(); value <= max) return Json(value);
    } else if (in.is_number_float()) {
      // 4.0 is an integer to JSON schema. The comparison comes before the conversion, which is undefined
      // for numbers out of range.
      const double value = in.get<double>();
      if (value >= 0 && value <= double(max) && value == std::floor(value)) return Json(uint64_t(value));
    }
    return Wrong(place, absl::StrCat(Shown(in), " is not a whole number from 0 to ", max));
  }

  absl::StatusOr<Json> Index(const Json& in, const GltfField& field, const Place& place) const {
    const Json::json_pointer target(absl::StrCat("/", field.target));
    const Json* const array = document_.contains(target) ? &document_[target] : nullptr;
    const size_t size = array != nullptr && array->is_array() ? array->size() : 0;
    SL_ASSIGN_OR_RETURN(Json value, Whole(in, INT_MAX, place));
    if (value.get<uint64_t>() >= size) {
      return Wrong(place, absl::StrCat(value.get<uint64_t>(), " does not exist: the file has ", size, " ",
                                       target.back()));
    }
    return value;
  }

  absl::StatusOr<Json> IndexMap(const Json& in, const GltfField& field, const Place& place) const {
    if (!in.is_object()) return Wrong(place, absl::StrCat(Shown(in), " is not an object"));
    Json out = Json::object();
    for (const auto& [key, value] : in.items()) {
      SL_ASSIGN_OR_RETURN(out[key], Index(value, field, Place{&place, key.c_str()}));
    }
    return out;
  }

  absl::StatusOr<Json> Code(const Json& in, const GltfField& field, const Place& place) const {
    SL_ASSIGN_OR_RETURN(Json value, Whole(in, INT_MAX, place));
    if (!field.codes.empty() &&
        std::find(field.codes.begin(), field.codes.end(), value.get<int>()) == field.codes.end()) {
      return Wrong(place, absl::StrCat(value.get<int>(), " is none of ", absl::StrJoin(field.codes, ", ")));
    }
    return value;
  }

  absl::StatusOr<Json> Number(const Json& in, const Place& place) const {
    if (!in.is_number()) return Wrong(place, absl::StrCat(Shown(in), " is not a number"));
    const double value = in.get<double>();
    if (!(std::fabs(value) <= FLT_MAX)) {
      return Wrong(place, absl::StrCat(Shown(in), " does not fit a 32-bit float"));
    }
    // As a real, also where it is written as an integer: tinygltf cuts integers inside of extensions to 32
    // bits.
    return Json(value);
  }

  absl::StatusOr<Json> String(const Json& in, const Place& place) const {
    if (!in.is_string()) return Wrong(place, absl::StrCat(Shown(in), " is not a string"));
    return in;
  }

  absl::StatusOr<Json> Word(const Json& in, const GltfField& field, const Place& place) const {
    SL_ASSIGN_OR_RETURN(Json value, String(in, place));
    const auto& word = value.get_ref<const std::string&>();
    for (absl::string_view known : field.words) {
      if (word == known) return value;
    }
    return Wrong(place, absl::StrCat(Shown(in), " is none of ", absl::StrJoin(field.words, ", ")));
  }

  const Json& document_;
  const uint32_t max_elements_;
};

}  // namespace

absl::StatusOr<Json> ConformToGltfSchema(const Json& document, uint32_t max_elements) {
  return Conformer(document, max_elements).Object(document, GltfRootShape(), Place{});
}

}  // namespace shutterline::engine
