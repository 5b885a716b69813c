#include "worker/engine/scene/gltf_document.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "common/base/status_macros.h"
#include "common/base/utf8.h"
#include "common/base/work_limit.h"
#include "worker/engine/scene/gltf_accessor.h"
#include "worker/engine/scene/gltf_container.h"
#include "worker/engine/scene/gltf_json.h"
#include "worker/engine/scene/gltf_light.h"
#include "worker/engine/scene/gltf_schema.h"
#include "worker/engine/scene/gltf_uri.h"

namespace shutterline::engine {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxListedWarnings = 1000;

/// Extensions that a file may require. All are implemented but the last three, which add nothing to the
/// picture that a reader without them shows (other variants of materials, metadata).
constexpr std::array<absl::string_view, 10> kSupportedExtensions = {"KHR_lights_punctual",
                                                                    "KHR_materials_emissive_strength",
                                                                    "KHR_materials_ior",
                                                                    "KHR_materials_specular",
                                                                    "KHR_materials_unlit",
                                                                    "KHR_mesh_quantization",
                                                                    "KHR_texture_transform",
                                                                    "KHR_materials_variants",
                                                                    "KHR_xmp",
                                                                    "KHR_xmp_json_ld"};

absl::Status CheckAsset(const Json& json) {
  const Json& asset = json["asset"];
  const auto& version = asset["version"].get_ref<const std::string&>();
  if (version.rfind("2.", 0) != 0) {
    return absl::InvalidArgumentError(absl::StrCat("asset.version: ", version, " is not 2.x"));
  }
  if (const auto minimum = asset.find("minVersion"); minimum != asset.end()) {
    if (minimum->get_ref<const std::string&>() != "2.0") {
      return absl::UnimplementedError(
          absl::StrCat("asset.minVersion: ", minimum->get_ref<const std::string&>(), " is above 2.0"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckExtensions(const Json& json) {
  const auto required = json.find("extensionsRequired");
  if (required == json.end()) return absl::OkStatus();
  std::vector<std::string> unsupported;
  for (const Json& extension : *required) {
    const auto& name = extension.get_ref<const std::string&>();
    if (std::find(kSupportedExtensions.begin(), kSupportedExtensions.end(), name) ==
        kSupportedExtensions.end()) {
      unsupported.push_back(name);
    }
  }
  if (unsupported.empty()) return absl::OkStatus();
  return absl::UnimplementedError(
      absl::StrCat("extensionsRequired: ", absl::StrJoin(unsupported, ", "), " not supported"));
}

absl::Status LoadBuffer(GltfDocument* document, const Json& buffer, size_t index, absl::string_view bin,
                        bool has_bin) {
  const auto uri = buffer.find("uri");
  absl::string_view bytes;
  if (uri == buffer.end()) {
    if (index != 0 || !has_bin) {
      return absl::InvalidArgumentError("it has no uri, and the file has no BIN chunk for it");
    }
    bytes = bin;
  } else {
    const auto& text = uri->get_ref<const std::string&>();
    std::string data;
    if (IsDataUri(text)) {
      SL_ASSIGN_OR_RETURN(data, DecodeDataUri(text, document->file_bytes.Left()));
    } else {
      SL_ASSIGN_OR_RETURN(const std::string name, DecodeFileUri(text));
      SL_ASSIGN_OR_RETURN(data, document->source.Read(name, document->file_bytes.Left()));
    }
    SL_RETURN_IF_ERROR(document->file_bytes.Take(data.size(), "its data"));
    document->storage.push_back(std::move(data));
    bytes = document->storage.back();
  }
  const uint64_t length = buffer["byteLength"].get<uint64_t>();
  if (length > bytes.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("byteLength ", length, " exceeds the ", bytes.size(), " bytes of its data"));
  }
  document->buffers.push_back(bytes.substr(0, length));
  return absl::OkStatus();
}

/// tinygltf drops channels without a node, which glTF tells readers to pass over; they go here, where it
/// can be said.
void DropChannelsWithoutNode(GltfDocument* document, Json* json) {
  const auto animations = json->find("animations");
  if (animations == json->end()) return;
  for (size_t a = 0; a < animations->size(); ++a) {
    auto& channels = (*animations)[a]["channels"].get_ref<Json::array_t&>();
    const auto gone = std::remove_if(channels.begin(), channels.end(),
                                     [](const Json& channel) { return !channel["target"].contains("node"); });
    if (gone == channels.end()) continue;
    document->Warn(
        absl::StrCat("animation ", a, ": ", channels.end() - gone, " channels without a node ignored"));
    channels.erase(gone, channels.end());
  }
}

}  // namespace

GltfDocument::GltfDocument(const AssetSource& asset_source, const ImportLimits& import_limits)
    : source(asset_source),
      limits(import_limits),
      file_bytes("bytes", import_limits.max_file_bytes),
      memory("bytes of memory", import_limits.base_memory),
      vertices("vertices", import_limits.max_vertices),
      triangles("triangles", import_limits.max_triangles),
      texture_pixels("pixels", std::min(import_limits.base_texture_pixels, import_limits.max_texture_pixels)),
      drawn_triangles("triangles drawn", import_limits.base_drawn),
      drawn_vertices("vertices drawn", import_limits.base_drawn),
      posed("joints and morph weights posed", import_limits.base_posed) {}

void GltfDocument::Warn(std::string warning) {
  if (report.warnings.size() < kMaxListedWarnings) {
    report.warnings.push_back(std::move(warning));
  } else {
    ++unlisted_warnings_;
  }
}

void GltfDocument::CloseWarnings() {
  if (unlisted_warnings_ > 0)
    report.warnings.push_back(absl::StrCat("and ", unlisted_warnings_, " more warnings"));
}

absl::string_view GltfDocument::ViewBytes(int buffer_view) const {
  const tinygltf::BufferView& view = model.bufferViews[size_t(buffer_view)];
  return buffers[size_t(view.buffer)].substr(view.byteOffset, view.byteLength);
}

std::string GltfElement(absl::string_view kind, size_t index, absl::string_view name) {
  if (name.empty()) return absl::StrCat(kind, " ", index);
  return absl::StrCat(kind, " ", index, " (", Utf8Prefix(name, 60), ")");
}

absl::Status ReadGltfRoot(GltfDocument* document, Json* json, std::string* root, absl::string_view* bin,
                          bool* has_bin) {
  const std::string& name = document->source.RootName();
  SL_ASSIGN_OR_RETURN(*root, document->source.Read(name, document->limits.max_file_bytes));
  return ParseGltfRoot(document, *root, json, bin, has_bin);
}

absl::Status ParseGltfRoot(GltfDocument* document, absl::string_view root, Json* json, absl::string_view* bin,
                           bool* has_bin) {
  SL_RETURN_IF_ERROR(document->file_bytes.Take(root.size(), "the root file"));
  SL_ASSIGN_OR_RETURN(const GltfContainer container, SplitGltfContainer(root));
  for (const std::string& warning : container.warnings) document->Warn(warning);
  *bin = container.bin;
  *has_bin = container.has_bin;
  SL_ASSIGN_OR_RETURN(const Json parsed, ParseBoundedJson(container.json, document->limits.max_depth,
                                                          document->limits.max_json_values));
  CheckWork();
  SL_ASSIGN_OR_RETURN(*json, ConformToGltfSchema(parsed, document->limits.max_nodes));
  SL_RETURN_IF_ERROR(CheckAsset(*json));
  return CheckExtensions(*json);
}

absl::Status LoadGltfDocument(GltfDocument* document) {
  Json json;
  absl::string_view bin;
  bool has_bin = false;
  document->storage.emplace_back();
  SL_RETURN_IF_ERROR(ReadGltfRoot(document, &json, &document->storage.back(), &bin, &has_bin));

  if (const auto buffers = json.find("buffers"); buffers != json.end()) {
    document->storage.reserve(1 + buffers->size());  // Moved strings would leave the views behind.
    for (size_t i = 0; i < buffers->size(); ++i) {
      CheckWork();
      SL_RETURN_IF_ERROR(
          Annotate(LoadBuffer(document, (*buffers)[i], i, bin, has_bin), absl::StrCat("buffer ", i)));
    }
  }
  if (const auto images = json.find("images"); images != json.end()) {
    for (const Json& image : *images) {
      document->images.push_back(
          {image.value("name", ""), image.value("uri", ""), image.value("bufferView", -1)});
    }
  }
  SL_ASSIGN_OR_RETURN(document->lights, ReadGltfLights(json));
  // What a file may unfold into: a fixed amount, and so many bytes for each of its own.
  const uint64_t bytes = document->limits.max_file_bytes - document->file_bytes.Left();
  document->memory.RaiseWithin(bytes * document->limits.memory_per_file_byte,
                               std::max(document->limits.base_memory, document->limits.max_memory));
  for (GltfBudget* drawn : {&document->drawn_triangles, &document->drawn_vertices, &document->posed}) {
    drawn->Raise(uint64_t(double(bytes) * document->limits.drawn_per_file_byte));
  }
  DropChannelsWithoutNode(document, &json);
  CheckWork();
  SL_ASSIGN_OR_RETURN(document->model, ReadWithTinyGltf(json));
  return CheckGltfAccessors(*document);
}

}  // namespace shutterline::engine
