#include "server/assemble/frame_assembler.h"

#include <absl/functional/function_ref.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/synchronization/mutex.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <exception>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/build_id.h"
#include "common/base/status_macros.h"
#include "common/image/exr.h"
#include "common/image/exr_blocks.h"
#include "common/job/describe_settings.h"
#include "common/job/output_channels.h"
#include "common/job/tile.h"
#include "server/files/file.h"

namespace shutterline::server {
namespace {

static_assert(std::endian::native == std::endian::little, "tiles travel and lie as little-endian floats");

/// Beyond this many tiles, to a thread, another thread is worth its start.
constexpr size_t kTilesForAThread = 8;

/// Calls `work`, which does not throw, with 0 ... count - 1, in no particular order, from as many threads as
/// are of use.
void ForEach(size_t count, absl::FunctionRef<void(size_t)> work) {
  std::atomic<size_t> next = 0;
  const auto loop = [&] {
    for (size_t i = next++; i < count; i = next++) work(i);
  };
  const size_t useful =
      std::min(size_t(std::max(std::thread::hardware_concurrency(), 1u)), count / kTilesForAThread);
  std::vector<std::thread> others;
  try {
    while (others.size() + 1 < useful) others.emplace_back(loop);
  } catch (const std::exception&) {
    // No memory or no more threads: then those that there are do it.
  }
  loop();
  for (std::thread& other : others) other.join();
}

/// Throws where this machine could not hold so much at once. What grows little by little is never refused,
/// but ends the process.
void RequireMemory(size_t bytes) {
  void* volatile memory = ::operator new(bytes);  // Volatile, or compilers leave both out.
  ::operator delete(memory);
}

/// The tiles of a frame, encoded one by one.
class BlockGathering {
 public:
  BlockGathering(const TileJournal& journal, const TileJournal::FrameKey& key, const JobSpec& spec)
      : journal_(journal),
        key_(key),
        grid_{spec.render.width, spec.render.height},
        pixel_bytes_(size_t(OutputChannelCount(spec.render)) * sizeof(float)),
        encoder_(BlockEncoderOf(spec)),
        blocks_(size_t(grid_.Count())) {}

  const ExrBlockEncoder& encoder() const { return encoder_; }
  std::vector<std::string> TakeBlocks() { return std::move(blocks_); }
  /// Tiles that the journal holds no longer soundly, in order.
  const std::vector<uint32_t>& lost() const { return lost_; }

  /// Throws std::bad_alloc where memory does not suffice.
  absl::Status Gather(const std::set<uint32_t>& missing, FrameBlocks::Blocks ready) {
    RequireMemory(size_t(grid_.width) * size_t(grid_.height) * pixel_bytes_);
    std::vector<uint32_t> left;
    for (uint32_t tile = 0; tile < blocks_.size(); ++tile) {
      const auto found = ready.find(tile);
      if (!missing.contains(tile) && found != ready.end() &&
          journal_.Find({key_.first, key_.second, tile}) == found->second.pixels) {
        blocks_[tile] = std::move(found->second.bytes);
      } else {
        left.push_back(tile);
      }
    }
    ready.clear();
    ForEach(left.size(), [&](size_t i) {
      const uint32_t tile = left[i];
      try {
        const absl::Status status = Encode(tile, missing.contains(tile));
        if (status.ok()) return;
        absl::MutexLock lock(&mutex_);
        if (absl::IsDataLoss(status) || absl::IsNotFound(status)) {
          lost_.push_back(tile);
        } else {
          failure_.Update(status);
        }
      } catch (const std::bad_alloc&) {
        out_of_memory_ = true;  // An exception ends the thread's program.
      }
    });
    if (out_of_memory_) throw std::bad_alloc();
    std::sort(lost_.begin(), lost_.end());
    return failure_;
  }

 private:
  /// DATA_LOSS or NOT_FOUND: the journal does not have the tile.
  absl::Status Encode(uint32_t tile, bool is_missing) {
    const TileRect rect = grid_.Rect(int(tile));
    const size_t bytes = size_t(rect.Area()) * pixel_bytes_;
    std::string pixels;
    if (is_missing) {
      pixels.assign(bytes, '\0');
    } else {
      SL_ASSIGN_OR_RETURN(pixels, journal_.Read({key_.first, key_.second, tile}));
      if (pixels.size() != bytes) {
        return absl::DataLossError(absl::StrCat("journal: tile ", tile, " has ", pixels.size(), " bytes"));
      }
    }
    absl::StatusOr<std::string> block = encoder_.Encode(rect.width, rect.height, pixels);
    if (absl::IsResourceExhausted(block.status())) throw std::bad_alloc();
    SL_ASSIGN_OR_RETURN(blocks_[tile], std::move(block));
    return absl::OkStatus();
  }

  const TileJournal& journal_;
  const TileJournal::FrameKey key_;
  const TileGrid grid_;
  const size_t pixel_bytes_;
  const ExrBlockEncoder encoder_;
  std::vector<std::string> blocks_;
  std::atomic<bool> out_of_memory_ = false;
  absl::Mutex mutex_;  ///< Of those that Gather's threads share, until it returns.
  std::vector<uint32_t> lost_;
  absl::Status failure_;
};

absl::StatusOr<AssembledFrame> Assemble(const TileJournal& journal, const TileJournal::FrameKey& key,
                                        const JobSpec& spec, const std::set<uint32_t>& missing,
                                        FrameBlocks::Blocks blocks, const FrameFacts& facts,
                                        const std::string& path, Durability durability) {
  // Before the work, as these may fail.
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
  BlockGathering gathering(journal, key, spec);
  SL_RETURN_IF_ERROR(gathering.Gather(missing, std::move(blocks)));
  AssembledFrame result;
  result.lost_tiles = gathering.lost();
  if (!result.lost_tiles.empty()) return result;

  const absl::StatusOr<std::string> bytes =
      gathering.encoder().Join(spec.render.width, spec.render.height, gathering.TakeBlocks(), metadata);
  // It would not be there at the next attempt either.
  if (absl::IsResourceExhausted(bytes.status())) throw std::bad_alloc();
  SL_RETURN_IF_ERROR(bytes.status());
  SL_RETURN_IF_ERROR(PutFile(path, *bytes, durability));
  result.digest = Sha256(*bytes);
  result.size = bytes->size();
  return result;
}

}  // namespace

absl::StatusOr<AssembledFrame> AssembleFrame(const TileJournal& journal, const TileJournal::FrameKey& key,
                                             const JobSpec& spec, const std::set<uint32_t>& missing,
                                             FrameBlocks::Blocks blocks, const FrameFacts& facts,
                                             const std::string& path, Durability durability) {
  try {
    return Assemble(journal, key, spec, missing, std::move(blocks), facts, path, durability);
  } catch (const std::bad_alloc&) {
    // A frame may be larger than this machine's memory: that job fails, the coordinator lives.
    return absl::FailedPreconditionError(absl::StrCat(
        "assemble ", path, ": out of memory for ", spec.render.width, " x ", spec.render.height, " pixels"));
  }
}

}  // namespace shutterline::server
