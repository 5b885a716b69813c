// Stores as every earlier version has left them, opened by this one.
#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <array>
#include <iterator>
#include <set>

#include "server/jobs/schema.h"
#include "server/jobs/sqlite_job_store.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::server {
namespace {

/// What a version was able to write. A new migration brings a new line here: its digest, and rows in the form
/// in which that version writes them.
struct Released {
  const char* digest;  ///< SHA-256 of the migration's text, in hex.
  const char* spec;    ///< A JobSpec as the version serialized it, in hex: bytes, for its code is gone.
  const char* frame;   ///< Values of its finished_frames for job 1, frame 1.
};

/// What every version since the second has written.
constexpr char kLaterSpec[] =
    "0a05666972737412360a05612e676c62122d0a05612e676c6212220a20303132333435363738396162636465663031323334353"
    "63738"
    "39616263646566184d1a06080110031802222f0864103219000000000000384029000000000000e03f400148035001590000000"
    "00000"
    "004068407005f00102c002042a0408011002";
constexpr Released kReleased[] = {
    {"92263f013e88bbed6acf8744ffbe652169cf15fd0218080440e4bbdca636d67c",
     "0a05666972737412360a05612e676c62122d0a05612e676c6212220a20303132333435363738396162636465663031323334353"
     "63738"
     "39616263646566184d1a0608011003180222290864103219000000000000384029000000000000e03f400148035001590000000"
     "00000"
     "0040684070052a0408011002",
     "1, 1, zeroblob(32), 99"},
    {"e44d5762a8f5dc4c20d8fb600502804b3ff101806ce502554573b6a35af9080c", kLaterSpec,
     "1, 1, zeroblob(32), 99, x'080c'"},
    {"a64c7dbe4c3a181828b7479d8bc8675ddfd50b50f8d12b4150e9a4c53a77bfb5", kLaterSpec,
     "1, 1, zeroblob(32), 99, x'080c', 2"},
    {"1c5c3e85c07be0a1b1a8e7b5a2a8c532fd4cb814783f769c4347c9f479e9ba36", kLaterSpec,
     "1, 1, zeroblob(32), 99, x'080c', 2"},
    {"53088e2396065fadfcc8519061b2537ce3b0f190d69b167368e8b870445aae75", kLaterSpec,
     "1, 1, zeroblob(32), 99, x'080c', 2"},
};

class MigrationsTest : public testing::Test {
 protected:
  static void Execute(sqlite3* database, const std::string& sql) {
    ASSERT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database) << "\n"
        << sql;
  }

  /// A store of the version: one job that waits, with a frame, and one that has ended.
  std::string MakeStore(size_t version) {
    const std::string path = absl::StrCat(folder_.path(), "/version-", version, ".sqlite");
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
    for (size_t i = 0; i < version; ++i) Execute(database, kMigrations[i]);
    const Released& released = kReleased[version - 1];
    const std::string columns =
        "INSERT INTO jobs (key, id, request_id, spec, state, error, submitted_us, ended_us) VALUES ";
    Execute(database, absl::StrCat("PRAGMA user_version = ", version, ";",
                                   "UPDATE counters SET value = 41 WHERE name = 'epoch';"));
    Execute(database,
            absl::StrCat(columns, "(1, 'waits', 'request 1', x'", released.spec, "', 1, '', 1000, NULL);"));
    Execute(database, absl::StrCat(columns, "(2, 'ended', 'request 2', x'", released.spec,
                                   "', 4, 'why', 2000, 3000);"));
    Execute(database, absl::StrCat("INSERT INTO finished_frames VALUES (", released.frame, ");"));
    sqlite3_close(database);
    return path;
  }

  test::TemporaryFolder folder_;
};

TEST_F(MigrationsTest, AReleasedMigrationIsNeverChanged) {
  ASSERT_EQ(std::size(kReleased), std::size(kMigrations))
      << "a new migration needs its digest and sample rows here";
  for (size_t i = 0; i < std::size(kMigrations); ++i) {
    EXPECT_EQ(Sha256(kMigrations[i]).ToHex(), kReleased[i].digest)
        << "migration " << i << " differs from what has been released: append another one instead";
  }
}

TEST_F(MigrationsTest, EveryVersionsStoreKeepsAllThatWasInIt) {
  for (size_t version = 1; version <= std::size(kReleased); ++version) {
    SCOPED_TRACE(testing::Message() << "version " << version);
    const std::string path = MakeStore(version);
    if (HasFatalFailure()) return;
    // Twice: what has been brought up to date is opened again.
    for (const uint64_t epoch : {42, 43}) {
      const auto store = SqliteJobStore::Open(path);
      ASSERT_TRUE(store.ok()) << store.status();
      EXPECT_EQ((*store)->NextEpoch().value(), epoch);
      const auto unfinished = (*store)->Unfinished();
      ASSERT_TRUE(unfinished.ok()) << unfinished.status();
      ASSERT_EQ(unfinished->size(), 1u);
      const JobRecord& waits = unfinished->front();
      EXPECT_EQ(waits.id, "waits");
      EXPECT_EQ(waits.request_id, "request 1");
      EXPECT_EQ(waits.submitted, absl::FromUnixMicros(1000));
      EXPECT_EQ(waits.spec.name, "first");
      EXPECT_EQ(waits.spec.frames.last, 3);
      EXPECT_EQ(waits.spec.render.width, 100);
      EXPECT_EQ(waits.spec.render.seed, 5u);
      EXPECT_EQ(waits.spec.scene.files.at(0).size, 77u);
      // What did not exist then has its default.
      EXPECT_EQ(waits.spec.render.lighting, LightingKind::kAuto);
      EXPECT_TRUE(HasPixelBox(waits.spec.render));
      EXPECT_EQ(waits.spec.render.matte_ranks, RenderSettings().matte_ranks);
      EXPECT_TRUE(Validate(waits.spec.render).ok());
      const auto ended = (*store)->Get("ended");
      ASSERT_TRUE(ended.ok()) << ended.status();
      EXPECT_EQ(ended->state, JobState::kFailed);
      EXPECT_EQ(ended->error, "why");
      EXPECT_EQ(ended->ended, absl::FromUnixMicros(3000));
      const auto frames = (*store)->FinishedFrames(1);
      ASSERT_TRUE(frames.ok() && frames->size() == 1) << frames.status();
      EXPECT_EQ(frames->front().size, 99u);
      EXPECT_EQ(frames->front().stats.tiles, version >= 2 ? 12 : 0);
      EXPECT_EQ(frames->front().missing, version >= 3 ? 2 : 0);
      // Numbers go on.
      if (epoch == 42) {
        EXPECT_EQ((*store)->Create("request 3", waits.spec, {}, absl::FromUnixMicros(5))->job.key, 3u);
        ASSERT_TRUE((*store)->End(3, JobState::kCancelled, "", absl::FromUnixMicros(6)).ok());
      }
    }
  }
}

TEST_F(MigrationsTest, AStoreOfALaterVersionIsRefusedAndLeftAlone) {
  const std::string path = MakeStore(std::size(kReleased));
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  Execute(database, absl::StrCat("PRAGMA user_version = ", std::size(kMigrations) + 1));
  sqlite3_close(database);
  const auto store = SqliteJobStore::Open(path);
  EXPECT_TRUE(absl::IsFailedPrecondition(store.status())) << store.status();
  EXPECT_THAT(std::string(store.status().message()),
              testing::HasSubstr(absl::StrCat("has schema version ", std::size(kMigrations) + 1,
                                              ", but this build knows only up to ", std::size(kMigrations))));
}

}  // namespace
}  // namespace shutterline::server
