#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfFramesPerSecond.h>
#include <ImfHeader.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <ImfTiledOutputFile.h>
#include <absl/strings/str_cat.h>
#include <half.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <set>
#include <vector>

#include "common/base/atomic_file.h"
#include "common/base/status_macros.h"
#include "common/image/exr.h"
#include "common/image/exr_stream.h"
#include "common/job/tile.h"

namespace shutterline {
namespace {

Imf::Compression LibraryCompression(ExrCompression compression) {
  switch (compression) {
    case ExrCompression::kNone:
      return Imf::NO_COMPRESSION;
    case ExrCompression::kZip:
      return Imf::ZIP_COMPRESSION;
    case ExrCompression::kPiz:
      return Imf::PIZ_COMPRESSION;
    case ExrCompression::kDwaa:
      return Imf::DWAA_COMPRESSION;
  }
  return Imf::ZIP_COMPRESSION;
}

half HalfOf(float value) {
  if (std::isfinite(value)) value = std::clamp(value, -float(HALF_MAX), float(HALF_MAX));
  return half(value);
}

absl::Status CheckImage(const Image& image) {
  if (image.width() < 1 || image.height() < 1 || image.width() > kMaxFrameSide ||
      image.height() > kMaxFrameSide) {
    return absl::InvalidArgumentError(absl::StrCat("an image of ", image.width(), " × ", image.height(),
                                                   " pixels; each side must be 1 to ", kMaxFrameSide));
  }
  std::set<std::string> names;
  for (const std::string& name : image.channels()) {
    if (name.empty() || name.size() > 255 || name.find('\0') != std::string::npos) {
      return absl::InvalidArgumentError("a channel's name must be 1 to 255 bytes without NUL");
    }
    if (!names.insert(name).second) {
      return absl::InvalidArgumentError(absl::StrCat("two channels are named '", name, "'"));
    }
  }
  return names.empty() ? absl::InvalidArgumentError("an image without channels") : absl::OkStatus();
}

/// Throws what the library throws for names that it reserves.
absl::Status PutMetadata(const ExrMetadata& metadata, Imf::Header& header) {
  header.pixelAspectRatio() = metadata.pixel_aspect_ratio;
  if (metadata.frames_per_second) {
    const FrameRate rate = *metadata.frames_per_second;
    if (rate.numerator < 1 || rate.denominator < 1) {
      return absl::InvalidArgumentError(
          absl::StrCat("framesPerSecond is ", rate.numerator, "/", rate.denominator, ", must be positive"));
    }
    Imf::addFramesPerSecond(header, Imf::Rational(rate.numerator, rate.denominator));
  }
  if (!metadata.capture_date.empty()) Imf::addCapDate(header, metadata.capture_date);
  if (metadata.world_to_camera) Imf::addWorldToCamera(header, Imath::M44f(*metadata.world_to_camera));
  if (metadata.world_to_ndc) Imf::addWorldToNDC(header, Imath::M44f(*metadata.world_to_ndc));
  for (const auto& [name, value] : metadata.strings) {
    if (name.empty() || name.size() > 255 || name.find('\0') != std::string::npos) {
      return absl::InvalidArgumentError("an attribute's name must be 1 to 255 bytes without NUL");
    }
    if (header.find(name) != header.end()) {
      return absl::InvalidArgumentError(absl::StrCat("attribute '", name, "' is already set"));
    }
    header.insert(name, Imf::StringAttribute(value));
  }
  return absl::OkStatus();
}

/// A channel as the file holds it, pixel-interleaved with the others.
struct StoredChannel {
  Imf::PixelType type;
  size_t offset;  ///< Within a pixel, bytes.

  size_t size() const { return type == Imf::HALF ? sizeof(half) : sizeof(float); }
  /// The channel of so many pixels, whose values are `step` apart.
  void Store(const float* values, size_t step, size_t count, char* pixels, size_t pixel_bytes) const {
    char* to = pixels + offset;
    if (type == Imf::HALF) {
      for (size_t i = 0; i < count; ++i, values += step, to += pixel_bytes) {
        const half rounded = HalfOf(*values);
        std::memcpy(to, &rounded, sizeof rounded);
      }
      return;
    }
    for (size_t i = 0; i < count; ++i, values += step, to += pixel_bytes) {
      std::memcpy(to, values, sizeof *values);
    }
  }
};

std::vector<StoredChannel> StoredChannelsOf(const Image& image, PixelType type,
                                            std::span<const std::string> exact) {
  std::vector<StoredChannel> stored;
  size_t offset = 0;
  for (const std::string& name : image.channels()) {
    const bool full = type == PixelType::kFloat || std::find(exact.begin(), exact.end(), name) != exact.end();
    stored.push_back({full ? Imf::FLOAT : Imf::HALF, offset});
    offset += stored.back().size();
  }
  return stored;
}

/// Tiles are handed to the library a row at a time, so only one row is held in the file's pixel types.
/// However many threads compress, the library writes what they give in the order of tiles: their bytes are
/// always the same.
void WriteTiles(const Image& image, const std::vector<StoredChannel>& stored, Imf::TiledOutputFile& file) {
  const size_t width = size_t(image.width());
  const size_t pixel_bytes = stored.back().offset + stored.back().size();
  std::vector<char> rows(width * size_t(kTileSize) * pixel_bytes);
  for (int row = 0; row < file.numYTiles(0); ++row) {
    const int top = row * kTileSize;
    const size_t count = size_t(std::min(kTileSize, image.height() - top)) * width;
    const float* source = image.At(0, top);
    for (size_t c = 0; c < stored.size(); ++c) {
      stored[c].Store(source + c, stored.size(), count, rows.data(), pixel_bytes);
    }
    Imf::FrameBuffer frame;
    for (size_t c = 0; c < stored.size(); ++c) {
      frame.insert(image.channels()[c],
                   Imf::Slice::Make(stored[c].type, &rows[stored[c].offset], Imath::V2i(0, top),
                                    image.width(), kTileSize, pixel_bytes, width * pixel_bytes));
    }
    file.setFrameBuffer(frame);
    file.writeTiles(0, file.numXTiles(0) - 1, row, row);
  }
}

}  // namespace

FrameRate FrameRateOf(double fps) {
  const Imf::Rational rate = Imf::guessExactFps(fps);
  return {rate.n, rate.d};
}

void SetExrThreads(int threads) {
  Imf::setGlobalThreadCount(std::max(threads, 0));
}

absl::StatusOr<std::string> EncodeExr(const Image& image, const OutputSettings& output,
                                      const ExrMetadata& metadata, std::span<const std::string> exact) {
  SL_RETURN_IF_ERROR(Annotate(CheckImage(image), "encode EXR"));
  try {
    Imf::Header header(image.width(), image.height());
    const std::vector<StoredChannel> stored = StoredChannelsOf(image, output.pixel_type, exact);
    for (size_t c = 0; c < stored.size(); ++c) {
      header.channels().insert(image.channels()[c], Imf::Channel(stored[c].type));
    }
    header.compression() = LibraryCompression(output.compression);
    header.lineOrder() = Imf::INCREASING_Y;
    header.setTileDescription(Imf::TileDescription(kTileSize, kTileSize, Imf::ONE_LEVEL));
    SL_RETURN_IF_ERROR(Annotate(PutMetadata(metadata, header), "encode EXR"));

    ExrMemoryOutput stream("memory");
    {
      Imf::TiledOutputFile file(stream, header, Imf::globalThreadCount());
      WriteTiles(image, stored, file);
    }  // The file is complete only once it is closed.
    if (stream.failed()) return absl::ResourceExhaustedError("encode EXR: out of memory");
    return stream.TakeBytes();
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("encode EXR: out of memory");
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("encode EXR: ", error.what()));
  }
}

absl::Status WriteExr(const std::string& path, const Image& image, const OutputSettings& output,
                      const ExrMetadata& metadata) {
  absl::StatusOr<std::string> bytes = EncodeExr(image, output, metadata);
  if (!bytes.ok()) return Annotate(bytes.status(), absl::StrCat("write ", path));
  return WriteFileAtomically(path, *bytes);
}

}  // namespace shutterline
