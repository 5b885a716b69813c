#include "server/http/routes.h"

#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "server/http/dashboard_files.h"

namespace shutterline::server {
namespace {

constexpr int64_t kMaxPage = 500;        ///< Jobs, or frames, of one answer.
constexpr size_t kMaxQuarantined = 100;  ///< Tiles of one answer.
constexpr size_t kMaxPathBytes = 512;
constexpr absl::Duration kLook = absl::Milliseconds(250);  ///< Between two looks of a stream.

int HttpCode(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return 200;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kOutOfRange:
      return 400;
    case absl::StatusCode::kUnauthenticated:
      return 401;
    case absl::StatusCode::kPermissionDenied:
      return 403;
    case absl::StatusCode::kNotFound:
      return 404;
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kAborted:
      return 409;
    case absl::StatusCode::kResourceExhausted:
    case absl::StatusCode::kUnavailable:
      return 503;
    default:
      return 500;
  }
}

absl::Status Answer(const Json& json, httplib::Response& response) {
  response.set_content(Dump(json) + "\n", "application/json");
  return absl::OkStatus();
}

void Refuse(const absl::Status& status, httplib::Response& response) {
  response.status = HttpCode(status);
  (void)Answer({{"error", std::string(status.message())}}, response);
}

HttpRequestFacts FactsOf(const httplib::Request& request) {
  const auto header = [&](const char* name) { return request.get_header_value(name); };
  // Two of a kind: whoever is in between may have looked at the other one.
  const bool one_host = request.get_header_value_count("Host") == 1;
  return {request.method,
          request.path,
          one_host ? header("Host") : "",
          header("Origin"),
          header("Sec-Fetch-Site"),
          header("Content-Type"),
          header(kHttpMarker),
          request.remote_addr};
}

/// A parameter of the query; `fallback` where it is absent.
template <typename Number>
absl::StatusOr<Number> NumberParameter(const httplib::Request& request, const char* name, Number low,
                                       Number high, Number fallback) {
  if (!request.has_param(name)) return fallback;
  Number value{};
  const std::string text = request.get_param_value(name);
  if (!absl::SimpleAtoi(text, &value) || value < low || value > high) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": must be a number from ", low, " to ", high));
  }
  return value;
}

/// What every answer says to browsers: no script but ours, in no frame, for no other site.
httplib::Headers SafeHeaders() {
  return {
      {"Content-Security-Policy",
       "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
       "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Referrer-Policy", "no-referrer"},
      {"X-Content-Type-Options", "nosniff"},
      {"Cache-Control", "no-cache"}};
}

const char* TypeOf(absl::string_view name) {
  if (absl::EndsWith(name, ".html")) return "text/html; charset=utf-8";
  if (absl::EndsWith(name, ".css")) return "text/css; charset=utf-8";
  if (absl::EndsWith(name, ".js")) return "text/javascript; charset=utf-8";
  return "image/svg+xml";
}

}  // namespace

Routes::Routes(HttpServer::Parts parts) : parts_(std::move(parts)), pictures_(*parts_.journal) {}

void Routes::Install(httplib::Server& server) {
  server.set_default_headers(SafeHeaders());
  server.set_exception_handler([](const Request&, Response& response, std::exception_ptr) {
    Refuse(absl::InternalError("an exception"), response);
  });
  // Everything but POST is answered before the library looks at its own routes, whose regular expressions are
  // not made for strangers' paths.
  server.set_pre_routing_handler([this](const Request& request, Response& response) {
    absl::Status status = CheckHttpRequest(FactsOf(request), parts_.names);
    if (status.ok() && request.path.size() > kMaxPathBytes)
      status = absl::InvalidArgumentError("the path is too long");
    if (status.ok() && request.method == "POST") return httplib::Server::HandlerResponse::Unhandled;
    if (status.ok()) status = Get(request, response);
    if (!status.ok()) Refuse(status, response);
    return httplib::Server::HandlerResponse::Handled;
  });
  server.Post(R"(/api/jobs/[0-9a-f-]+/control)", [this](const Request& request, Response& response) {
    const absl::Status status = Post(request, response);
    if (!status.ok()) Refuse(status, response);
  });
}

absl::Status Routes::Get(const Request& request, Response& response) {
  const absl::string_view all = request.path;
  if (all == "/healthz") {
    response.set_content("ok\n", "text/plain; charset=utf-8");
    return absl::OkStatus();
  }
  if (all == "/metrics") {
    response.set_content(parts_.metrics->Text(parts_.farm->Totals()),
                         "text/plain; version=0.0.4; charset=utf-8");
    return absl::OkStatus();
  }
  if (all == "/events") return GetEvents(request, response);
  if (all == "/") return GetFile("index.html", request, response);
  const Path path = absl::StrSplit(all.substr(1), '/');
  if (path[0] == "api") return GetApi(path, request, response);
  if (path.size() == 1) return GetFile(path[0], request, response);
  return absl::NotFoundError("there is nothing here");
}

absl::Status Routes::GetFile(absl::string_view name, const Request& request, Response& response) {
  for (const DashboardFile& file : DashboardFiles()) {
    if (file.name != name) continue;
    const std::string tag = absl::StrCat("\"", file.digest.substr(0, 32), "\"");
    response.set_header("ETag", tag);
    if (request.get_header_value("If-None-Match") == tag) {
      response.status = 304;
    } else {
      response.set_content(file.content.data(), file.content.size(), TypeOf(name));
    }
    return absl::OkStatus();
  }
  return absl::NotFoundError("there is nothing here");
}

Json Routes::Overview(const Request& request) {
  Json overview = ToJson(parts_.farm->Totals());
  overview["tiles_per_second"] = parts_.throughput->TilesPerSecond();
  overview["build"] = parts_.build_id;
  overview["epoch"] = parts_.farm->epoch();
  overview["may_control"] = parts_.may_control(FactsOf(request)).ok();
  return overview;
}

absl::StatusOr<Json> Routes::Jobs(const Request& request) {
  SL_ASSIGN_OR_RETURN(const int64_t limit, NumberParameter<int64_t>(request, "limit", 1, kMaxPage, 100));
  const auto most = uint64_t(std::numeric_limits<int64_t>::max());
  SL_ASSIGN_OR_RETURN(const uint64_t before, NumberParameter<uint64_t>(request, "before", 0, most, most));
  SL_ASSIGN_OR_RETURN(std::vector<JobSnapshot> jobs, parts_.farm->List(before, int(limit) + 1));
  const bool more = jobs.size() > size_t(limit);
  if (more) jobs.resize(size_t(limit));
  Json list = Json::array();
  for (const JobSnapshot& job : jobs) list.push_back(ToJson(job));
  return Json{{"jobs", list}, {"before", more ? Json(jobs.back().key) : Json(nullptr)}};
}

absl::Status Routes::GetApi(const Path& path, const Request& request, Response& response) {
  if (path.size() == 2 && path[1] == "overview") return Answer(Overview(request), response);
  if (path.size() == 2 && path[1] == "workers") {
    Json list = Json::array();
    for (const WorkerSnapshot& worker : parts_.farm->Workers()) list.push_back(ToJson(worker));
    return Answer({{"workers", list}}, response);
  }
  if (path.size() == 2 && path[1] == "throughput") {
    Json tiles = Json::array(), seconds = Json::array();
    for (const Throughput::Step& step : parts_.throughput->Steps()) {
      tiles.push_back(step.tiles);
      seconds.push_back(step.render_seconds);
    }
    return Answer({{"step_seconds", absl::ToDoubleSeconds(Throughput::kStep)},
                   {"tiles", tiles},
                   {"render_seconds", seconds}},
                  response);
  }
  if (path.size() < 2 || path[1] != "jobs") return absl::NotFoundError("there is nothing here");
  if (path.size() == 2) {
    SL_ASSIGN_OR_RETURN(const Json jobs, Jobs(request));
    return Answer(jobs, response);
  }
  const std::string job_id(path[2]);
  if (path.size() == 3) {
    SL_ASSIGN_OR_RETURN(const JobSnapshot job, parts_.farm->Get(job_id));
    return Answer(ToJson(job), response);
  }
  if (path[3] == "quarantined" && path.size() == 4) {
    SL_ASSIGN_OR_RETURN(const auto tiles, parts_.farm->QuarantinedTiles(job_id, kMaxQuarantined));
    Json list = Json::array();
    for (const QuarantinedTile& tile : tiles) list.push_back(ToJson(tile));
    return Answer({{"quarantined", list}}, response);
  }
  if (path[3] != "frames") return absl::NotFoundError("there is nothing here");
  if (path.size() == 4) {
    SL_ASSIGN_OR_RETURN(
        const int64_t first,
        NumberParameter<int64_t>(request, "first", 0, std::numeric_limits<int32_t>::max(), 0));
    SL_ASSIGN_OR_RETURN(const int64_t limit,
                        NumberParameter<int64_t>(request, "limit", 1, kMaxPage, kMaxPage));
    SL_ASSIGN_OR_RETURN(const auto frames, parts_.farm->Frames(job_id, first, limit));
    Json list = Json::array();
    for (const FrameSnapshot& frame : frames) list.push_back(ToJson(frame));
    return Answer({{"first", first}, {"frames", list}}, response);
  }
  return GetFrame(job_id, path, request, response);
}

absl::Status Routes::GetFrame(const std::string& job_id, const Path& path, const Request& request,
                              Response& response) {
  int32_t frame = 0;
  if (!absl::SimpleAtoi(path[4], &frame)) return absl::NotFoundError("a frame has a number");
  SL_ASSIGN_OR_RETURN(const Farm::FrameView view, parts_.farm->ViewFrame(job_id, frame));
  if (path.size() == 5) return Answer(ToJson(view.frame), response);
  if (path.size() != 6) return absl::NotFoundError("there is nothing here");
  if (path[5] == "tiles") return GetTiles(job_id, view, request, response);
  if (path[5] == "picture.png") return GetPicture(view, request, response);
  if (path[5] == "tiles.png") {
    std::vector<uint32_t> tiles;
    const std::string list = request.get_param_value("tiles");
    for (const absl::string_view text : absl::StrSplit(list, ',')) {
      if (!absl::SimpleAtoi(text, &tiles.emplace_back()))
        return absl::InvalidArgumentError("tiles: must be numbers with commas between");
    }
    SL_ASSIGN_OR_RETURN(const FramePictures::Strip strip, pictures_.Tiles(view, tiles));
    response.set_header("X-Shutterline-Tiles", absl::StrJoin(strip.tiles, ","));
    response.set_content(strip.png, "image/png");
    return absl::OkStatus();
  }
  return absl::NotFoundError("there is nothing here");
}

absl::Status Routes::GetTiles(const std::string& job_id, const Farm::FrameView& view, const Request& request,
                              Response& response) {
  // "ID.COUNT": tiles of that timeline that are known already.
  const std::string after = request.get_param_value("after");
  uint64_t id = 0, count = 0;
  const std::vector<absl::string_view> parts = absl::StrSplit(after, '.');
  if (!after.empty() &&
      (parts.size() != 2 || !absl::SimpleAtoi(parts[0], &id) || !absl::SimpleAtoi(parts[1], &count))) {
    return absl::InvalidArgumentError("after: must be the cursor of an earlier answer");
  }
  std::optional<FrameTimeline> timeline = parts_.timeline->Find(job_id, view.frame.frame, size_t(count));
  bool whole = !timeline || timeline->id != id || timeline->skipped != count;
  if (whole && timeline && count > 0) timeline = parts_.timeline->Find(job_id, view.frame.frame);
  Json answer = ToJson(timeline.value_or(FrameTimeline()));
  const size_t known = timeline ? timeline->skipped + timeline->tiles.size() : 0;
  answer["frame"] = ToJson(view.frame);
  answer["whole"] = whole;
  answer["cursor"] = timeline ? Json(absl::StrCat(timeline->id, ".", known)) : Json(nullptr);
  // Tiles of before the coordinator's start, or of before the timeline's: where they are, not what they took.
  if (whole && view.frame.state != FrameState::kFinished && int(known) < view.frame.tiles_done) {
    std::vector<bool> timed(size_t(view.frame.tiles_total));
    for (const FrameTimeline::Tile& tile : timeline.value_or(FrameTimeline()).tiles) {
      if (tile.tile < timed.size()) timed[tile.tile] = true;
    }
    for (const uint32_t tile : parts_.journal->Tiles(view.key)) {
      if (tile < timed.size() && !timed[tile]) answer["tiles"].push_back({tile, nullptr, nullptr});
    }
  }
  return Answer(answer, response);
}

absl::Status Routes::GetPicture(const Farm::FrameView& view, const Request& request, Response& response) {
  SL_ASSIGN_OR_RETURN(const int side, NumberParameter<int32_t>(request, "side", FramePictures::kMinSide,
                                                               FramePictures::kMaxSide, 1280));
  if (view.frame.state != FrameState::kFinished)
    return absl::FailedPreconditionError("the frame is not finished; ask for its tiles");
  const std::string tag = absl::StrCat("\"", view.frame.digest.ToHex(), "-", side, "\"");
  response.set_header("ETag", tag);
  if (request.get_header_value("If-None-Match") == tag) {
    response.status = 304;
    return absl::OkStatus();
  }
  SL_ASSIGN_OR_RETURN(const std::string png, pictures_.Finished(view, side));
  response.set_content(png, "image/png");
  return absl::OkStatus();
}

absl::Status Routes::GetEvents(const Request& request, Response& response) {
  uint64_t after = 0;
  const std::string last = request.get_header_value("Last-Event-ID");
  if (!last.empty() && !absl::SimpleAtoi(last, &after))
    return absl::InvalidArgumentError("Last-Event-ID: must be the number of an event");
  const std::string job_id = request.get_param_value("job");
  if (!job_id.empty()) SL_RETURN_IF_ERROR(parts_.farm->Get(job_id).status());
  if (!gate_.Enter()) {
    return absl::UnavailableError(absl::StrCat("there are ", StreamGate::kMaxStreams,
                                               " readers of events already, or the end is near"));
  }
  const auto stream =
      std::make_shared<EventStream>(*parts_.farm, *parts_.throughput, *parts_.clock, job_id, after);
  const auto first = std::make_shared<bool>(true);
  response.set_header("X-Accel-Buffering", "no");
  response.set_chunked_content_provider(
      "text/event-stream",
      [this, stream, first](size_t, httplib::DataSink& sink) {
        if (!std::exchange(*first, false) && !gate_.Wait(kLook)) return false;
        std::string text = stream->Next();
        // A reader that has gone is noticed by the farm's event at the latest.
        return text.empty() || sink.write(text.data(), text.size());
      },
      [this](bool) { gate_.Leave(); });
  return absl::OkStatus();
}

absl::StatusOr<JobSnapshot> Routes::Control(const std::string& job_id, const std::string& action) {
  if (action == "cancel") return parts_.farm->Cancel(job_id);
  if (action == "pause") return parts_.farm->SetPaused(job_id, true);
  if (action == "resume") return parts_.farm->SetPaused(job_id, false);
  if (action == "retry") return parts_.farm->Retry(job_id);
  return absl::InvalidArgumentError(absl::StrCat("action: ", LogValue(action.substr(0, 80)),
                                                 " is none of cancel, pause, resume and retry"));
}

absl::Status Routes::Post(const Request& request, Response& response) {
  const HttpRequestFacts facts = FactsOf(request);
  SL_RETURN_IF_ERROR(parts_.may_control(facts));
  const Path path = absl::StrSplit(absl::string_view(request.path).substr(1), '/');
  const std::string job_id(path[2]);
  const Json body = Json::parse(request.body, nullptr, /*allow_exceptions=*/false);
  if (!body.is_object() || !body.contains("action") || !body["action"].is_string())
    return absl::InvalidArgumentError(R"(the body must be {"action": "cancel"}, or pause, resume or retry)");
  const std::string action = body["action"].get<std::string>();
  SL_ASSIGN_OR_RETURN(const JobSnapshot job, Control(job_id, action));
  spdlog::info("job controlled over HTTP job={} action={} from={}", job.id, action, facts.remote_address);
  return Answer(ToJson(job), response);
}

}  // namespace shutterline::server
