#include "server/assemble/frame_blocks.h"

#include <iterator>
#include <utility>
#include <vector>

#include "common/job/output_channels.h"
#include "common/job/tile.h"

namespace shutterline::server {

ExrBlockEncoder BlockEncoderOf(const JobSpec& spec) {
  std::vector<std::string> names, exact;
  for (OutputChannel& channel : OutputChannelsOf(spec.render)) {
    if (channel.exact) exact.push_back(channel.name);
    names.push_back(std::move(channel.name));
  }
  return ExrBlockEncoder(std::move(names), spec.output, std::move(exact));
}

FrameBlocks::FrameBlocks(const Options& options) : options_(options) {
  if (options_.max_block_bytes > 0) thread_ = std::thread([this] { Work(); });
}

FrameBlocks::~FrameBlocks() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
    waiting_.clear();
  }
  if (thread_.joinable()) thread_.join();
}

void FrameBlocks::Add(const FrameKey& key, const JobSpec& spec, uint32_t tile, const Digest& digest,
                      std::string pixels) {
  // Where nothing is compressed a block saves no work and takes memory all the same.
  if (spec.output.compression == ExrCompression::kNone) return;
  absl::MutexLock lock(&mutex_);
  if (block_bytes_ >= options_.max_block_bytes) return;
  if (pixels.size() > options_.max_waiting_bytes - waiting_bytes_) return;
  std::shared_ptr<Frame>& frame = frames_[key];
  if (frame == nullptr) frame = std::make_shared<Frame>(spec);
  waiting_bytes_ += pixels.size();
  waiting_.push_back({key, frame, tile, digest, std::move(pixels)});
}

FrameBlocks::Blocks FrameBlocks::Take(const FrameKey& key) {
  absl::MutexLock lock(&mutex_);
  const auto found = frames_.find(key);
  if (found == frames_.end()) return {};
  const std::shared_ptr<Frame> frame = found->second;
  Erase(found, std::next(found));
  return std::move(frame->blocks);
}

void FrameBlocks::DropJob(uint64_t job) {
  absl::MutexLock lock(&mutex_);
  Erase(frames_.lower_bound({job, 0}), frames_.lower_bound({job + 1, 0}));
}

void FrameBlocks::Erase(std::map<FrameKey, std::shared_ptr<Frame>>::iterator first,
                        std::map<FrameKey, std::shared_ptr<Frame>>::iterator last) {
  if (first == last) return;
  for (auto frame = first; frame != last; ++frame) {
    for (const auto& [tile, block] : frame->second->blocks) block_bytes_ -= block.bytes.size();
  }
  frames_.erase(first, last);
  std::erase_if(waiting_, [this](const Task& task) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (frames_.contains(task.key)) return false;
    waiting_bytes_ -= task.pixels.size();
    return true;
  });
}

void FrameBlocks::Keep(const Task& task, std::string block) {
  const auto found = frames_.find(task.key);
  // Taken meanwhile, and perhaps begun anew.
  if (found == frames_.end() || found->second != task.frame) return;
  Block& place = task.frame->blocks[task.tile];
  block_bytes_ -= place.bytes.size();
  if (block.size() > options_.max_block_bytes - block_bytes_) {
    task.frame->blocks.erase(task.tile);
    return;
  }
  block_bytes_ += block.size();
  place = {task.digest, std::move(block)};
}

void FrameBlocks::Work() {
  const auto any = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return stopping_ || !waiting_.empty(); };
  while (true) {
    Task task;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(&any));
      if (stopping_) return;
      task = std::move(waiting_.front());
      waiting_.pop_front();
      working_ = true;
    }
    const TileRect rect = TileGrid{task.frame->render.width, task.frame->render.height}.Rect(int(task.tile));
    absl::StatusOr<std::string> block = task.frame->encoder.Encode(rect.width, rect.height, task.pixels);
    absl::MutexLock lock(&mutex_);
    working_ = false;
    waiting_bytes_ -= task.pixels.size();
    // What cannot be encoded says so when the frame is put together.
    if (block.ok()) Keep(task, *std::move(block));
  }
}

void FrameBlocks::WaitUntilIdle() {
  const auto idle = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return !working_ && waiting_.empty(); };
  absl::MutexLock lock(&mutex_, absl::Condition(&idle));
}

FrameBlocks::Totals FrameBlocks::totals() const {
  absl::MutexLock lock(&mutex_);
  return {block_bytes_, waiting_bytes_, frames_.size()};
}

}  // namespace shutterline::server
