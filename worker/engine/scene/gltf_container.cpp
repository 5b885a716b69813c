#include "worker/engine/scene/gltf_container.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <cstdint>

namespace shutterline::engine {
namespace {

constexpr uint32_t kJsonChunk = 0x4E4F534A;
constexpr uint32_t kBinChunk = 0x004E4942;
constexpr uint64_t kHeaderBytes = 12;
constexpr uint64_t kChunkHeaderBytes = 8;

uint32_t LittleEndian32(absl::string_view bytes, uint64_t offset) {
  uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value |= uint32_t{uint8_t(bytes[offset + i])} << (8 * i);
  return value;
}

absl::StatusOr<GltfContainer> SplitGlb(absl::string_view bytes) {
  GltfContainer result;
  if (bytes.size() < kHeaderBytes + kChunkHeaderBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("GLB header: the file ends after ", bytes.size(), " bytes"));
  }
  if (const uint32_t version = LittleEndian32(bytes, 4); version != 2) {
    return absl::InvalidArgumentError(absl::StrCat("GLB header: version ", version, " is not 2"));
  }
  const uint64_t length = LittleEndian32(bytes, 8);
  if (length > bytes.size()) {
    return absl::InvalidArgumentError(absl::StrCat("GLB header: length ", length, " exceeds the file's ",
                                                   bytes.size(), " bytes: it is cut short"));
  }
  if (length < bytes.size()) {
    result.warnings.push_back(
        absl::StrCat("GLB header: ", bytes.size() - length, " bytes after the declared length ignored"));
  }

  uint64_t offset = kHeaderBytes;
  for (int chunk = 0; offset < length; ++chunk) {
    if (length - offset < kChunkHeaderBytes) {
      return absl::InvalidArgumentError(absl::StrCat("GLB chunk ", chunk, ": its header at byte ", offset,
                                                     " runs past the length ", length));
    }
    const uint64_t chunk_length = LittleEndian32(bytes, offset);
    const uint32_t type = LittleEndian32(bytes, offset + 4);
    offset += kChunkHeaderBytes;
    if (chunk_length > length - offset) {
      return absl::InvalidArgumentError(absl::StrCat("GLB chunk ", chunk, ": its ", chunk_length,
                                                     " bytes at byte ", offset, " run past the length ",
                                                     length));
    }
    const absl::string_view data = bytes.substr(offset, chunk_length);
    offset += chunk_length;
    if (chunk == 0) {
      if (type != kJsonChunk) return absl::InvalidArgumentError("GLB chunk 0: it is not JSON");
      result.json = data;
    } else if (chunk == 1 && type == kBinChunk) {
      result.bin = data;
      result.has_bin = true;
    } else {
      // Chunks of unknown types are for extensions; glTF tells readers to pass over them.
      if (result.warnings.size() < 16)
        result.warnings.push_back(absl::StrCat("GLB chunk ", chunk, ": ignored"));
    }
  }
  if (result.json.empty()) return absl::InvalidArgumentError("GLB header: the file has no JSON chunk");
  return result;
}

}  // namespace

absl::StatusOr<GltfContainer> SplitGltfContainer(absl::string_view bytes) {
  if (bytes.empty()) return absl::InvalidArgumentError("the file is empty");
  if (bytes.substr(0, 4) == "glTF") return SplitGlb(bytes);
  // JSON begins with a brace, perhaps after white space or a byte order mark. Said here, because a
  // JSON parser's complaint about a picture or an archive helps nobody.
  absl::string_view text = bytes;
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  while (!text.empty() && (text[0] == ' ' || text[0] == '\t' || text[0] == '\r' || text[0] == '\n')) {
    text.remove_prefix(1);
  }
  if (text.empty() || text[0] != '{') {
    return absl::InvalidArgumentError("the file is neither GLB (it does not begin with \"glTF\") nor JSON");
  }
  GltfContainer result;
  result.json = text;
  return result;
}

}  // namespace shutterline::engine
