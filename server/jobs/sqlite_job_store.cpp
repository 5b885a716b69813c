#include "server/jobs/sqlite_job_store.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>
#include <sqlite3.h>

#include <algorithm>
#include <iterator>
#include <limits>

#include "common/base/ids.h"
#include "common/base/status_macros.h"
#include "proto/convert/job_spec.h"
#include "proto/convert/render_stats.h"
#include "server/jobs/schema.h"
#include "server/jobs/sqlite.h"
#include "server/jobs/upgrade_spec.h"

namespace shutterline::server {
namespace {

constexpr const char kJobColumns[] =
    "SELECT key, id, request_id, spec, state, error, submitted_us, ended_us, priority, user, after_ids, "
    "paused "
    "FROM jobs ";

/// What a store holds was validated when it came in, perhaps under larger limits.
constexpr JobLimits kNoLimits{std::numeric_limits<int64_t>::max(), std::numeric_limits<int64_t>::max(),
                              std::numeric_limits<int64_t>::max(), std::numeric_limits<int64_t>::max()};

absl::StatusOr<JobRecord> ReadJob(SqliteStatement& row) {
  JobRecord job;
  job.key = uint64_t(row.ColumnInt(0));
  job.id = row.ColumnBytes(1);
  job.request_id = row.ColumnBytes(2);
  v1::JobSpec spec;
  if (!spec.ParseFromString(row.ColumnBytes(3))) {
    return absl::DataLossError(absl::StrCat("job store: job ", job.id, ": its specification cannot be read"));
  }
  UpgradeSpec(spec);
  absl::StatusOr<JobSpec> translated = convert::FromProto(spec, kNoLimits);
  if (!translated.ok()) {
    return absl::DataLossError(absl::StrCat("job store: job ", job.id, ": ", translated.status().message()));
  }
  job.spec = *std::move(translated);
  const int64_t state = row.ColumnInt(4);
  if (state < int64_t(JobState::kQueued) || state > int64_t(JobState::kPartial)) {
    return absl::DataLossError(absl::StrCat("job store: job ", job.id, ": state ", state, " is not known"));
  }
  job.state = JobState(state);
  job.error = row.ColumnBytes(5);
  job.submitted = absl::FromUnixMicros(row.ColumnInt(6));
  if (!row.ColumnIsNull(7)) job.ended = absl::FromUnixMicros(row.ColumnInt(7));
  job.wishes.priority = int(row.ColumnInt(8));
  job.wishes.user = row.ColumnBytes(9);
  job.wishes.after = absl::StrSplit(row.ColumnBytes(10), ',', absl::SkipEmpty());
  job.paused = row.ColumnInt(11) != 0;
  return job;
}

/// A frame is worth more than what is known of its making: statistics that cannot be read are left out.
RenderStats ReadStats(const std::string& bytes) {
  v1::RenderStats message;
  if (!message.ParseFromString(bytes)) return {};
  return convert::FromProto(message, "stats").value_or(RenderStats());
}

absl::StatusOr<std::vector<JobRecord>> ReadJobs(SqliteStatement& rows) {
  std::vector<JobRecord> jobs;
  while (rows.Step()) {
    SL_ASSIGN_OR_RETURN(JobRecord job, ReadJob(rows));
    jobs.push_back(std::move(job));
  }
  SL_RETURN_IF_ERROR(rows.status());
  return jobs;
}

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteJobStore>> SqliteJobStore::Open(const std::string& path,
                                                                     Durability durability) {
  sqlite3* database = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &database,
                                   SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
  std::unique_ptr<SqliteJobStore> store(new SqliteJobStore(database));
  absl::MutexLock lock(&store->mutex_);
  if (code != SQLITE_OK) return SqliteError(database, absl::StrCat("open ", path));
  // The exclusive lock is taken by the first write and kept.
  SL_RETURN_IF_ERROR(store->Execute("PRAGMA locking_mode = EXCLUSIVE"));
  // How durable comes first: the switch to WAL writes.
  absl::Status locked = store->Execute(durability == Durability::kPower ? "PRAGMA synchronous = FULL"
                                                                        : "PRAGMA synchronous = OFF");
  if (locked.ok()) locked = store->Execute("PRAGMA journal_mode = WAL");
  if (absl::IsFailedPrecondition(locked)) {
    return absl::FailedPreconditionError(absl::StrCat(path, ": another coordinator uses it"));
  }
  SL_RETURN_IF_ERROR(Annotate(locked, path));
  SL_RETURN_IF_ERROR(store->Execute("PRAGMA foreign_keys = ON"));
  SL_RETURN_IF_ERROR(Annotate(store->Migrate(), path));
  return store;
}

SqliteJobStore::~SqliteJobStore() {
  absl::MutexLock lock(&mutex_);
  sqlite3_close_v2(database_);
}

absl::Status SqliteJobStore::Execute(const char* sql) {
  if (sqlite3_exec(database_, sql, nullptr, nullptr, nullptr) == SQLITE_OK) return absl::OkStatus();
  return SqliteError(database_, absl::string_view(sql).substr(0, 60));
}

absl::Status SqliteJobStore::Migrate() {
  int64_t version = 0;
  {
    SqliteStatement statement(database_, "PRAGMA user_version");
    if (statement.Step()) version = statement.ColumnInt(0);
    SL_RETURN_IF_ERROR(statement.status());
  }
  if (version < 0 || version > int64_t(std::size(kMigrations))) {
    return absl::FailedPreconditionError(absl::StrCat("job store: has schema version ", version,
                                                      ", but this build knows only up to ",
                                                      std::size(kMigrations)));
  }
  for (; version < int64_t(std::size(kMigrations)); ++version) {
    const std::string script = absl::StrCat("BEGIN EXCLUSIVE;", kMigrations[version],
                                            "PRAGMA user_version = ", version + 1, "; COMMIT;");
    const absl::Status status = Execute(script.c_str());
    if (!status.ok()) {
      // Where BEGIN itself failed there is nothing to roll back, and `status` says more than this would.
      (void)Execute("ROLLBACK");
      return Annotate(status, absl::StrCat("migration ", version + 1));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<uint64_t> SqliteJobStore::NextEpoch() {
  absl::MutexLock lock(&mutex_);
  SqliteStatement statement(database_,
                            "UPDATE counters SET value = value + 1 WHERE name = 'epoch' RETURNING value");
  const bool found = statement.Step();
  const uint64_t epoch = found ? uint64_t(statement.ColumnInt(0)) : 0;
  SL_RETURN_IF_ERROR(statement.Run());
  if (!found) return absl::DataLossError("job store: the epoch counter is missing");
  return epoch;
}

absl::StatusOr<JobRecord> SqliteJobStore::FindOne(absl::string_view column, absl::string_view value) {
  SqliteStatement statement(database_, absl::StrCat(kJobColumns, "WHERE ", column, " = ?"));
  if (!statement.Text(value).Step()) {
    SL_RETURN_IF_ERROR(statement.status());
    return absl::NotFoundError("there is no such job");
  }
  return ReadJob(statement);
}

absl::StatusOr<JobStore::Created> SqliteJobStore::Create(const std::string& request_id, const JobSpec& spec,
                                                         const JobWishes& wishes, absl::Time now) {
  absl::MutexLock lock(&mutex_);
  absl::StatusOr<JobRecord> before = FindOne("request_id", request_id);
  if (before.ok()) return Created{*std::move(before), false};
  if (!absl::IsNotFound(before.status())) return before.status();

  JobRecord job;
  job.id = MakeUuid();
  job.request_id = request_id;
  job.spec = spec;
  job.wishes = wishes;
  job.submitted = absl::FromUnixMicros(absl::ToUnixMicros(now));
  SqliteStatement statement(database_,
                            "INSERT INTO jobs (id, request_id, spec, state, error, submitted_us, priority, "
                            "user, after_ids) VALUES (?, ?, ?, ?, '', ?, ?, ?, ?)");
  SL_RETURN_IF_ERROR(statement.Text(job.id)
                         .Text(request_id)
                         .Blob(convert::ToProto(spec).SerializeAsString())
                         .Int(int64_t(job.state))
                         .Int(absl::ToUnixMicros(now))
                         .Int(wishes.priority)
                         .Text(wishes.user)
                         .Text(absl::StrJoin(wishes.after, ","))
                         .Run());
  job.key = uint64_t(sqlite3_last_insert_rowid(database_));
  return Created{std::move(job), true};
}

absl::StatusOr<JobRecord> SqliteJobStore::Get(absl::string_view id) {
  absl::MutexLock lock(&mutex_);
  return FindOne("id", id);
}

absl::StatusOr<JobRecord> SqliteJobStore::FindRequest(absl::string_view request_id) {
  absl::MutexLock lock(&mutex_);
  return FindOne("request_id", request_id);
}

absl::StatusOr<std::vector<JobRecord>> SqliteJobStore::List(uint64_t before, int limit) {
  absl::MutexLock lock(&mutex_);
  SqliteStatement statement(database_, absl::StrCat(kJobColumns, "WHERE key < ? ORDER BY key DESC LIMIT ?"));
  statement.Int(int64_t(std::min<uint64_t>(before, std::numeric_limits<int64_t>::max()))).Int(limit);
  return ReadJobs(statement);
}

absl::StatusOr<std::vector<JobRecord>> SqliteJobStore::Unfinished() {
  absl::MutexLock lock(&mutex_);
  SqliteStatement statement(database_, absl::StrCat(kJobColumns, "WHERE ended_us IS NULL ORDER BY key"));
  return ReadJobs(statement);
}

absl::Status SqliteJobStore::End(uint64_t key, JobState state, const std::string& error, absl::Time now) {
  absl::MutexLock lock(&mutex_);
  SqliteStatement statement(
      database_, "UPDATE jobs SET state = ?, error = ?, ended_us = ? WHERE key = ? AND ended_us IS NULL");
  return statement.Int(int64_t(state)).Text(error).Int(absl::ToUnixMicros(now)).Int(int64_t(key)).Run();
}

absl::Status SqliteJobStore::SetPaused(uint64_t key, bool paused) {
  absl::MutexLock lock(&mutex_);
  SqliteStatement statement(database_, "UPDATE jobs SET paused = ? WHERE key = ?");
  return statement.Int(paused ? 1 : 0).Int(int64_t(key)).Run();
}

absl::Status SqliteJobStore::SetPriority(uint64_t key, int priority) {
  absl::MutexLock lock(&mutex_);
  SqliteStatement statement(database_, "UPDATE jobs SET priority = ? WHERE key = ?");
  return statement.Int(priority).Int(int64_t(key)).Run();
}

absl::Status SqliteJobStore::Transact(absl::FunctionRef<absl::Status()> work) {
  SL_RETURN_IF_ERROR(Execute("BEGIN IMMEDIATE"));
  absl::Status status = work();
  if (status.ok()) status = Execute("COMMIT");
  if (!status.ok()) (void)Execute("ROLLBACK");  // Where even that fails, `status` says more.
  return status;
}

absl::Status SqliteJobStore::Retry(uint64_t key) {
  absl::MutexLock lock(&mutex_);
  return Transact([&]() ABSL_NO_THREAD_SAFETY_ANALYSIS -> absl::Status {
    for (const char* sql : {"UPDATE jobs SET state = 1, error = '', ended_us = NULL WHERE key = ?",
                            "DELETE FROM finished_frames WHERE job_key = ? AND missing > 0",
                            "DELETE FROM quarantined_tiles WHERE job_key = ?"}) {
      SL_RETURN_IF_ERROR(SqliteStatement(database_, sql).Int(int64_t(key)).Run());
    }
    return absl::OkStatus();
  });
}

absl::Status SqliteJobStore::NoteWorkers(const std::map<std::string, bool>& connected) {
  absl::MutexLock lock(&mutex_);
  return Transact([&]() ABSL_NO_THREAD_SAFETY_ANALYSIS -> absl::Status {
    for (const auto& [uuid, is_connected] : connected) {
      SqliteStatement statement(database_, is_connected ? "INSERT OR IGNORE INTO connected_workers VALUES (?)"
                                                        : "DELETE FROM connected_workers WHERE uuid = ?");
      SL_RETURN_IF_ERROR(statement.Text(uuid).Run());
    }
    return absl::OkStatus();
  });
}

absl::StatusOr<std::vector<std::string>> SqliteJobStore::ConnectedWorkers() {
  absl::MutexLock lock(&mutex_);
  SqliteStatement rows(database_, "SELECT uuid FROM connected_workers");
  std::vector<std::string> uuids;
  while (rows.Step()) uuids.push_back(rows.ColumnBytes(0));
  SL_RETURN_IF_ERROR(rows.status());
  return uuids;
}

absl::Status SqliteJobStore::Quarantine(uint64_t key, const QuarantinedTile& tile) {
  absl::MutexLock lock(&mutex_);
  return Transact([&]() ABSL_NO_THREAD_SAFETY_ANALYSIS -> absl::Status {
    SqliteStatement insert(database_, "INSERT OR REPLACE INTO quarantined_tiles VALUES (?, ?, ?)");
    SL_RETURN_IF_ERROR(insert.Int(int64_t(key)).Int(tile.frame).Int(tile.tile).Run());
    for (const TileTrouble& trouble : tile.evidence) {
      SqliteStatement add(database_, "INSERT INTO tile_troubles VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
      SL_RETURN_IF_ERROR(add.Int(int64_t(key))
                             .Int(tile.frame)
                             .Int(tile.tile)
                             .Text(trouble.worker_uuid)
                             .Text(trouble.worker_name)
                             .Int(trouble.worker_ended ? 1 : 0)
                             .Text(trouble.reason)
                             .Int(absl::ToUnixMicros(trouble.when))
                             .Text(trouble.signal)
                             .Text(trouble.log_tail)
                             .Run());
    }
    return absl::OkStatus();
  });
}

absl::StatusOr<std::vector<QuarantinedTile>> SqliteJobStore::QuarantinedTiles(uint64_t key) {
  absl::MutexLock lock(&mutex_);
  SqliteStatement rows(database_,
                       "SELECT q.frame, q.tile, t.worker_uuid, t.worker_name, t.worker_ended, t.reason, "
                       "t.time_us, t.signal, t.log_tail FROM quarantined_tiles q LEFT JOIN tile_troubles t "
                       "USING (job_key, frame, tile) WHERE job_key = ? ORDER BY q.frame, q.tile, t.rowid");
  rows.Int(int64_t(key));
  std::vector<QuarantinedTile> tiles;
  while (rows.Step()) {
    const int frame = int(rows.ColumnInt(0));
    const auto tile = uint32_t(rows.ColumnInt(1));
    if (tiles.empty() || tiles.back().frame != frame || tiles.back().tile != tile) {
      tiles.push_back({frame, tile, {}});
    }
    if (rows.ColumnIsNull(2)) continue;
    tiles.back().evidence.push_back({rows.ColumnBytes(2),
                                     rows.ColumnBytes(3),
                                     rows.ColumnInt(4) != 0,
                                     rows.ColumnBytes(5),
                                     absl::FromUnixMicros(rows.ColumnInt(6)),
                                     rows.ColumnBytes(7),
                                     rows.ColumnBytes(8),
                                     {}});
  }
  SL_RETURN_IF_ERROR(rows.status());
  return tiles;
}

absl::StatusOr<std::vector<std::pair<uint64_t, int>>> SqliteJobStore::QuarantinedFrames() {
  absl::MutexLock lock(&mutex_);
  SqliteStatement rows(database_, "SELECT DISTINCT job_key, frame FROM quarantined_tiles");
  std::vector<std::pair<uint64_t, int>> frames;
  while (rows.Step()) frames.emplace_back(uint64_t(rows.ColumnInt(0)), int(rows.ColumnInt(1)));
  SL_RETURN_IF_ERROR(rows.status());
  return frames;
}

absl::Status SqliteJobStore::AddFinishedFrame(uint64_t key, const FinishedFrame& frame) {
  absl::MutexLock lock(&mutex_);
  SqliteStatement statement(database_, "INSERT OR REPLACE INTO finished_frames VALUES (?, ?, ?, ?, ?, ?)");
  return statement.Int(int64_t(key))
      .Int(frame.frame)
      .Blob({reinterpret_cast<const char*>(frame.digest.bytes.data()), frame.digest.bytes.size()})
      .Int(int64_t(frame.size))
      .Blob(convert::ToProto(frame.stats).SerializeAsString())
      .Int(frame.missing)
      .Run();
}

absl::Status SqliteJobStore::RemoveFinishedFrame(uint64_t key, int frame) {
  absl::MutexLock lock(&mutex_);
  SqliteStatement statement(database_, "DELETE FROM finished_frames WHERE job_key = ? AND frame = ?");
  return statement.Int(int64_t(key)).Int(frame).Run();
}

absl::StatusOr<std::vector<FinishedFrame>> SqliteJobStore::FinishedFrames(uint64_t key) {
  absl::MutexLock lock(&mutex_);
  SqliteStatement statement(database_,
                            "SELECT frame, digest, size_bytes, stats, missing FROM finished_frames WHERE "
                            "job_key = ? ORDER BY frame");
  statement.Int(int64_t(key));
  std::vector<FinishedFrame> frames;
  while (statement.Step()) {
    FinishedFrame frame;
    frame.frame = int(statement.ColumnInt(0));
    const std::string digest = statement.ColumnBytes(1);
    if (digest.size() != frame.digest.bytes.size()) {
      return absl::DataLossError(absl::StrCat("job store: frame ", frame.frame, ": its digest is damaged"));
    }
    std::copy(digest.begin(), digest.end(), reinterpret_cast<char*>(frame.digest.bytes.data()));
    frame.size = uint64_t(statement.ColumnInt(2));
    if (!statement.ColumnIsNull(3)) frame.stats = ReadStats(statement.ColumnBytes(3));
    frame.missing = int(statement.ColumnInt(4));
    frames.push_back(frame);
  }
  SL_RETURN_IF_ERROR(statement.status());
  return frames;
}

}  // namespace shutterline::server
