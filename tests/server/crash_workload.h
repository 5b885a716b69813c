#pragma once

#include <absl/status/status.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "common/job/job_spec.h"
#include "server/assemble/frame_blocks.h"
#include "server/assemble/tile_journal.h"
#include "server/assets/disk_asset_store.h"
#include "server/control/farm.h"
#include "server/control/work_pool.h"
#include "server/jobs/sqlite_job_store.h"
#include "tests/support/fake_clock.h"

namespace shutterline::test {

/// What a coordinator has acknowledged, in memory that a process shares with the one that started it.
struct Acknowledged {
  std::atomic<bool> blob, job, frame_finished[2], ended, removed;
  std::atomic<bool> tile[2][4];
};

/// A coordinator without threads but one that writes frames, without network and without workers: stores,
/// journal and farm over a folder, driven step by step. One job: a scene of one blob, two frames of four
/// tiles.
class CrashWorkload {
 public:
  CrashWorkload(std::string folder, server::Durability durability);
  ~CrashWorkload();

  /// Opens the folder, as a coordinator starts; again, it is one that starts after another.
  absl::Status Open();
  /// Does all that is not done yet, and notes what has been acknowledged. Stops at the first error; may then
  /// be called again.
  absl::Status Run(Acknowledged& acknowledged);
  /// What of it cannot be found after Open; empty: nothing is missing.
  std::string Missing(const Acknowledged& acknowledged);

  /// The first steps of Run: the blob and the job are there.
  absl::Status Submit(Acknowledged& acknowledged);

  /// Removes the job, which has ended, and waits for its files to go; OK also where it has been removed
  /// before.
  absl::Status Remove(Acknowledged& acknowledged);
  /// What is there of jobs that are not; empty: nothing.
  std::string LeftOver();
  /// Until the thread that writes frames, and removes them, has nothing to do now or within half a minute,
  /// which passes.
  void WaitForFrames();
  /// What a job asks for.
  static JobSpec Spec();
  /// How the next Open runs the coordinator; folder and durability are set there.
  server::Config& config() { return config_; }
  server::Farm& farm() { return *farm_; }
  FakeClock& clock() { return clock_; }

 private:
  absl::Status UploadBlob();
  absl::Status PushTiles(int frame, uint32_t first, uint32_t count, Acknowledged& acknowledged);
  /// The job as the farm has it.
  absl::StatusOr<server::JobSnapshot> FindJob();
  std::string MissingFrame(const std::string& job_id, int frame);

  const std::string folder_;
  const server::Durability durability_;
  server::Config config_;
  FakeClock clock_;
  std::unique_ptr<server::SqliteJobStore> store_;
  std::unique_ptr<server::DiskAssetStore> assets_;
  std::unique_ptr<server::TileJournal> journal_;
  std::unique_ptr<server::Farm> farm_;
  std::unique_ptr<server::FrameBlocks> blocks_;
  std::unique_ptr<server::WorkPool> frames_pool_;
};

}  // namespace shutterline::test
