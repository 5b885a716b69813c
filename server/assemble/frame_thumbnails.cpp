#include "server/assemble/frame_thumbnails.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstring>
#include <new>

#include "common/base/status_macros.h"
#include "common/image/exr.h"
#include "common/job/output_channels.h"

namespace shutterline::server {
namespace {

constexpr int kColours = 4;  ///< R, G, B, A: the first channels of tiles and of images that were read.

/// [first, last) of part `part` of `parts` of `size` pixels; never empty.
struct Part {
  int first, last;
};
Part PartOf(int size, int part, int parts) {
  const int first = size * part / parts;
  return {first, std::max(first + 1, size * (part + 1) / parts)};
}

/// `pixel(x, y)` points to the floats of a pixel of the tile.
template <typename Pixel>
std::vector<float> Reduce(int width, int height, int side, Pixel pixel) {
  std::vector<float> means;
  means.reserve(size_t(side) * size_t(side) * kColours);
  for (int v = 0; v < side; ++v) {
    const Part rows = PartOf(height, v, side);
    for (int u = 0; u < side; ++u) {
      const Part columns = PartOf(width, u, side);
      double sum[kColours] = {};
      for (int y = rows.first; y < rows.last; ++y) {
        for (int x = columns.first; x < columns.last; ++x) {
          const float* const from = pixel(x, y);
          for (int c = 0; c < kColours; ++c) sum[c] += double(from[c]);
        }
      }
      const double count = double(rows.last - rows.first) * double(columns.last - columns.first);
      for (const double colour : sum) means.push_back(float(colour / count));
    }
  }
  return means;
}

}  // namespace

absl::StatusOr<std::vector<FrameThumbnails::Tile>> FrameThumbnails::Unfinished(
    const JobSpec& spec, const TileJournal::FrameKey& frame, const std::vector<bool>& known, int side) const {
  const TileGrid grid{spec.render.width, spec.render.height};
  const size_t channels = size_t(OutputChannelCount(spec.render));
  std::vector<Tile> tiles;
  for (const uint32_t index : journal_.Tiles(frame)) {
    if (index >= known.size() || known[index]) continue;
    const absl::StatusOr<std::string> bytes = journal_.Read({frame.first, frame.second, index});
    const TileRect rect = grid.Rect(int(index));
    // Not there any more, for the frame has been finished meanwhile; or damaged, and rendered again soon.
    if (!bytes.ok() || bytes->size() != size_t(rect.Area()) * channels * sizeof(float)) continue;
    std::vector<float> pixels(bytes->size() / sizeof(float));
    std::memcpy(pixels.data(), bytes->data(), bytes->size());
    tiles.push_back({index, Reduce(rect.width, rect.height, side, [&](int x, int y) {
                       return &pixels[(size_t(y) * size_t(rect.width) + size_t(x)) * channels];
                     })});
  }
  return tiles;
}

absl::StatusOr<std::vector<FrameThumbnails::Tile>> FrameThumbnails::Finished(const JobSpec& spec,
                                                                             const std::string& path,
                                                                             const std::vector<bool>& known,
                                                                             int side) {
  std::vector<Tile> tiles;
  if (std::find(known.begin(), known.end(), false) == known.end()) return tiles;
  const TileGrid grid{spec.render.width, spec.render.height};
  if (int64_t{grid.width} * grid.height > kMaxPixels) {
    return absl::ResourceExhaustedError(absl::StrCat("a finished frame of ", grid.width, " x ", grid.height,
                                                     " pixels is too large to be shown; fetch its file"));
  }
  absl::MutexLock lock(&one_at_a_time_);
  try {
    SL_ASSIGN_OR_RETURN(const Image image, ReadExr(path));
    if (image.width() != grid.width || image.height() != grid.height || image.channel_count() < kColours) {
      return absl::DataLossError(absl::StrCat(path, ": is not the frame that was written"));
    }
    for (uint32_t index = 0; index < known.size(); ++index) {
      if (known[index]) continue;
      const TileRect rect = grid.Rect(int(index));
      tiles.push_back({index, Reduce(rect.width, rect.height, side,
                                     [&](int x, int y) { return image.At(rect.x + x, rect.y + y); })});
    }
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(absl::StrCat("out of memory for ", path));
  }
  return tiles;
}

}  // namespace shutterline::server
