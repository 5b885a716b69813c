#pragma once

#include <ImfHeader.h>
#include <ImfPixelType.h>
#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <half.h>

#include <cstddef>
#include <exception>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "common/image/exr.h"

namespace shutterline {

/// A channel as an EXR holds it, pixel-interleaved with the others. Internal to common/image.
struct StoredChannel {
  std::string name;
  Imf::PixelType type = Imf::HALF;
  size_t offset = 0;  ///< Within a pixel, bytes.

  size_t size() const { return type == Imf::HALF ? sizeof(half) : sizeof(float); }
  /// The channel of so many pixels: 32-bit floats that are `step` bytes apart, at any address.
  void Store(const char* values, size_t step, size_t count, char* pixels, size_t pixel_bytes) const;
};

/// All in one type, but those that `exact` names, which are 32-bit floats in any case.
std::vector<StoredChannel> StoredChannelsOf(std::span<const std::string> channels, PixelType type,
                                            std::span<const std::string> exact);
/// Bytes of a pixel.
size_t PixelBytesOf(const std::vector<StoredChannel>& stored);

/// OK if channels can be called so.
absl::Status CheckChannelNames(std::span<const std::string> channels);
/// OK if a picture can be as large.
absl::Status CheckImageSize(int width, int height);

/// What is at the head of a tiled EXR of kTileSize × kTileSize tiles, one level, but for the metadata.
Imf::Header TiledHeader(int width, int height, const std::vector<StoredChannel>& stored,
                        ExrCompression compression);

/// What the library throws while it encodes, as a status.
template <typename Work>
auto EncodeGuarded(const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("encode EXR: out of memory");
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("encode EXR: ", error.what()));
  }
}

/// Throws what the library throws for names that it reserves.
absl::Status PutMetadata(const ExrMetadata& metadata, Imf::Header& header);

}  // namespace shutterline
