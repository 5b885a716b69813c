#include "worker/supervise/rendering_table.h"

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <new>

namespace shutterline::worker {

struct RenderingTable::Line {
  std::atomic<bool> busy;
  uint32_t tile;
  int frame;
  char job_id[52];  // UUIDs have 36; what is longer is cut, and names no job.
};

absl::StatusOr<std::unique_ptr<RenderingTable>> RenderingTable::Create(size_t threads) {
  void* const memory =
      mmap(nullptr, threads * sizeof(Line), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return absl::ErrnoToStatus(errno, "map the table of what is rendered");
  // Zeros are a table at rest.
  return std::unique_ptr<RenderingTable>(new RenderingTable(static_cast<Line*>(memory), threads));
}

RenderingTable::~RenderingTable() {
  munmap(lines_, threads_ * sizeof(Line));
}

void RenderingTable::Begin(size_t thread, absl::string_view job_id, int frame, uint32_t tile) {
  if (thread >= threads_) return;
  Line& line = lines_[thread];
  line.tile = tile;
  line.frame = frame;
  job_id = job_id.substr(0, sizeof line.job_id - 1);
  *std::copy(job_id.begin(), job_id.end(), line.job_id) = '\0';
  line.busy.store(true, std::memory_order_release);
}

void RenderingTable::End(size_t thread) {
  if (thread < threads_) lines_[thread].busy.store(false, std::memory_order_release);
}

std::vector<TileAtHand> RenderingTable::Take() {
  std::vector<TileAtHand> tiles;
  for (size_t i = 0; i < threads_; ++i) {
    Line& line = lines_[i];
    if (!line.busy.exchange(false, std::memory_order_acquire)) continue;
    TileAtHand tile{line.job_id, line.frame, line.tile};
    if (std::find(tiles.begin(), tiles.end(), tile) == tiles.end()) tiles.push_back(std::move(tile));
  }
  return tiles;
}

}  // namespace shutterline::worker
