#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/functional/function_ref.h>
#include <absl/synchronization/mutex.h>

#include <memory>

#include "server/files/durability.h"
#include "server/jobs/job_store.h"

struct sqlite3;

namespace shutterline::server {

/// JobStore in one SQLite file (WAL; synchronous=FULL: a commit is on the disk when it returns, or OFF where
/// only the process may die). The file is locked for as long as the store lives, so that only one coordinator
/// uses it.
class SqliteJobStore final : public JobStore {
 public:
  /// Opens or makes the file and brings its schema up to date. FAILED_PRECONDITION where another process
  /// uses it, or it was made by a later version; DATA_LOSS where it is damaged.
  static absl::StatusOr<std::unique_ptr<SqliteJobStore>> Open(const std::string& path,
                                                              Durability durability = Durability::kPower);
  ~SqliteJobStore() override;

  absl::StatusOr<uint64_t> NextEpoch() override;
  absl::StatusOr<Created> Create(const std::string& request_id, const JobSpec& spec, const JobWishes& wishes,
                                 absl::Time now) override;
  absl::StatusOr<JobRecord> Get(absl::string_view id) override;
  absl::StatusOr<JobRecord> FindRequest(absl::string_view request_id) override;
  absl::StatusOr<std::vector<JobRecord>> List(uint64_t before, int limit) override;
  absl::StatusOr<std::vector<JobRecord>> Unfinished() override;
  absl::Status End(uint64_t key, JobState state, const std::string& error, absl::Time now) override;
  absl::Status SetPaused(uint64_t key, bool paused) override;
  absl::Status SetPriority(uint64_t key, int priority) override;
  absl::Status Retry(uint64_t key) override;
  absl::StatusOr<std::vector<EndedJob>> Ended(const EndedJob& after, int limit) override;
  absl::StatusOr<int64_t> CountEnded() override;
  absl::Status Remove(uint64_t key, absl::Time now) override;
  absl::Status FilesRemoved(const std::string& id) override;
  absl::StatusOr<std::vector<RemovedJob>> HalfRemoved() override;
  absl::StatusOr<RemovedJob> FindRemoved(absl::string_view id) override;
  absl::StatusOr<RemovedJob> FindRemovedRequest(absl::string_view request_id) override;
  absl::Status NoteWorkers(const std::map<std::string, bool>& connected) override;
  absl::StatusOr<std::vector<std::string>> ConnectedWorkers() override;
  absl::Status Quarantine(uint64_t key, const QuarantinedTile& tile) override;
  absl::StatusOr<std::vector<QuarantinedTile>> QuarantinedTiles(uint64_t key) override;
  absl::StatusOr<std::vector<std::pair<uint64_t, int>>> QuarantinedFrames() override;
  absl::Status AddFinishedFrame(uint64_t key, const FinishedFrame& frame) override;
  absl::Status RemoveFinishedFrame(uint64_t key, int frame) override;
  absl::StatusOr<std::vector<FinishedFrame>> FinishedFrames(uint64_t key) override;

 private:
  explicit SqliteJobStore(sqlite3* database) : database_(database) {}
  absl::Status Migrate() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status Execute(const char* sql) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Runs the statements of `work` all or none.
  absl::Status Transact(absl::FunctionRef<absl::Status()> work) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<JobRecord> FindOne(absl::string_view column, absl::string_view value)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<RemovedJob> FindOneRemoved(absl::string_view column, absl::string_view value)
      ABSL_LOCKS_EXCLUDED(mutex_);

  absl::Mutex mutex_;
  sqlite3* const database_ ABSL_PT_GUARDED_BY(mutex_);
};

}  // namespace shutterline::server
