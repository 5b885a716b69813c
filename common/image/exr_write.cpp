#include <ImfFrameBuffer.h>
#include <ImfFramesPerSecond.h>
#include <ImfHeader.h>
#include <ImfThreading.h>
#include <ImfTiledOutputFile.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <vector>

#include "common/base/atomic_file.h"
#include "common/base/status_macros.h"
#include "common/image/exr.h"
#include "common/image/exr_layout.h"
#include "common/image/exr_stream.h"
#include "common/job/tile.h"

namespace shutterline {
namespace {

/// Tiles are handed to the library a row at a time, so only one row is held in the file's pixel types.
/// However many threads compress, the library writes what they give in the order of tiles: their bytes are
/// always the same.
void WriteTiles(const Image& image, const std::vector<StoredChannel>& stored, Imf::TiledOutputFile& file) {
  const size_t width = size_t(image.width());
  const size_t pixel_bytes = PixelBytesOf(stored);
  std::vector<char> rows(width * size_t(kTileSize) * pixel_bytes);
  for (int row = 0; row < file.numYTiles(0); ++row) {
    const int top = row * kTileSize;
    const size_t count = size_t(std::min(kTileSize, image.height() - top)) * width;
    const float* source = image.At(0, top);
    for (size_t c = 0; c < stored.size(); ++c) {
      stored[c].Store(reinterpret_cast<const char*>(source + c), stored.size() * sizeof(float), count,
                      rows.data(), pixel_bytes);
    }
    Imf::FrameBuffer frame;
    for (const StoredChannel& channel : stored) {
      frame.insert(channel.name,
                   Imf::Slice::Make(channel.type, &rows[channel.offset], Imath::V2i(0, top), image.width(),
                                    kTileSize, pixel_bytes, width * pixel_bytes));
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
  SL_RETURN_IF_ERROR(Annotate(CheckImageSize(image.width(), image.height()), "encode EXR"));
  SL_RETURN_IF_ERROR(Annotate(CheckChannelNames(image.channels()), "encode EXR"));
  return EncodeGuarded([&]() -> absl::StatusOr<std::string> {
    const std::vector<StoredChannel> stored = StoredChannelsOf(image.channels(), output.pixel_type, exact);
    Imf::Header header = TiledHeader(image.width(), image.height(), stored, output.compression);
    SL_RETURN_IF_ERROR(Annotate(PutMetadata(metadata, header), "encode EXR"));

    ExrMemoryOutput stream("memory");
    {
      Imf::TiledOutputFile file(stream, header, Imf::globalThreadCount());
      WriteTiles(image, stored, file);
    }  // The file is complete only once it is closed.
    if (stream.failed()) return absl::ResourceExhaustedError("encode EXR: out of memory");
    return stream.TakeBytes();
  });
}

absl::Status WriteExr(const std::string& path, const Image& image, const OutputSettings& output,
                      const ExrMetadata& metadata) {
  absl::StatusOr<std::string> bytes = EncodeExr(image, output, metadata);
  if (!bytes.ok()) return Annotate(bytes.status(), absl::StrCat("write ", path));
  return WriteFileAtomically(path, *bytes);
}

}  // namespace shutterline
