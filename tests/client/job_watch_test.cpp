#include "client/job_watch.h"

#include <gtest/gtest.h>

#include <random>
#include <sstream>
#include <thread>
#include <vector>

#include "client/delivery.h"
#include "client/json_output.h"
#include "client/report.h"
#include "tests/client/fake_farm.h"
#include "tests/client/temp_folder.h"

namespace shutterline::client::job_watch_test {
namespace {

constexpr char kJob[] = "0f8fad5b-d9cb-469f-a165-70867728950e";

TEST(JobWatch, EveryEventComesOnceHoweverOftenTheStreamBreaks) {
  const uint32_t seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 10; ++round) {
    FakeFarm farm;
    uint64_t seq = 0;
    for (int i = 0; i < 50; ++i) {
      seq += std::uniform_int_distribution<uint64_t>(1, 5)(random);
      farm.events.push_back(JobEventOf(seq, v1::JOB_STATE_RUNNING, 0, 1));
    }
    farm.events.push_back(JobEventOf(seq + 1, v1::JOB_STATE_SUCCEEDED, 1, 1));
    for (int i = 0; i < 6; ++i) farm.cuts.push_back(std::uniform_int_distribution<uint64_t>(0, 12)(random));
    std::vector<uint64_t> seen;
    const auto job = WatchJob(*farm.Connect(), kJob, [&](const v1::JobEvent& event) {
      seen.push_back(event.seq());
      return absl::OkStatus();
    });
    ASSERT_TRUE(job.ok()) << job.status();
    EXPECT_EQ(job->state(), v1::JOB_STATE_SUCCEEDED);
    std::vector<uint64_t> all;
    for (const auto& event : farm.events) all.push_back(event.seq());
    EXPECT_EQ(seen, all);
    EXPECT_GT(farm.after_seqs.size(), 1u);
  }
}

TEST(JobWatch, AnErrorOfTheListenerEndsItAsItIs) {
  FakeFarm farm;
  for (uint64_t seq = 1; seq < 5; ++seq) {
    farm.events.push_back(JobEventOf(seq, v1::JOB_STATE_RUNNING, 0, 1));
  }
  int calls = 0;
  const auto job = WatchJob(*farm.Connect(), kJob, [&](const v1::JobEvent&) {
    ++calls;
    return absl::UnavailableError("the disk is full");
  });
  EXPECT_EQ(job.status(), absl::UnavailableError("the disk is full"));
  EXPECT_EQ(calls, 1);
}

TEST(JobWatch, AnInterruptEndsItAsCancelled) {
  FakeFarm farm;
  farm.events.push_back(JobEventOf(1, v1::JOB_STATE_RUNNING, 0, 1));
  Interrupt interrupt;
  const auto connection = farm.Connect(&interrupt);
  const auto job = WatchJob(*connection, kJob, [&](const v1::JobEvent&) {
    std::thread([&] { interrupt.Raise(); }).join();
    return absl::OkStatus();
  });
  EXPECT_EQ(job.status().code(), absl::StatusCode::kCancelled) << job.status();
}

TEST(Delivery, FetchesFramesAsTheyFinishAndTheRestAtTheEnd) {
  FakeFarm farm;
  TempFolder folder;
  for (int frame = 1; frame <= 3; ++frame) farm.frames[frame] = std::string(size_t(frame * 100), char(frame));
  farm.events = {JobEventOf(1, v1::JOB_STATE_RUNNING, 0, 3), FrameEventOf(2, 2), FrameEventOf(3, 2),
                 FrameEventOf(4, 99), JobEventOf(5, v1::JOB_STATE_SUCCEEDED, 3, 3)};
  farm.cuts = {2};
  std::ostringstream out;
  Progress progress(ProgressStyle::kQuiet, out);
  const Destination destination{*OutputPath::Parse(folder.File("f.####.exr")), false};
  const auto delivery = Deliver(*farm.Connect(), kJob, {1, 3, 1}, &destination, progress);
  ASSERT_TRUE(delivery.ok()) << delivery.status();
  ASSERT_EQ(delivery->frames.size(), 3u);
  EXPECT_EQ(delivery->frames[0].frame, 2) << "the first to finish";
  for (int frame = 1; frame <= 3; ++frame) {
    EXPECT_EQ(folder.Read("f.000" + std::to_string(frame) + ".exr"), farm.frames[frame]);
  }
  EXPECT_EQ(delivery->Code(), ExitCode::kSuccess);
  EXPECT_EQ(folder.Count(), 3u);
}

TEST(Delivery, ExitCodesTellWholeFromPartFromNothing) {
  std::ostringstream out, err;
  Console console{out, err};
  for (const auto& [state, finished, code] : std::vector<std::tuple<v1::JobState, uint32_t, ExitCode>>{
           {v1::JOB_STATE_SUCCEEDED, 2, ExitCode::kSuccess},
           {v1::JOB_STATE_PARTIAL, 2, ExitCode::kPartial},
           {v1::JOB_STATE_FAILED, 1, ExitCode::kPartial},
           {v1::JOB_STATE_CANCELLED, 1, ExitCode::kPartial},
           {v1::JOB_STATE_FAILED, 0, ExitCode::kFailed},
           {v1::JOB_STATE_CANCELLED, 0, ExitCode::kFailed}}) {
    const Delivery delivery{JobEventOf(1, state, finished, 2).job(), {}, {}};
    EXPECT_EQ(*Report(console, delivery, {}, {}), code);
    EXPECT_EQ(err.str().empty(), code == ExitCode::kSuccess) << err.str();
    err.str("");
  }
}

TEST(Connection, WaitsForAServerThatStartsAndGivesUpOnOneThatDoesNot) {
  FakeFarm farm;
  farm.unavailable_calls = 3;
  EXPECT_TRUE(Greet(*farm.Connect()).ok());
  farm.unavailable_calls = 1'000'000;
  Connection::Options options = farm.FastOptions();
  options.retry.patience = absl::Milliseconds(20);
  std::string said;
  options.on_wait = [&](absl::string_view text) { said += std::string(text) + "\n"; };
  const auto connection = farm.Connect();
  Connection impatient(farm.Channel(), "the fake farm", options);
  const auto reply = Greet(impatient);
  EXPECT_EQ(reply.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_NE(reply.status().message().find("the fake farm does not answer"), absl::string_view::npos)
      << reply.status();
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
}

TEST(Connection, NamesBothSidesOfAProtocolMismatch) {
  FakeFarm farm;
  farm.protocol_low = 7;
  farm.protocol_high = 9;
  const auto reply = Greet(*farm.Connect());
  EXPECT_EQ(reply.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_NE(reply.status().message().find("7 to 9"), absl::string_view::npos) << reply.status();
  EXPECT_NE(reply.status().message().find("fake"), absl::string_view::npos) << reply.status();
}

TEST(JsonOutput, KeysAreStable) {
  v1::Job job = JobEventOf(1, v1::JOB_STATE_RUNNING, 1, 2).job();
  job.mutable_spec()->set_name("n");
  const auto keys = [](const Json& json) {
    std::vector<std::string> names;
    for (const auto& [key, value] : json.items()) names.push_back(key);
    return names;
  };
  EXPECT_EQ(keys(ToJson(job)), (std::vector<std::string>{"id",
                                                         "state",
                                                         "error",
                                                         "frames_total",
                                                         "frames_finished",
                                                         "tiles_total",
                                                         "tiles_done",
                                                         "workers",
                                                         "mismatched_tiles",
                                                         "priority",
                                                         "user",
                                                         "paused",
                                                         "after",
                                                         "waits_for",
                                                         "tiles_quarantined",
                                                         "submitted",
                                                         "ended",
                                                         "name",
                                                         "scene",
                                                         "frames",
                                                         "width",
                                                         "height",
                                                         "order"}));
  EXPECT_EQ(keys(ToJson(FetchedFrame{})),
            (std::vector<std::string>{"frame", "file", "preview", "size_bytes", "digest"}));
  EXPECT_EQ(keys(ToJson(UploadReport{})),
            (std::vector<std::string>{"files", "bytes", "files_uploaded", "bytes_uploaded"}));
  EXPECT_EQ(keys(ToJson(v1::Worker())),
            (std::vector<std::string>{"uuid", "name", "build_id", "isa", "slots", "draining", "leased_tiles",
                                      "tiles_done", "tile_seconds", "silent_seconds"}));
  EXPECT_EQ(keys(ToJson(v1::FrameStatus())),
            (std::vector<std::string>{"frame", "state", "tiles_total", "tiles_done", "tiles_missing",
                                      "digest", "size_bytes"}));
  EXPECT_TRUE(ToJson(job)["ended"].is_null());
  EXPECT_EQ(ToJson(job)["state"], "running");
}

TEST(JsonOutput, BytesThatAreNotUtf8DoNotBreakIt) {
  FetchedFrame frame;
  frame.path = "bad\xff\xfename.exr";
  std::ostringstream out;
  Print(ToJson(frame), out, true);
  EXPECT_EQ(Json::parse(out.str())["file"], "bad\xEF\xBF\xBD\xEF\xBF\xBDname.exr");
}

}  // namespace
}  // namespace shutterline::client::job_watch_test
