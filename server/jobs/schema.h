#pragma once

namespace shutterline::server {

/// Migration i brings a store from version i to i + 1; the version is SQLite's user_version. A released
/// migration is never changed: a new one is appended.
inline constexpr const char* kMigrations[] = {
    R"sql(
      CREATE TABLE counters (
        name  TEXT PRIMARY KEY,
        value INTEGER NOT NULL
      ) STRICT;
      INSERT INTO counters VALUES ('epoch', 0);

      CREATE TABLE jobs (
        key          INTEGER PRIMARY KEY AUTOINCREMENT,  -- Grows; never reused.
        id           TEXT NOT NULL UNIQUE,
        request_id   TEXT NOT NULL UNIQUE,
        spec         BLOB NOT NULL,                      -- A serialized shutterline.v1.JobSpec.
        state        INTEGER NOT NULL,                   -- As JobState.
        error        TEXT NOT NULL,
        submitted_us INTEGER NOT NULL,                   -- Microseconds since 1970, UTC.
        ended_us     INTEGER                             -- NULL: it has not ended.
      ) STRICT;
      CREATE INDEX jobs_unfinished ON jobs (key) WHERE ended_us IS NULL;

      CREATE TABLE finished_frames (
        job_key    INTEGER NOT NULL REFERENCES jobs (key),
        frame      INTEGER NOT NULL,                     -- The frame's number.
        digest     BLOB NOT NULL,                        -- SHA-256 of the EXR.
        size_bytes INTEGER NOT NULL,
        PRIMARY KEY (job_key, frame)
      ) STRICT, WITHOUT ROWID;
    )sql",
    R"sql(
      ALTER TABLE finished_frames ADD COLUMN stats BLOB;  -- A serialized shutterline.v1.RenderStats, or NULL.
    )sql",
    R"sql(
      ALTER TABLE jobs ADD COLUMN priority INTEGER NOT NULL DEFAULT 0;
      ALTER TABLE jobs ADD COLUMN user TEXT NOT NULL DEFAULT '';
      ALTER TABLE jobs ADD COLUMN after_ids TEXT NOT NULL DEFAULT '';      -- Ids of jobs, a comma between two.
      ALTER TABLE jobs ADD COLUMN paused INTEGER NOT NULL DEFAULT 0;
      ALTER TABLE finished_frames ADD COLUMN missing INTEGER NOT NULL DEFAULT 0;  -- Tiles that the EXR lacks.

      CREATE TABLE quarantined_tiles (
        job_key INTEGER NOT NULL REFERENCES jobs (key),
        frame   INTEGER NOT NULL,                        -- The frame's number.
        tile    INTEGER NOT NULL,
        PRIMARY KEY (job_key, frame, tile)
      ) STRICT, WITHOUT ROWID;

      CREATE TABLE tile_troubles (                       -- Why tiles are quarantined; in the order of rows.
        job_key      INTEGER NOT NULL,
        frame        INTEGER NOT NULL,
        tile         INTEGER NOT NULL,
        worker_uuid  TEXT NOT NULL,
        worker_name  TEXT NOT NULL,
        worker_ended INTEGER NOT NULL,
        reason       TEXT NOT NULL,
        time_us      INTEGER NOT NULL,                   -- Microseconds since 1970, UTC.
        FOREIGN KEY (job_key, frame, tile) REFERENCES quarantined_tiles ON DELETE CASCADE
      ) STRICT;
      CREATE INDEX tile_troubles_tile ON tile_troubles (job_key, frame, tile);

      CREATE TABLE connected_workers (uuid TEXT PRIMARY KEY) STRICT, WITHOUT ROWID;  -- When last heard of.
    )sql",
    R"sql(
      ALTER TABLE tile_troubles ADD COLUMN signal TEXT NOT NULL DEFAULT '';    -- As "SIGSEGV"; '': none is known.
      ALTER TABLE tile_troubles ADD COLUMN log_tail TEXT NOT NULL DEFAULT '';  -- Of the process that it ended.
    )sql",
    R"sql(
      CREATE INDEX jobs_ended ON jobs (ended_us, key) WHERE ended_us IS NOT NULL;

      CREATE TABLE removed_jobs (                        -- What is remembered of them: about 100 bytes each.
        id         TEXT PRIMARY KEY,
        request_id TEXT NOT NULL UNIQUE,
        key        INTEGER NOT NULL,
        state      INTEGER NOT NULL,                     -- As JobState: how it had ended.
        removed_us INTEGER NOT NULL,                     -- Microseconds since 1970, UTC.
        files_left INTEGER NOT NULL                      -- 1: its files may still be there.
      ) STRICT, WITHOUT ROWID;
      CREATE INDEX removed_jobs_files_left ON removed_jobs (key) WHERE files_left = 1;
    )sql",
};

}  // namespace shutterline::server
