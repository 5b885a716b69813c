#include "server/assemble/frame_assembler.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <bit>
#include <cstring>
#include <new>
#include <utility>
#include <vector>

#include "common/base/build_id.h"
#include "common/base/status_macros.h"
#include "common/image/exr.h"
#include "common/image/image.h"
#include "common/job/describe_settings.h"
#include "common/job/output_channels.h"
#include "common/job/tile.h"
#include "server/files/file.h"

namespace shutterline::server {
namespace {

static_assert(std::endian::native == std::endian::little, "tiles travel and lie as little-endian floats");

void Paste(absl::string_view pixels, const TileRect& rect, Image& image) {
  const size_t row_bytes = size_t(rect.width) * size_t(image.channel_count()) * sizeof(float);
  for (int y = 0; y < rect.height; ++y) {
    std::memcpy(image.At(rect.x, rect.y + y), pixels.data() + size_t(y) * row_bytes, row_bytes);
  }
}

absl::StatusOr<AssembledFrame> Assemble(const TileJournal& journal, const TileJournal::FrameKey& key,
                                        const JobSpec& spec, const std::set<uint32_t>& missing,
                                        const FrameFacts& facts, const std::string& path,
                                        Durability durability) {
  const TileGrid grid{spec.render.width, spec.render.height};
  std::vector<std::string> names, exact;
  for (OutputChannel& channel : OutputChannelsOf(spec.render)) {
    if (channel.exact) exact.push_back(channel.name);
    names.push_back(std::move(channel.name));
  }
  const size_t pixel_bytes = names.size() * sizeof(float);
  Image image(grid.width, grid.height, std::move(names));
  AssembledFrame result;
  for (int tile = 0; tile < grid.Count(); ++tile) {
    if (missing.contains(uint32_t(tile))) continue;
    const TileRect rect = grid.Rect(tile);
    const absl::StatusOr<std::string> pixels = journal.Read({key.first, key.second, uint32_t(tile)});
    if (!pixels.ok() && !absl::IsDataLoss(pixels.status()) && !absl::IsNotFound(pixels.status()))
      return pixels.status();
    if (!pixels.ok() || pixels->size() != size_t(rect.Area()) * pixel_bytes) {
      result.lost_tiles.push_back(uint32_t(tile));
      continue;
    }
    Paste(*pixels, rect, image);
  }
  if (!result.lost_tiles.empty()) return result;

  ExrMetadata metadata;
  metadata.frames_per_second = FrameRateOf(spec.render.fps);
  if (const absl::StatusOr<CameraMatrices> camera = facts.camera(); camera.ok()) {
    metadata.world_to_camera = camera->world_to_camera;
    metadata.world_to_ndc = camera->world_to_ndc;
  } else if (!absl::IsDeadlineExceeded(camera.status())) {  // A frame without them is better than none.
    return camera.status();
  }
  metadata.strings["shutterline:build"] = kBuildId;
  metadata.strings["shutterline:frame"] = absl::StrCat(spec.frames.Frame(key.second));
  metadata.strings["shutterline:scene"] = spec.scene.root_name;
  metadata.strings["shutterline:settings"] = DescribeSettings(spec.render);
  if (!missing.empty()) metadata.strings["shutterline:missing_tiles"] = absl::StrJoin(missing, ",");
  if (!spec.render.mattes.empty()) {
    SL_ASSIGN_OR_RETURN(const MatteNames matte_names, facts.names());
    for (const Matte matte : spec.render.mattes) {
      AddMatteMetadata(MatteName(matte),
                       matte == Matte::kObject ? matte_names.objects : matte_names.materials,
                       metadata.strings);
    }
  }
  SL_ASSIGN_OR_RETURN(const std::string bytes, EncodeExr(image, spec.output, metadata, exact));
  SL_RETURN_IF_ERROR(PutFile(path, bytes, durability));
  result.digest = Sha256(bytes);
  result.size = bytes.size();
  return result;
}

}  // namespace

absl::StatusOr<AssembledFrame> AssembleFrame(const TileJournal& journal, const TileJournal::FrameKey& key,
                                             const JobSpec& spec, const std::set<uint32_t>& missing,
                                             const FrameFacts& facts, const std::string& path,
                                             Durability durability) {
  try {
    return Assemble(journal, key, spec, missing, facts, path, durability);
  } catch (const std::bad_alloc&) {
    // A frame may be larger than this machine's memory: that job fails, the coordinator lives.
    return absl::FailedPreconditionError(absl::StrCat(
        "assemble ", path, ": out of memory for ", spec.render.width, " x ", spec.render.height, " pixels"));
  }
}

}  // namespace shutterline::server
