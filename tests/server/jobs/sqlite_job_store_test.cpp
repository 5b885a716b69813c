#include "server/jobs/sqlite_job_store.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace shutterline::server {
namespace {

class SqliteJobStoreTest : public testing::Test {
 protected:
  void Reopen() {
    store_.reset();
    auto store = SqliteJobStore::Open(path_);
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }
  void SetUp() override { Reopen(); }

  static JobSpec Spec(int frames) {
    JobSpec spec;
    spec.name = "näme";
    spec.scene.root_name = "a.glb";
    spec.scene.files = {{"a.glb", Sha256("a"), 1}};
    spec.frames = {1, frames, 1};
    spec.render.time_samples = 9;
    spec.render.seed = 0xffffffffffffffffull;
    return spec;
  }

  test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() + "/jobs.sqlite";
  const absl::Time now_ = absl::FromUnixMicros(1'700'000'000'123'456);
  std::unique_ptr<SqliteJobStore> store_;
};

TEST_F(SqliteJobStoreTest, EpochGrowsWithEveryStart) {
  EXPECT_EQ(store_->NextEpoch().value(), 1u);
  Reopen();
  EXPECT_EQ(store_->NextEpoch().value(), 2u);
}

TEST_F(SqliteJobStoreTest, JobIsReadBackAsItWasWrittenAfterAReopen) {
  const JobStore::Created created = store_->Create("request", Spec(3), {}, now_).value();
  EXPECT_TRUE(created.is_new);
  Reopen();
  const JobRecord job = store_->Get(created.job.id).value();
  EXPECT_EQ(job.spec, Spec(3));
  EXPECT_EQ(job.submitted, now_);
  EXPECT_EQ(job.state, JobState::kQueued);
  EXPECT_EQ(job.ended, absl::InfinitePast());
  EXPECT_EQ(store_->FindRequest("request")->id, job.id);
  EXPECT_TRUE(absl::IsNotFound(store_->FindRequest("request2").status()));
  EXPECT_TRUE(absl::IsNotFound(store_->Get("' OR 1=1 --").status()));
}

TEST_F(SqliteJobStoreTest, SameRequestIsTheSameJob) {
  const JobStore::Created first = store_->Create("request", Spec(3), {}, now_).value();
  const JobStore::Created second = store_->Create("request", Spec(4), {}, now_).value();
  EXPECT_FALSE(second.is_new);
  EXPECT_EQ(second.job.id, first.job.id);
  EXPECT_EQ(second.job.spec, Spec(3));
}

TEST_F(SqliteJobStoreTest, ARemovedJobLeavesANoteAlone) {
  const JobRecord a = store_->Create("a", Spec(3), {}, now_)->job,
                  b = store_->Create("b", Spec(3), {}, now_)->job;
  EXPECT_TRUE(absl::IsNotFound(store_->Remove(a.key, now_))) << "it has not ended";
  ASSERT_TRUE(store_->AddFinishedFrame(a.key, {1, Sha256("exr"), 77, {}}).ok());
  ASSERT_TRUE(store_->Quarantine(a.key, {2, 0, {{"uuid", "name", true, "why", now_}}}).ok());
  ASSERT_TRUE(store_->End(a.key, JobState::kPartial, "", now_).ok());
  ASSERT_TRUE(store_->Remove(a.key, now_ + absl::Seconds(5)).ok());
  EXPECT_TRUE(absl::IsNotFound(store_->Remove(a.key, now_)));
  Reopen();
  EXPECT_TRUE(absl::IsNotFound(store_->Get(a.id).status()));
  EXPECT_TRUE(absl::IsNotFound(store_->FindRequest("a").status()));
  EXPECT_TRUE(store_->FinishedFrames(a.key)->empty());
  EXPECT_TRUE(store_->QuarantinedTiles(a.key)->empty());
  ASSERT_EQ(store_->HalfRemoved()->size(), 1u);
  EXPECT_EQ(store_->HalfRemoved()->front().key, a.key);
  for (const RemovedJob& removed : {*store_->FindRemoved(a.id), *store_->FindRemovedRequest("a")}) {
    EXPECT_EQ(removed.id, a.id);
    EXPECT_EQ(removed.state, JobState::kPartial);
    EXPECT_EQ(removed.removed, now_ + absl::Seconds(5));
  }
  ASSERT_TRUE(store_->FilesRemoved(a.id).ok());
  EXPECT_TRUE(store_->HalfRemoved()->empty());
  EXPECT_TRUE(store_->FindRemoved(a.id).ok());
  EXPECT_TRUE(absl::IsNotFound(store_->FindRemoved(b.id).status()));
  // Its number is not used again.
  EXPECT_EQ(store_->Create("c", Spec(1), {}, now_)->job.key, b.key + 1);
}

TEST_F(SqliteJobStoreTest, EndedJobsComeLongestEndedFirst) {
  std::vector<JobRecord> jobs;
  for (const char* request : {"a", "b", "c", "d", "e"})
    jobs.push_back(store_->Create(request, Spec(1), {}, now_)->job);
  for (const auto& [job, seconds] : {std::pair{3, 1}, {0, 2}, {1, 2}, {4, 3}}) {
    ASSERT_TRUE(
        store_->End(jobs[size_t(job)].key, JobState::kFailed, "", now_ + absl::Seconds(seconds)).ok());
  }
  EXPECT_EQ(store_->CountEnded().value(), 4);
  std::vector<std::string> ids;
  EndedJob last;
  for (std::vector<EndedJob> page; !(page = store_->Ended(last, 2).value()).empty(); last = page.back()) {
    for (const EndedJob& job : page) ids.push_back(job.id);
  }
  EXPECT_EQ(ids, (std::vector<std::string>{jobs[3].id, jobs[0].id, jobs[1].id, jobs[4].id}));
  EXPECT_EQ(last.ended, now_ + absl::Seconds(3));
}

TEST_F(SqliteJobStoreTest, EndIsForEverAndFramesAreKept) {
  const JobRecord a = store_->Create("a", Spec(1), {}, now_)->job;
  const JobRecord b = store_->Create("b", Spec(1), {}, now_)->job;
  RenderStats stats;
  stats.tiles = 12;
  stats.cull_seconds = 0.5;
  ASSERT_TRUE(store_->AddFinishedFrame(a.key, {1, Sha256("exr"), 77, stats}).ok());
  ASSERT_TRUE(store_->End(a.key, JobState::kFailed, "why", now_).ok());
  ASSERT_TRUE(store_->End(a.key, JobState::kSucceeded, "", now_).ok());
  Reopen();
  EXPECT_EQ(store_->Get(a.id)->state, JobState::kFailed);
  EXPECT_EQ(store_->Get(a.id)->error, "why");
  EXPECT_EQ(store_->Get(a.id)->ended, now_);
  const std::vector<FinishedFrame> frames = store_->FinishedFrames(a.key).value();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].digest, Sha256("exr"));
  EXPECT_EQ(frames[0].stats, stats);
  const std::vector<JobRecord> unfinished = store_->Unfinished().value();
  ASSERT_EQ(unfinished.size(), 1u);
  EXPECT_EQ(unfinished[0].id, b.id);
  ASSERT_TRUE(store_->RemoveFinishedFrame(a.key, 1).ok());
  EXPECT_TRUE(store_->FinishedFrames(a.key)->empty());
}

TEST_F(SqliteJobStoreTest, WishesPausesAndPrioritiesAreKept) {
  const JobRecord first = store_->Create("a", Spec(1), {}, now_)->job;
  const JobRecord made = store_->Create("b", Spec(1), {-7, "ann ä", {first.id, "other"}}, now_)->job;
  ASSERT_TRUE(store_->SetPaused(made.key, true).ok());
  Reopen();
  const JobRecord job = store_->Get(made.id).value();
  EXPECT_EQ(job.wishes.priority, -7);
  EXPECT_EQ(job.wishes.user, "ann ä");
  EXPECT_EQ(job.wishes.after, (std::vector<std::string>{first.id, "other"}));
  EXPECT_TRUE(job.paused);
  EXPECT_FALSE(store_->Get(first.id)->paused);
  EXPECT_TRUE(store_->Get(first.id)->wishes.after.empty());
  ASSERT_TRUE(store_->SetPriority(made.key, 9).ok());
  ASSERT_TRUE(store_->SetPaused(made.key, false).ok());
  EXPECT_EQ(store_->Get(made.id)->wishes.priority, 9);
  EXPECT_FALSE(store_->Get(made.id)->paused);
}

TEST_F(SqliteJobStoreTest, QuarantinedTilesKeepTheirEvidenceUntilARetry) {
  const JobRecord job = store_->Create("a", Spec(3), {}, now_)->job;
  const JobRecord other = store_->Create("b", Spec(3), {}, now_)->job;
  const TileTrouble trouble{"uuid", "name", true, std::string("why\0not", 7), now_};
  TileTrouble second = trouble;
  second.worker_ended = false;
  TileTrouble third = trouble;
  third.signal = "SIGSEGV";
  third.log_tail = "one\ntwo\n";
  ASSERT_TRUE(store_->Quarantine(job.key, {2, 77, {trouble}}).ok());
  ASSERT_TRUE(store_->Quarantine(job.key, {2, 77, {trouble, second, third}}).ok());  // Replaces.
  ASSERT_TRUE(store_->Quarantine(job.key, {1, 4'000'000'000u, {}}).ok());
  ASSERT_TRUE(store_->Quarantine(other.key, {3, 1, {second}}).ok());
  FinishedFrame partial{2, Sha256("exr"), 77, {}, 1};
  ASSERT_TRUE(store_->AddFinishedFrame(job.key, partial).ok());
  ASSERT_TRUE(store_->AddFinishedFrame(job.key, {3, Sha256("whole"), 7, {}, 0}).ok());
  ASSERT_TRUE(store_->End(job.key, JobState::kPartial, "1 missing", now_).ok());
  Reopen();
  EXPECT_EQ(store_->Get(job.id)->state, JobState::kPartial);
  EXPECT_EQ(store_->FinishedFrames(job.key)->at(0).missing, 1);
  const std::vector<QuarantinedTile> tiles = store_->QuarantinedTiles(job.key).value();
  ASSERT_EQ(tiles.size(), 2u);
  EXPECT_EQ(tiles[0].tile, 4'000'000'000u);
  EXPECT_TRUE(tiles[0].evidence.empty());
  EXPECT_EQ(tiles[1].evidence, (std::vector<TileTrouble>{trouble, second, third}));
  EXPECT_EQ(store_->QuarantinedFrames()->size(), 3u);

  ASSERT_TRUE(store_->Retry(job.key).ok());
  Reopen();
  EXPECT_EQ(store_->Get(job.id)->state, JobState::kQueued);
  EXPECT_EQ(store_->Get(job.id)->error, "");
  EXPECT_EQ(store_->Unfinished()->size(), 2u);
  EXPECT_TRUE(store_->QuarantinedTiles(job.key)->empty());
  EXPECT_EQ(store_->QuarantinedTiles(other.key)->size(), 1u);
  ASSERT_EQ(store_->FinishedFrames(job.key)->size(), 1u);  // The whole one.
  EXPECT_EQ(store_->FinishedFrames(job.key)->at(0).frame, 3);
}

TEST_F(SqliteJobStoreTest, WorkersThatAreConnectedAreKnownAfterAReopen) {
  ASSERT_TRUE(store_->NoteWorkers({{"a", true}, {"b", true}, {"c", true}}).ok());
  ASSERT_TRUE(store_->NoteWorkers({{"b", false}, {"c", true}}).ok());
  Reopen();
  EXPECT_EQ(store_->ConnectedWorkers().value(), (std::vector<std::string>{"a", "c"}));
}

TEST_F(SqliteJobStoreTest, FolderOfOneStoreIsClosedToAnother) {
  EXPECT_TRUE(absl::IsFailedPrecondition(SqliteJobStore::Open(path_).status()));
}

TEST_F(SqliteJobStoreTest, DamagedFileIsDataLoss) {
  store_.reset();
  std::ofstream(path_, std::ios::trunc) << std::string(8192, 'x');
  EXPECT_TRUE(absl::IsDataLoss(SqliteJobStore::Open(path_).status()));
}

}  // namespace
}  // namespace shutterline::server
