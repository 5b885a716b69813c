// The part of SqliteJobStore that removes jobs.
#include <absl/strings/str_cat.h>
#include <sqlite3.h>

#include "common/base/status_macros.h"
#include "server/jobs/sqlite.h"
#include "server/jobs/sqlite_job_store.h"

namespace shutterline::server {
namespace {

constexpr const char kRemovedColumns[] = "SELECT key, id, state, removed_us FROM removed_jobs ";

RemovedJob ReadRemoved(SqliteStatement& row) {
  return {uint64_t(row.ColumnInt(0)), row.ColumnBytes(1), JobState(row.ColumnInt(2)),
          absl::FromUnixMicros(row.ColumnInt(3))};
}

}  // namespace

absl::StatusOr<std::vector<EndedJob>> SqliteJobStore::Ended(const EndedJob& after, int limit) {
  absl::MutexLock lock(&mutex_);
  SqliteStatement rows(database_,
                       "SELECT key, id, ended_us FROM jobs WHERE ended_us IS NOT NULL AND "
                       "(ended_us, key) > (?, ?) ORDER BY ended_us, key LIMIT ?");
  rows.Int(absl::ToUnixMicros(after.ended)).Int(int64_t(after.key)).Int(limit);
  std::vector<EndedJob> jobs;
  while (rows.Step()) {
    jobs.push_back(
        {uint64_t(rows.ColumnInt(0)), rows.ColumnBytes(1), absl::FromUnixMicros(rows.ColumnInt(2))});
  }
  SL_RETURN_IF_ERROR(rows.status());
  return jobs;
}

absl::StatusOr<int64_t> SqliteJobStore::CountEnded() {
  absl::MutexLock lock(&mutex_);
  SqliteStatement row(database_, "SELECT count(*) FROM jobs WHERE ended_us IS NOT NULL");
  const int64_t count = row.Step() ? row.ColumnInt(0) : 0;
  SL_RETURN_IF_ERROR(row.status());
  return count;
}

absl::Status SqliteJobStore::Remove(uint64_t key, absl::Time now) {
  absl::MutexLock lock(&mutex_);
  return Transact([&]() ABSL_NO_THREAD_SAFETY_ANALYSIS -> absl::Status {
    SqliteStatement remember(database_,
                             "INSERT INTO removed_jobs SELECT id, request_id, key, state, ?, 1 FROM jobs "
                             "WHERE key = ? AND ended_us IS NOT NULL");
    SL_RETURN_IF_ERROR(remember.Int(absl::ToUnixMicros(now)).Int(int64_t(key)).Run());
    if (sqlite3_changes(database_) == 0) {
      return absl::NotFoundError(absl::StrCat("job store: no job ", key, " has ended"));
    }
    for (const char* sql :
         {"DELETE FROM finished_frames WHERE job_key = ?", "DELETE FROM quarantined_tiles WHERE job_key = ?",
          "DELETE FROM jobs WHERE key = ?"}) {
      SL_RETURN_IF_ERROR(SqliteStatement(database_, sql).Int(int64_t(key)).Run());
    }
    return absl::OkStatus();
  });
}

absl::Status SqliteJobStore::FilesRemoved(const std::string& id) {
  absl::MutexLock lock(&mutex_);
  return SqliteStatement(database_, "UPDATE removed_jobs SET files_left = 0 WHERE id = ?").Text(id).Run();
}

absl::StatusOr<std::vector<RemovedJob>> SqliteJobStore::HalfRemoved() {
  absl::MutexLock lock(&mutex_);
  SqliteStatement rows(database_, absl::StrCat(kRemovedColumns, "WHERE files_left = 1 ORDER BY key"));
  std::vector<RemovedJob> jobs;
  while (rows.Step()) jobs.push_back(ReadRemoved(rows));
  SL_RETURN_IF_ERROR(rows.status());
  return jobs;
}

absl::StatusOr<RemovedJob> SqliteJobStore::FindOneRemoved(absl::string_view column, absl::string_view value) {
  absl::MutexLock lock(&mutex_);
  SqliteStatement row(database_, absl::StrCat(kRemovedColumns, "WHERE ", column, " = ?"));
  if (row.Text(value).Step()) return ReadRemoved(row);
  SL_RETURN_IF_ERROR(row.status());
  return absl::NotFoundError("no such job was removed");
}

absl::StatusOr<RemovedJob> SqliteJobStore::FindRemoved(absl::string_view id) {
  return FindOneRemoved("id", id);
}

absl::StatusOr<RemovedJob> SqliteJobStore::FindRemovedRequest(absl::string_view request_id) {
  return FindOneRemoved("request_id", request_id);
}

}  // namespace shutterline::server
