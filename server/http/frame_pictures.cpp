#include "server/http/frame_pictures.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>

#include "common/base/status_macros.h"
#include "common/image/exr.h"
#include "common/image/png.h"
#include "common/job/output_channels.h"

namespace shutterline::server {
namespace {

/// Where red, green and blue are among a frame's channels.
absl::StatusOr<std::array<size_t, 3>> ColourIndices(const std::vector<std::string>& names) {
  std::array<size_t, 3> indices{};
  constexpr std::array<const char*, 3> kWanted = {"R", "G", "B"};
  for (size_t c = 0; c < 3; ++c) {
    const auto found = std::find(names.begin(), names.end(), kWanted[c]);
    if (found == names.end())
      return absl::InternalError(absl::StrCat("the frame has no channel ", kWanted[c]));
    indices[c] = size_t(found - names.begin());
  }
  return indices;
}

/// Means of squares of `factor` pixels; those at the right and lower border are cut.
absl::StatusOr<Image> Reduce(const Image& image, int factor) {
  SL_ASSIGN_OR_RETURN(const auto colours, ColourIndices(image.channels()));
  Image small((image.width() + factor - 1) / factor, (image.height() + factor - 1) / factor, {"R", "G", "B"});
  for (int y = 0; y < small.height(); ++y) {
    const int bottom = std::min(image.height(), (y + 1) * factor);
    for (int x = 0; x < small.width(); ++x) {
      const int right = std::min(image.width(), (x + 1) * factor);
      std::array<float, 3> sum{};
      for (int v = y * factor; v < bottom; ++v) {
        for (int u = x * factor; u < right; ++u) {
          for (size_t c = 0; c < 3; ++c) sum[c] += image.At(u, v)[colours[c]];
        }
      }
      const auto count = float((bottom - y * factor) * (right - x * factor));
      for (size_t c = 0; c < 3; ++c) small.At(x, y)[c] = sum[c] / count;
    }
  }
  return small;
}

}  // namespace

absl::StatusOr<FramePictures::Strip> FramePictures::Tiles(const Farm::FrameView& view,
                                                          const std::vector<uint32_t>& tiles) const {
  if (tiles.size() > kMaxTiles) {
    return absl::InvalidArgumentError(
        absl::StrCat("tiles: ", tiles.size(), " are named, but at most ", kMaxTiles, " may be"));
  }
  const RenderSettings& render = view.spec->render;
  const TileGrid grid{render.width, render.height};
  std::vector<std::string> names;
  for (const OutputChannel& channel : OutputChannelsOf(render)) names.push_back(channel.name);
  SL_ASSIGN_OR_RETURN(const auto colours, ColourIndices(names));

  Strip strip;
  std::vector<std::string> found;
  for (const uint32_t tile : tiles) {
    if (tile >= uint32_t(grid.Count()))
      return absl::InvalidArgumentError(absl::StrCat("tiles: the frame has no tile ", tile));
    absl::StatusOr<std::string> pixels = journal_.Read({view.key.first, view.key.second, tile});
    // Not there, or not any more: the frame may have been finished meanwhile.
    if (!pixels.ok() || pixels->size() != size_t(grid.Rect(int(tile)).Area()) * names.size() * sizeof(float))
      continue;
    strip.tiles.push_back(tile);
    found.push_back(*std::move(pixels));
  }
  if (found.empty()) return absl::NotFoundError("none of these tiles is kept");
  Image image(kTileSize, kTileSize * int(found.size()), {"R", "G", "B"});
  for (size_t i = 0; i < found.size(); ++i) {
    const TileRect rect = grid.Rect(int(strip.tiles[i]));
    for (int y = 0; y < rect.height; ++y) {
      for (int x = 0; x < rect.width; ++x) {
        const size_t pixel = (size_t(y) * size_t(rect.width) + size_t(x)) * names.size();
        for (size_t c = 0; c < 3; ++c) {
          std::memcpy(&image.At(x, int(i) * kTileSize + y)[c],
                      found[i].data() + (pixel + colours[c]) * sizeof(float), sizeof(float));
        }
      }
    }
  }
  SL_ASSIGN_OR_RETURN(strip.png, EncodePng(image));
  return strip;
}

absl::StatusOr<std::string> FramePictures::Finished(const Farm::FrameView& view, int side) {
  const RenderSettings& render = view.spec->render;
  if (int64_t{render.width} * render.height > kMaxPixels) {
    return absl::ResourceExhaustedError(absl::StrCat("a frame of ", render.width, " x ", render.height,
                                                     " pixels is too large to be shown; fetch its file"));
  }
  const int longest = std::max(render.width, render.height);
  const int factor = (longest + side - 1) / side;
  absl::MutexLock lock(&one_at_a_time_);
  try {
    SL_ASSIGN_OR_RETURN(const Image image, ReadExr(view.path));
    SL_ASSIGN_OR_RETURN(const Image small, Reduce(image, factor));
    return EncodePng(small);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("out of memory for the frame");
  }
}

}  // namespace shutterline::server
