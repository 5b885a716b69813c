#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfVersion.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>
#include <vector>

#include "common/base/status_macros.h"
#include "common/image/exr.h"
#include "common/image/exr_stream.h"

namespace shutterline {
namespace {

/// The library's own bound, for what it allocates before we see the header. Process-wide, set once.
void BoundLibraryOnce() {
  [[maybe_unused]] static const bool done = [] {
    Imf::Header::setMaxImageSize(kMaxFrameSide, kMaxFrameSide);
    Imf::Header::setMaxTileSize(kMaxFrameSide, kMaxFrameSide);
    return true;
  }();
}

/// Sizes in 64 bits: a window's corners may be anywhere in the range of int.
struct Window {
  int64_t x = 0, y = 0, width = 0, height = 0;

  explicit Window(const Imath::Box2i& box)
      : x(box.min.x),
        y(box.min.y),
        width(int64_t{box.max.x} - box.min.x + 1),
        height(int64_t{box.max.y} - box.min.y + 1) {}
  friend bool operator==(const Window&, const Window&) = default;
};

absl::Status CheckWindow(const Window& window, absl::string_view what, size_t channels,
                         const ExrLimits& limits) {
  if (window.width < 1 || window.height < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("the ", what, " is empty (", window.width, " × ", window.height, " pixels)"));
  }
  if (window.width > limits.max_side || window.height > limits.max_side ||
      uint64_t(window.width) * uint64_t(window.height) * channels > limits.max_values) {
    return absl::ResourceExhaustedError(absl::StrCat("the ", what, " of ", window.width, " × ", window.height,
                                                     " pixels with ", channels,
                                                     " channels exceeds the limit of ", limits.max_side,
                                                     " pixels a side and ", limits.max_values, " values"));
  }
  return absl::OkStatus();
}

/// R, G, B, A first, then the file's order.
absl::StatusOr<std::vector<std::string>> ChannelNames(const Imf::Header& header, const ExrLimits& limits) {
  const Imf::ChannelList& list = header.channels();
  std::vector<std::string> names;
  const std::array<const char*, 4> colour = {"R", "G", "B", "A"};
  for (const char* name : colour) {
    if (list.findChannel(name) != nullptr) names.emplace_back(name);
  }
  for (auto channel = list.begin(); channel != list.end(); ++channel) {
    const std::string name = channel.name();
    if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) {
      return absl::InvalidArgumentError(
          absl::StrCat("channel '", name, "' is subsampled (", channel.channel().xSampling, " × ",
                       channel.channel().ySampling, "), which is not supported"));
    }
    const bool is_colour =
        std::any_of(colour.begin(), colour.end(), [&](const char* c) { return name == c; });
    if (!is_colour) names.push_back(name);
    if (names.size() > size_t(limits.max_channels)) {
      return absl::ResourceExhaustedError(absl::StrCat("more than ", limits.max_channels, " channels"));
    }
  }
  if (names.empty()) return absl::InvalidArgumentError("no channels");
  return names;
}

void GetMetadata(const Imf::Header& header, ExrMetadata& metadata) {
  metadata = {};
  metadata.pixel_aspect_ratio = header.pixelAspectRatio();
  if (Imf::hasFramesPerSecond(header)) {
    const Imf::Rational rate = Imf::framesPerSecond(header);
    metadata.frames_per_second = FrameRate{rate.n, rate.d};
  }
  if (Imf::hasCapDate(header)) metadata.capture_date = Imf::capDate(header);
  if (Imf::hasWorldToCamera(header)) metadata.world_to_camera = M44d(Imf::worldToCamera(header));
  if (Imf::hasWorldToNDC(header)) metadata.world_to_ndc = M44d(Imf::worldToNDC(header));
  for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
    const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute.attribute());
    const std::string name = attribute.name();
    if (text != nullptr && name != "capDate" && name != "type") metadata.strings[name] = text->value();
  }
}

/// The pixels of `data` that lie in `display`, at their place there.
Image Crop(const Image& source, const Window& data, const Window& display) {
  Image result(int(display.width), int(display.height), source.channels());
  const int64_t x0 = std::max(data.x, display.x);
  const int64_t x1 = std::min(data.x + data.width, display.x + display.width);
  const int64_t y0 = std::max(data.y, display.y);
  const int64_t y1 = std::min(data.y + data.height, display.y + display.height);
  if (x0 >= x1) return result;
  for (int64_t y = y0; y < y1; ++y) {
    const float* row = source.At(int(x0 - data.x), int(y - data.y));
    std::copy(row, row + (x1 - x0) * source.channel_count(),
              result.At(int(x0 - display.x), int(y - display.y)));
  }
  return result;
}

absl::StatusOr<Image> Decode(absl::string_view bytes, const std::string& name, ExrMetadata* metadata,
                             const ExrLimits& limits) {
  BoundLibraryOnce();
  ExrMemoryInput stream(bytes, name.c_str());
  Imf::MultiPartInputFile file(stream, /*numThreads=*/0);
  const Imf::Header& header = file.header(0);
  if (Imf::isNonImage(file.version()) || (header.hasType() && Imf::isDeepData(header.type()))) {
    return absl::InvalidArgumentError("the first part holds deep data, which is not supported");
  }
  SL_ASSIGN_OR_RETURN(std::vector<std::string> channels, ChannelNames(header, limits));
  const Window data(header.dataWindow()), display(header.displayWindow());
  SL_RETURN_IF_ERROR(CheckWindow(data, "data window", channels.size(), limits));
  SL_RETURN_IF_ERROR(CheckWindow(display, "display window", channels.size(), limits));

  Image image(int(data.width), int(data.height), channels);
  const size_t pixel_bytes = channels.size() * sizeof(float);
  Imf::FrameBuffer frame;
  for (size_t c = 0; c < channels.size(); ++c) {
    frame.insert(channels[c], Imf::Slice::Make(Imf::FLOAT, image.values().data() + c, header.dataWindow(),
                                               pixel_bytes, pixel_bytes * size_t(data.width)));
  }
  Imf::InputPart part(file, 0);
  part.setFrameBuffer(frame);
  part.readPixels(header.dataWindow().min.y, header.dataWindow().max.y);
  if (metadata != nullptr) GetMetadata(header, *metadata);
  if (data == display) return image;
  return Crop(image, data, display);
}

}  // namespace

absl::StatusOr<Image> DecodeExr(absl::string_view bytes, const std::string& name, ExrMetadata* metadata,
                                const ExrLimits& limits) {
  const std::string context = absl::StrCat("read ", name);
  try {
    absl::StatusOr<Image> image = Decode(bytes, name, metadata, limits);
    if (!image.ok()) return Annotate(image.status(), context);
    return image;
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(absl::StrCat(context, ": out of memory"));
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(context, ": not a sound EXR file: ", error.what()));
  }
}

absl::StatusOr<Image> ReadExr(const std::string& path, ExrMetadata* metadata, const ExrLimits& limits) {
  // Asked before it is opened: opening a pipe waits for its other end.
  std::error_code error;
  const auto kind = std::filesystem::status(path, error).type();
  if (kind != std::filesystem::file_type::regular && kind != std::filesystem::file_type::not_found &&
      !error) {
    return absl::InvalidArgumentError(absl::StrCat("read ", path, ": not a regular file"));
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return absl::ErrnoToStatus(errno, absl::StrCat("read ", path, ": cannot open"));
  // A folder opens, but has no end to seek to.
  const std::streamoff size = file.tellg();
  if (size < 0 || size == std::numeric_limits<std::streamoff>::max()) {
    return absl::InvalidArgumentError(absl::StrCat("read ", path, ": not a regular file"));
  }
  if (uint64_t(size) > limits.max_file_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat("read ", path, ": ", size, " bytes exceed the limit of ", limits.max_file_bytes));
  }
  try {
    std::string bytes(size_t(size), '\0');
    file.seekg(0);
    if (size > 0 && !file.read(bytes.data(), size)) {
      return absl::ErrnoToStatus(errno, absl::StrCat("read ", path, ": cannot read"));
    }
    return DecodeExr(bytes, path, metadata, limits);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(absl::StrCat("read ", path, ": out of memory"));
  }
}

}  // namespace shutterline
