#include "common/image/exr_layout.h"

#include <ImfChannelList.h>
#include <ImfFramesPerSecond.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

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

}  // namespace

void StoredChannel::Store(const char* values, size_t step, size_t count, char* pixels,
                          size_t pixel_bytes) const {
  char* to = pixels + offset;
  if (type == Imf::HALF) {
    for (size_t i = 0; i < count; ++i, values += step, to += pixel_bytes) {
      float value;
      std::memcpy(&value, values, sizeof value);
      const half rounded = HalfOf(value);
      std::memcpy(to, &rounded, sizeof rounded);
    }
    return;
  }
  for (size_t i = 0; i < count; ++i, values += step, to += pixel_bytes) {
    std::memcpy(to, values, sizeof(float));
  }
}

std::vector<StoredChannel> StoredChannelsOf(std::span<const std::string> channels, PixelType type,
                                            std::span<const std::string> exact) {
  std::vector<StoredChannel> stored;
  size_t offset = 0;
  for (const std::string& name : channels) {
    const bool full = type == PixelType::kFloat || std::find(exact.begin(), exact.end(), name) != exact.end();
    stored.push_back({name, full ? Imf::FLOAT : Imf::HALF, offset});
    offset += stored.back().size();
  }
  return stored;
}

size_t PixelBytesOf(const std::vector<StoredChannel>& stored) {
  return stored.back().offset + stored.back().size();
}

absl::Status CheckImageSize(int width, int height) {
  if (width >= 1 && height >= 1 && width <= kMaxFrameSide && height <= kMaxFrameSide) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("an image of ", width, " × ", height, " pixels; each side must be 1 to ", kMaxFrameSide));
}

absl::Status CheckChannelNames(std::span<const std::string> channels) {
  std::set<std::string> names;
  for (const std::string& name : channels) {
    if (name.empty() || name.size() > 255 || name.find('\0') != std::string::npos) {
      return absl::InvalidArgumentError("a channel's name must be 1 to 255 bytes without NUL");
    }
    if (!names.insert(name).second) {
      return absl::InvalidArgumentError(absl::StrCat("two channels are named '", name, "'"));
    }
  }
  return names.empty() ? absl::InvalidArgumentError("an image without channels") : absl::OkStatus();
}

Imf::Header TiledHeader(int width, int height, const std::vector<StoredChannel>& stored,
                        ExrCompression compression) {
  Imf::Header header(width, height);
  for (const StoredChannel& channel : stored) {
    header.channels().insert(channel.name, Imf::Channel(channel.type));
  }
  header.compression() = LibraryCompression(compression);
  header.lineOrder() = Imf::INCREASING_Y;
  header.setTileDescription(Imf::TileDescription(kTileSize, kTileSize, Imf::ONE_LEVEL));
  return header;
}

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

}  // namespace shutterline
