#include "worker/engine/scene/gltf_image.h"

#include <absl/status/status.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <climits>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <unordered_map>

#include "common/base/status_macros.h"
#include "worker/engine/scene/gltf_jpeg_check.h"

namespace {

/// The decoder's memory: bounded, so that a few bytes of compressed zeros cannot fill the machine, and
/// freed with the decode however that ends.
class DecodeHeap {
 public:
  explicit DecodeHeap(size_t limit) : limit_(limit), outer_(current) { current = this; }
  ~DecodeHeap() {
    for (const auto& [block, size] : blocks_) std::free(block);
    current = outer_;
  }
  DecodeHeap(const DecodeHeap&) = delete;

  void* Allocate(size_t size) {
    if (size > limit_ - used_) return nullptr;
    void* block = std::malloc(size);
    if (block != nullptr) Enter(block, size);
    return block;
  }
  void* Reallocate(void* old, size_t size) {
    if (old == nullptr) return Allocate(size);
    const size_t old_size = blocks_.at(old);
    void* block = Allocate(size);
    if (block == nullptr) return nullptr;
    std::memcpy(block, old, old_size < size ? old_size : size);
    Free(old);
    return block;
  }
  void Free(void* block) {
    const auto found = blocks_.find(block);
    if (found == blocks_.end()) return;
    used_ -= found->second;
    blocks_.erase(found);
    std::free(block);
  }

  static thread_local DecodeHeap* current;

 private:
  void Enter(void* block, size_t size) {
    blocks_.emplace(block, size);
    used_ += size;
  }

  const size_t limit_;
  size_t used_ = 0;
  std::unordered_map<void*, size_t> blocks_;
  DecodeHeap* const outer_;
};

thread_local DecodeHeap* DecodeHeap::current = nullptr;

}  // namespace

#define STBI_MALLOC(size) (DecodeHeap::current->Allocate(size))
#define STBI_REALLOC(block, size) (DecodeHeap::current->Reallocate(block, size))
#define STBI_FREE(block) (DecodeHeap::current->Free(block))
// A broken invariant inside the decoder is one more kind of undecodable picture.
#define STBI_ASSERT(condition) \
  ((condition) ? void() : throw std::runtime_error("the decoder's check failed: " #condition))
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_LINEAR
#include <stb/stb_image.h>

namespace shutterline::engine {
namespace {

constexpr uint64_t kMebibyte = uint64_t{1} << 20;

struct Header {
  int width = 0, height = 0;
  bool deep = false;  ///< 16 bits a channel.
};

absl::StatusOr<Header> ReadHeader(const uint8_t* data, int size, bool png) {
  DecodeHeap heap(16 * kMebibyte);
  Header header;
  int channels = 0;
  if (stbi_info_from_memory(data, size, &header.width, &header.height, &channels) == 0 || header.width <= 0 ||
      header.height <= 0) {
    const char* reason = stbi_failure_reason();
    return absl::InvalidArgumentError(absl::StrCat("its ", png ? "PNG" : "JPEG", " header cannot be read",
                                                   reason == nullptr ? "" : ": ",
                                                   reason == nullptr ? "" : reason));
  }
  header.deep = png && stbi_is_16_bit_from_memory(data, size) != 0;
  return header;
}

/// No encoder packs more pixels into a byte: deflate reaches 1032:1 at one bit a pixel, and a JPEG block
/// of 64 pixels takes a bit at least.
uint64_t MostPixels(uint64_t bytes, bool png) {
  return 4096 + bytes * (png ? 1032 * 8 : 64 * 8);
}

}  // namespace

absl::StatusOr<TextureImage> DecodeGltfImage(absl::string_view bytes, uint32_t max_side, GltfBudget* pixels) {
  const bool png = absl::StartsWith(bytes, "\x89PNG\r\n\x1a\n");
  if (!png && !absl::StartsWith(bytes, "\xFF\xD8\xFF")) {
    return absl::InvalidArgumentError("it is neither PNG nor JPEG data");
  }
  if (!png) SL_RETURN_IF_ERROR(CheckJpegHuffmanTables(bytes));
  if (bytes.size() > INT_MAX) return absl::ResourceExhaustedError("it has more than 2^31 - 1 bytes");
  const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
  const int size = int(bytes.size());
  try {
    SL_ASSIGN_OR_RETURN(Header header, ReadHeader(data, size, png));
    if (uint32_t(header.width) > max_side || uint32_t(header.height) > max_side) {
      return absl::ResourceExhaustedError(absl::StrCat(
          header.width, " × ", header.height, " pixels, more than the limit of ", max_side, " a side"));
    }
    const uint64_t count = uint64_t(header.width) * uint64_t(header.height);
    if (count > MostPixels(bytes.size(), png)) {
      return absl::InvalidArgumentError(absl::StrCat("its ", bytes.size(), " bytes cannot hold ",
                                                     header.width, " × ", header.height, " pixels"));
    }
    SL_RETURN_IF_ERROR(
        pixels->Take(header.deep ? 2 * count : count,
                     absl::StrCat(header.width, " × ", header.height, header.deep ? " deep" : "")));

    // 16-bit RGBA three times over, or a progressive JPEG's coefficients beside its planes.
    DecodeHeap heap(16 * kMebibyte + 4 * bytes.size() + 32 * count);
    TextureImage image;
    int channels = 0;
    const uint8_t* rgba = nullptr;
    const uint16_t* rgba16 = nullptr;
    if (header.deep) {
      rgba16 = stbi_load_16_from_memory(data, size, &header.width, &header.height, &channels, 4);
    } else {
      rgba = stbi_load_from_memory(data, size, &header.width, &header.height, &channels, 4);
    }
    if (rgba == nullptr && rgba16 == nullptr) {
      const char* reason = stbi_failure_reason();
      return absl::InvalidArgumentError(
          absl::StrCat("it cannot be decoded: ", reason == nullptr ? "no reason given" : reason));
    }
    if (uint64_t(header.width) * uint64_t(header.height) != count) {
      return absl::InvalidArgumentError("its header and its data disagree about its size");
    }
    image.width = header.width;
    image.height = header.height;
    if (rgba16 != nullptr) {
      image.rgba16.assign(rgba16, rgba16 + 4 * count);
    } else {
      image.rgba.assign(rgba, rgba + 4 * count);
    }
    return image;
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("it cannot be decoded: ", error.what()));
  }
}

}  // namespace shutterline::engine
