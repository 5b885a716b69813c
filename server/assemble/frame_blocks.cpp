#include "server/assemble/frame_blocks.h"

#include <algorithm>
#include <new>
#include <utility>
#include <vector>

#include "common/job/output_channels.h"
#include "common/job/tile.h"

namespace shutterline::server {
namespace {

/// What an entry takes beside its bytes, about: places in tables, and of a frame names and settings.
constexpr uint64_t kBlockCost = 200, kFrameCost = 2000;

}  // namespace

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
  if (pixels.size() > options_.max_waiting_bytes - waiting_bytes_) return;
  const uint64_t room = options_.max_block_bytes - block_bytes_;
  const auto known = frames_.find(key);
  if (room <= (known == frames_.end() ? kFrameCost + kBlockCost : kBlockCost)) return;
  std::shared_ptr<Frame> frame = known == frames_.end() ? std::make_shared<Frame>(spec) : known->second;
  if (known == frames_.end()) {
    frames_[key] = frame;
    block_bytes_ += kFrameCost;
  }
  waiting_bytes_ += pixels.size();
  waiting_.push_back({key, std::move(frame), tile, digest, std::move(pixels)});
}

FrameBlocks::Blocks FrameBlocks::Take(const FrameKey& key) {
  const Erased erased = Erase(key, {key.first, key.second + 1});
  if (erased.frames.empty()) return {};
  // The thread may still be at one of its tiles, and keeps nothing then: the frame is not there any more.
  return std::move(erased.frames.front()->blocks);
}

void FrameBlocks::DropJob(uint64_t job) {
  Erase({job, 0}, {job + 1, 0});
}

FrameBlocks::Erased FrameBlocks::Erase(const FrameKey& from, const FrameKey& to) {
  // Freed by the caller, without the lock: blocks may be a million.
  Erased erased;
  absl::MutexLock lock(&mutex_);
  const auto first = frames_.lower_bound(from), last = frames_.lower_bound(to);
  if (first == last) return erased;
  for (auto frame = first; frame != last; ++frame) {
    block_bytes_ -= frame->second->bytes + kFrameCost;
    erased.frames.push_back(std::move(frame->second));
  }
  frames_.erase(first, last);
  const auto gone = std::stable_partition(waiting_.begin(), waiting_.end(), [&](const Task& task) {
    return task.key < from || !(task.key < to);
  });
  for (auto task = gone; task != waiting_.end(); ++task) {
    waiting_bytes_ -= task->pixels.size();
    erased.tasks.push_back(std::move(*task));
  }
  waiting_.erase(gone, waiting_.end());
  return erased;
}

void FrameBlocks::Keep(const Task& task, std::string block) {
  const auto found = frames_.find(task.key);
  // Taken meanwhile, and perhaps begun anew.
  if (found == frames_.end() || found->second != task.frame) return;
  Frame& frame = *task.frame;
  const auto known = frame.blocks.find(task.tile);
  if (known != frame.blocks.end()) {  // It has been lost meanwhile, and rendered again.
    const uint64_t cost = known->second.bytes.size() + kBlockCost;
    frame.bytes -= cost;
    block_bytes_ -= cost;
    frame.blocks.erase(known);
  }
  const uint64_t cost = block.size() + kBlockCost;
  if (cost > options_.max_block_bytes - block_bytes_) return;
  frame.blocks.emplace(task.tile, Block{task.digest, std::move(block)});
  frame.bytes += cost;
  block_bytes_ += cost;
}

absl::StatusOr<std::string> FrameBlocks::Encode(const Task& task) {
  try {
    const TileRect rect = TileGrid{task.frame->render.width, task.frame->render.height}.Rect(int(task.tile));
    return task.frame->encoder.Encode(rect.width, rect.height, task.pixels);
  } catch (const std::bad_alloc&) {
    return absl::Status(absl::StatusCode::kResourceExhausted, "");
  }
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
    absl::StatusOr<std::string> block = Encode(task);
    absl::MutexLock lock(&mutex_);
    working_ = false;
    waiting_bytes_ -= task.pixels.size();
    if (!block.ok()) continue;  // What cannot be encoded says so when the frame is put together.
    try {
      Keep(task, *std::move(block));
    } catch (const std::bad_alloc&) {  // It is only a cache.
    }
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
