#include "common/image/exr_blocks.h"

#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfTiledOutputFile.h>
#include <absl/strings/str_cat.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include "common/base/check.h"
#include "common/base/status_macros.h"
#include "common/image/exr_layout.h"
#include "common/image/exr_stream.h"
#include "common/job/tile.h"

namespace shutterline {
namespace {

static_assert(std::endian::native == std::endian::little, "EXR's numbers are little-endian");

/// Before a block's bytes lie the tile's column and row, its level in both directions and its length, each an
/// int32.
constexpr size_t kBlockHeadBytes = 20;
/// After the file's header, a uint64 a tile says where its block begins.
constexpr size_t kPlaceBytes = sizeof(uint64_t);

template <typename Number>
void PutNumber(Number number, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace

ExrBlockEncoder::ExrBlockEncoder(std::vector<std::string> channels, const OutputSettings& output,
                                 std::vector<std::string> exact)
    : channels_(std::move(channels)),
      exact_(std::move(exact)),
      output_(output),
      names_(Annotate(CheckChannelNames(channels_), "encode EXR")) {}

absl::StatusOr<std::string> ExrBlockEncoder::Encode(int width, int height, absl::string_view pixels) const {
  if (!names_.ok()) return names_;
  const bool fits = width >= 1 && height >= 1 && width <= kTileSize && height <= kTileSize &&
                    pixels.size() == size_t(width) * size_t(height) * channels_.size() * sizeof(float);
  if (!fits) {
    return absl::InvalidArgumentError(
        absl::StrCat("encode EXR: ", pixels.size(), " bytes for a tile of ", width, " × ", height));
  }
  return EncodeGuarded([&]() -> absl::StatusOr<std::string> {
    // A block is the same wherever its tile lies: let the library write a picture of this tile alone.
    const std::vector<StoredChannel> stored = StoredChannelsOf(channels_, output_.pixel_type, exact_);
    const size_t pixel_bytes = PixelBytesOf(stored);
    std::vector<char> values(size_t(width) * size_t(height) * pixel_bytes);
    Imf::FrameBuffer frame;
    for (size_t c = 0; c < stored.size(); ++c) {
      stored[c].Store(pixels.data() + c * sizeof(float), stored.size() * sizeof(float),
                      size_t(width) * size_t(height), values.data(), pixel_bytes);
      frame.insert(stored[c].name,
                   Imf::Slice::Make(stored[c].type, &values[stored[c].offset], Imath::V2i(0, 0), width,
                                    height, pixel_bytes, size_t(width) * pixel_bytes));
    }
    ExrMemoryOutput stream("memory");
    size_t begin = 0;
    {
      Imf::TiledOutputFile file(stream, TiledHeader(width, height, stored, output_.compression), 0);
      begin = size_t(stream.tellp()) + kBlockHeadBytes;
      file.setFrameBuffer(frame);
      file.writeTile(0, 0);
    }  // The file is complete only once it is closed.
    if (stream.failed()) return absl::ResourceExhaustedError("encode EXR: out of memory");
    const std::string bytes = stream.TakeBytes();
    SL_CHECK(bytes.size() >= begin);
    int32_t length = 0;
    std::memcpy(&length, &bytes[begin - sizeof length], sizeof length);
    SL_CHECK(length >= 0 && size_t(length) == bytes.size() - begin);
    return bytes.substr(begin);
  });
}

absl::StatusOr<std::string> ExrBlockEncoder::Join(int width, int height, std::vector<std::string> blocks,
                                                  const ExrMetadata& metadata) const {
  SL_RETURN_IF_ERROR(Annotate(CheckImageSize(width, height), "encode EXR"));
  if (!names_.ok()) return names_;
  const TileGrid grid{width, height};
  if (blocks.size() != size_t(grid.Count())) {
    return absl::InvalidArgumentError(
        absl::StrCat("encode EXR: ", blocks.size(), " blocks for ", grid.Count(), " tiles"));
  }
  return EncodeGuarded([&]() -> absl::StatusOr<std::string> {
    Imf::Header header = TiledHeader(width, height, StoredChannelsOf(channels_, output_.pixel_type, exact_),
                                     output_.compression);
    SL_RETURN_IF_ERROR(Annotate(PutMetadata(metadata, header), "encode EXR"));
    ExrMemoryOutput stream("memory");
    // Without a tile: header and an empty table of places.
    { const Imf::TiledOutputFile file(stream, header, 0); }
    if (stream.failed()) return absl::ResourceExhaustedError("encode EXR: out of memory");
    std::string bytes = stream.TakeBytes();
    const size_t head = bytes.size();
    SL_CHECK(head > blocks.size() * kPlaceBytes);
    size_t total = head;
    for (const std::string& block : blocks) total += kBlockHeadBytes + block.size();
    bytes.reserve(total);
    for (size_t tile = 0; tile < blocks.size(); ++tile) {
      const uint64_t place = bytes.size();
      std::memcpy(&bytes[head - (blocks.size() - tile) * kPlaceBytes], &place, sizeof place);
      PutNumber(int32_t(tile % size_t(grid.Columns())), bytes);
      PutNumber(int32_t(tile / size_t(grid.Columns())), bytes);
      PutNumber(int32_t{0}, bytes);
      PutNumber(int32_t{0}, bytes);
      PutNumber(int32_t(blocks[tile].size()), bytes);
      bytes += blocks[tile];
      std::string().swap(blocks[tile]);
    }
    return bytes;
  });
}

}  // namespace shutterline
