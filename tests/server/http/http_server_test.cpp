#include "server/http/http_server.h"

#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <gmock/gmock.h>
#include <httplib.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class HttpServerTest : public CoordinatorFixture {
 protected:
  HttpServerTest() {
    StopCoordinator();
    config_.http = "127.0.0.1:0";
    StartCoordinator();
  }

  httplib::Client Client() {
    httplib::Client client("127.0.0.1", coordinator_->http_port());
    client.set_read_timeout(30);
    return client;
  }

  httplib::Response Get(const std::string& path, const httplib::Headers& headers = {}) {
    const httplib::Result result = Client().Get(path, headers);
    EXPECT_TRUE(result) << path;
    return result ? *result : httplib::Response();
  }

  json GetJson(const std::string& path) {
    const httplib::Response response = Get(path);
    EXPECT_EQ(response.status, 200) << path << ": " << response.body;
    return json::parse(response.body, nullptr, false);
  }

  /// Sample by series, as "name" or "name{labels}".
  std::map<std::string, double> Samples() {
    std::map<std::string, double> samples;
    for (const absl::string_view line : absl::StrSplit(Get("/metrics").body, '\n')) {
      if (line.empty() || line[0] == '#') continue;
      const size_t space = line.rfind(' ');
      double value = -1;
      EXPECT_TRUE(absl::SimpleAtod(line.substr(space + 1), &value)) << line;
      samples[std::string(line.substr(0, space))] = value;
    }
    return samples;
  }

  static double Outcome(const std::map<std::string, double>& samples, const std::string& outcome) {
    return samples.at(absl::StrCat("shutterline_tiles_total{outcome=\"", outcome, "\"}"));
  }

  /// The text of a stream of events until it holds `text`.
  std::string EventsUntil(const std::string& path, const std::string& text,
                          const httplib::Headers& headers = {}) {
    std::string events;
    Client().Get(path, headers, [&](const char* data, size_t size) {
      events.append(data, size);
      return !absl::StrContains(events, text);
    });
    EXPECT_THAT(events, HasSubstr(text));
    return events;
  }

  static httplib::Headers Control() { return {{"X-Shutterline-Request", "1"}}; }
};

TEST_F(HttpServerTest, MetricsAddUpOverARun) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 1, 100, 70));  // Two frames of 4 × 3 tiles.
  std::map<std::string, double> samples = Samples();
  EXPECT_EQ(samples.at("shutterline_queued_tiles"), 24);
  EXPECT_EQ(samples.at("shutterline_desired_workers"), 1);
  EXPECT_EQ(samples.at("shutterline_workers_connected"), 0);
  EXPECT_EQ(samples.at("shutterline_jobs{state=\"queued\"}"), 1);

  FakeWorker worker(channel_);
  worker.Credit(1);
  const v1::Grant grant = worker.NextGrant();
  samples = Samples();
  EXPECT_EQ(samples.at("shutterline_leased_tiles"), grant.tiles_size());
  EXPECT_EQ(samples.at("shutterline_leases_granted_total"), 1);
  EXPECT_EQ(samples.at("shutterline_workers_connected"), 1);
  EXPECT_EQ(samples.at("shutterline_worker_slots"), 1);
  const uint32_t tile = grant.tiles(0);
  worker.Push({worker.Result(grant, tile)});
  worker.Push({worker.Result(grant, tile)});
  v1::TileResult other = worker.Result(grant, tile), small = other, failed = other, strange = other;
  other.mutable_pixels()->back() ^= 1;
  small.mutable_pixels()->pop_back();
  failed.set_tile((tile + 1) % 12);
  failed.mutable_failure()->set_code(13);
  strange.set_job_id("no job");
  worker.Push({other, small, failed, strange});
  samples = Samples();
  for (const char* outcome : {"stored", "duplicate", "mismatch", "refused", "failed", "unwanted"})
    EXPECT_EQ(Outcome(samples, outcome), 1) << outcome;
  EXPECT_EQ(samples.at("shutterline_tile_mismatch_total"), 1);
  EXPECT_EQ(samples.at("shutterline_tile_render_seconds_count"), 1);
  EXPECT_NEAR(samples.at("shutterline_tile_render_seconds_sum"), 0.001, 1e-9);
  EXPECT_NEAR(samples.at("shutterline_remaining_work_seconds"), 0.023, 1e-9);

  worker.RenderUntilForgotten();
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
  samples = Samples();
  EXPECT_EQ(Outcome(samples, "stored"), 24);
  EXPECT_EQ(samples.at("shutterline_tile_render_seconds_count"), 24);
  EXPECT_EQ(samples.at("shutterline_tile_render_seconds_bucket{le=\"+Inf\"}"), 24);
  EXPECT_EQ(samples.at("shutterline_journal_written_bytes_total"), 2 * 100 * 70 * 16);
  EXPECT_EQ(samples.at("shutterline_frames_written_total"), 2);
  EXPECT_EQ(samples.at("shutterline_frame_write_seconds_count"), 2);
  double bytes = 0;
  const json frames = GetJson(absl::StrCat("/api/jobs/", job.id(), "/frames"));
  for (const json& frame : frames["frames"]) bytes += frame["size_bytes"].get<double>();
  EXPECT_EQ(samples.at("shutterline_frame_written_bytes_total"), bytes);
  EXPECT_EQ(samples.at("shutterline_jobs_accepted_total"), 1);
  EXPECT_EQ(samples.at("shutterline_jobs_ended_total{state=\"succeeded\"}"), 1);
  EXPECT_EQ(samples.at("shutterline_queued_tiles"), 0);
  EXPECT_EQ(samples.at("shutterline_leased_tiles"), 0);
  EXPECT_EQ(samples.at("shutterline_desired_workers"), 0);
  EXPECT_EQ(samples.at("shutterline_blob_received_bytes_total"), double(TriangleGltf().size()));
  EXPECT_EQ(samples.at("shutterline_epoch"), 2);
  EXPECT_GE(samples.at("shutterline_commit_seconds_count"), 4);
}

TEST_F(HttpServerTest, EveryMetricHasHelpAndAUnitAndTheDashboardAsksForNoOther) {
  const std::string text = Get("/metrics").body;
  std::set<std::string> names;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    const std::vector<std::string> words = absl::StrSplit(line, absl::MaxSplits(' ', 3));
    if (words.size() < 4 || words[1] != "TYPE") continue;
    EXPECT_THAT(text, HasSubstr(absl::StrCat("# HELP ", words[2], " "))) << words[2];
    EXPECT_TRUE(absl::StartsWith(words[2], "shutterline_")) << words[2];
    EXPECT_EQ(words[3] == "counter", absl::EndsWith(words[2], "_total")) << words[2];
    if (words[3] == "histogram") {
      EXPECT_TRUE(absl::EndsWith(words[2], "_seconds")) << words[2];
      for (const char* part : {"_bucket", "_sum", "_count"}) names.insert(words[2] + part);
    }
    names.insert(words[2]);
  }
  std::ifstream file(std::string(SHUTTERLINE_SOURCE_DIR) + "/deploy/grafana/shutterline.json");
  const json board = json::parse(file, nullptr, false);
  ASSERT_TRUE(board.is_object());
  int queries = 0;
  for (const json& panel : board["panels"]) {
    for (const json& target : panel.value("targets", json::array())) {
      ++queries;
      const std::string query = target["expr"];
      for (size_t at = query.find("shutterline_"); at != std::string::npos;
           at = query.find("shutterline_", at + 1)) {
        const size_t end = query.find_first_not_of("abcdefghijklmnopqrstuvwxyz_", at);
        EXPECT_TRUE(names.contains(query.substr(at, end - at))) << query;
      }
    }
  }
  EXPECT_GE(queries, 10);
}

TEST_F(HttpServerTest, TheApiTellsAJobFromItsTilesToItsPicture) {
  const v1::Job job = SubmitOrDie(TriangleJob(5, 6, 100, 70));
  const std::string at = absl::StrCat("/api/jobs/", job.id());
  EXPECT_EQ(GetJson("/api/jobs")["jobs"][0], GetJson(at));
  EXPECT_EQ(GetJson(at)["state"], "queued");
  EXPECT_EQ(GetJson(at)["tiles_total"], 24);
  FakeWorker worker(channel_);
  worker.Credit(1);
  const v1::Grant grant = worker.NextGrant();
  worker.Push({worker.Result(grant, grant.tiles(0))});
  EXPECT_EQ(GetJson("/api/workers")["workers"][0]["name"], "fake worker");
  EXPECT_EQ(GetJson("/api/overview")["workers"], 1);
  EXPECT_EQ(GetJson("/api/overview")["may_control"], true);

  const std::string frame = absl::StrCat(at, "/frames/", grant.frame());
  json tiles = GetJson(frame + "/tiles");
  ASSERT_EQ(tiles["tiles"].size(), 1u);
  EXPECT_EQ(tiles["tiles"][0][0], grant.tiles(0));
  EXPECT_EQ(tiles["tiles"][0][1], 0.001);
  EXPECT_EQ(tiles["workers"][0], "fake worker");
  const std::string cursor = tiles["cursor"];
  tiles = GetJson(frame + "/tiles?after=" + cursor);
  EXPECT_EQ(tiles["tiles"].size(), 0u);
  EXPECT_EQ(tiles["whole"], false);
  const httplib::Response strip = Get(absl::StrCat(frame, "/tiles.png?tiles=11,", grant.tiles(0)));
  EXPECT_EQ(strip.get_header_value("X-Shutterline-Tiles"), absl::StrCat(grant.tiles(0)));
  EXPECT_EQ(strip.body.substr(1, 3), "PNG");
  EXPECT_EQ(Get(frame + "/tiles.png?tiles=999").status, 400);
  EXPECT_EQ(Get(frame + "/tiles.png?tiles=11").status, 404);
  EXPECT_EQ(Get(frame + "/picture.png").status, 409);

  worker.RenderUntilForgotten();
  WaitForEnd(job.id());
  tiles = GetJson(frame + "/tiles");
  EXPECT_EQ(tiles["tiles"].size(), 12u);
  EXPECT_EQ(tiles["frame"]["state"], "finished");
  const httplib::Response picture = Get(frame + "/picture.png?side=50");
  ASSERT_EQ(picture.body.substr(1, 3), "PNG");
  EXPECT_EQ(picture.body.substr(16, 8), std::string("\0\0\0\x32\0\0\0\x23", 8));  // 50 × 35
  EXPECT_EQ(Get(frame + "/picture.png?side=50", {{"If-None-Match", picture.get_header_value("ETag")}}).status,
            304);
  int64_t sum = 0;
  const json throughput = GetJson("/api/throughput");
  for (const json& step : throughput["tiles"]) sum += step.get<int64_t>();
  EXPECT_EQ(sum, 24);
}

TEST_F(HttpServerTest, AfterARestartTheTilesThatTheJournalHasAreStillShown) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 100, 70));
  {
    FakeWorker worker(channel_);
    worker.Credit(1);
    const v1::Grant grant = worker.NextGrant();
    worker.Push({worker.Result(grant, grant.tiles(0))});
  }
  StopCoordinator();
  StartCoordinator();
  const std::string frame = absl::StrCat("/api/jobs/", job.id(), "/frames/0");
  const json tiles = GetJson(frame + "/tiles");
  ASSERT_EQ(tiles["tiles"].size(), 1u);
  EXPECT_TRUE(tiles["tiles"][0][1].is_null());
  EXPECT_EQ(Get(absl::StrCat(frame, "/tiles.png?tiles=", tiles["tiles"][0][0].get<int>())).status, 200);
}

TEST_F(HttpServerTest, EventsResumeWhereTheyStopped) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 32, 32));
  const std::string first = EventsUntil("/events", "event: farm");
  EXPECT_THAT(first, HasSubstr("event: job"));
  EXPECT_THAT(first, HasSubstr(job.id()));
  const size_t id = first.find("id: ");
  const std::string seen = first.substr(id + 4, first.find('\n', id) - id - 4);
  EXPECT_EQ(EventsUntil("/events", "event: farm", {{"Last-Event-ID", seen}}).find("event: job"),
            std::string::npos);
  FakeWorker worker(channel_);
  worker.RenderUntilForgotten();
  const std::string rest =
      EventsUntil(absl::StrCat("/events?job=", job.id()), "\"succeeded\"", {{"Last-Event-ID", seen}});
  EXPECT_THAT(rest, HasSubstr("event: frame"));
  EXPECT_EQ(Get("/events?job=nonsense").status, 404);
  EXPECT_EQ(Get("/events", {{"Last-Event-ID", "x"}}).status, 400);
}

TEST_F(HttpServerTest, ControlNeedsMarkerAndJson) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 32, 32));
  const std::string at = absl::StrCat("/api/jobs/", job.id(), "/control");
  const std::string cancel = R"({"action": "cancel"})";
  EXPECT_EQ(Client().Post(at, cancel, "application/json")->status, 403);
  EXPECT_EQ(Client().Post(at, Control(), cancel, "text/plain")->status, 400);
  EXPECT_EQ(Client().Post(at, Control(), "{", "application/json")->status, 400);
  EXPECT_EQ(Client().Post(at, Control(), R"({"action": "explode"})", "application/json")->status, 400);
  httplib::Headers cross = Control();
  cross.emplace("Origin", "http://evil.example");
  EXPECT_EQ(Client().Post(at, cross, cancel, "application/json")->status, 403);
  EXPECT_EQ(CoordinatorFixture::Get(job.id()).state(), v1::JOB_STATE_QUEUED);
  for (const bool paused : {true, false}) {
    const std::string action = absl::StrCat("{\"action\": \"", paused ? "pause" : "resume", "\"}");
    EXPECT_EQ(Client().Post(at, Control(), action, "application/json")->status, 200);
    EXPECT_EQ(GetJson(absl::StrCat("/api/jobs/", job.id()))["paused"], paused);
  }
  EXPECT_EQ(GetJson(absl::StrCat("/api/jobs/", job.id(), "/quarantined"))["quarantined"], json::array());
  EXPECT_EQ(Client().Post(at, Control(), cancel, "application/json")->status, 200);
  EXPECT_EQ(CoordinatorFixture::Get(job.id()).state(), v1::JOB_STATE_CANCELLED);
  EXPECT_EQ(Client().Post(at, Control(), R"({"action": "retry"})", "application/json")->status, 200);
  EXPECT_EQ(CoordinatorFixture::Get(job.id()).state(), v1::JOB_STATE_QUEUED);
}

TEST_F(HttpServerTest, StrangersAreRefused) {
  EXPECT_EQ(Get("/healthz").body, "ok\n");
  EXPECT_EQ(Get("/healthz", {{"Host", "evil.example"}}).status, 403);
  EXPECT_EQ(Client().Delete("/api/jobs")->status, 400);
  EXPECT_EQ(Get("/../../etc/passwd").status, 404);
  EXPECT_EQ(Get("/" + std::string(600, 'a')).status, 400);
  const httplib::Response page = Get("/");
  EXPECT_EQ(page.status, 200);
  const std::string policy = page.get_header_value("Content-Security-Policy");
  EXPECT_THAT(policy, HasSubstr("default-src 'none'"));
  EXPECT_EQ(policy.find("unsafe"), std::string::npos);
  // Nothing inline that the policy would refuse.
  EXPECT_EQ(page.body.find("<style"), std::string::npos);
  EXPECT_EQ(page.body.find(" style="), std::string::npos);
  EXPECT_EQ(page.body.find(" onclick="), std::string::npos);
}

TEST_F(HttpServerTest, ARequestLargerThanAllowedIsNotReadToItsEnd) {
  httplib::Headers headers;
  for (int i = 0; i < 100; ++i) headers.emplace(absl::StrCat("X-", i), std::string(4000, 'a'));
  const httplib::Result result = Client().Get("/healthz", headers);
  EXPECT_TRUE(!result || result->status != 200);
  EXPECT_EQ(Get("/healthz").status, 200);
}

TEST_F(HttpServerTest, MoreReadersOfEventsThanThereIsRoomForAreTurnedAway) {
  std::vector<std::thread> readers;
  std::atomic<int> reading = 0, refused = 0;
  std::atomic<bool> stop = false;
  for (int i = 0; i < 20; ++i) {
    readers.emplace_back([&] {
      const httplib::Result result = Client().Get(
          "/events",
          [&](const httplib::Response& response) {
            ++(response.status == 200 ? reading : refused);
            return true;
          },
          [&](const char*, size_t) { return !stop; });
    });
  }
  while (reading + refused < 20) std::this_thread::yield();
  EXPECT_EQ(reading, 16);
  EXPECT_EQ(Get("/healthz").status, 200);
  stop = true;
  for (std::thread& reader : readers) reader.join();
}

TEST_F(HttpServerTest, TheEndOfTheCoordinatorEndsStreams) {
  std::atomic<bool> reading = false;
  std::thread reader([&] { Client().Get("/events", [&](const char*, size_t) { return reading = true; }); });
  while (!reading) std::this_thread::yield();
  StopCoordinator();
  reader.join();
  StartCoordinator();
  EXPECT_EQ(Get("/healthz").status, 200);
}

}  // namespace
}  // namespace shutterline::test
