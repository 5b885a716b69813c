#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>
#include <httplib.h>

#include <vector>

#include "server/http/event_stream.h"
#include "server/http/frame_pictures.h"
#include "server/http/http_server.h"
#include "server/http/to_json.h"

namespace shutterline::server {

/// Which path answers what. Thread-safe.
class Routes {
 public:
  explicit Routes(HttpServer::Parts parts);

  void Install(httplib::Server& server);
  /// Streams end, and none begins.
  void EndStreams() { gate_.Close(); }

 private:
  using Path = std::vector<absl::string_view>;  ///< Between the slashes.
  using Request = httplib::Request;
  using Response = httplib::Response;

  absl::Status Get(const Request& request, Response& response);
  absl::Status GetApi(const Path& path, const Request& request, Response& response);
  absl::Status GetFrame(const std::string& job_id, const Path& path, const Request& request,
                        Response& response);
  absl::Status GetTiles(const std::string& job_id, const Farm::FrameView& view, const Request& request,
                        Response& response);
  absl::Status GetPicture(const Farm::FrameView& view, const Request& request, Response& response);
  absl::Status GetEvents(const Request& request, Response& response);
  absl::Status GetFile(absl::string_view name, const Request& request, Response& response);
  absl::Status Post(const Request& request, Response& response);
  absl::StatusOr<JobSnapshot> Control(const std::string& job_id, const std::string& action);
  absl::StatusOr<Json> Jobs(const Request& request);
  Json Overview(const Request& request);

  const HttpServer::Parts parts_;
  FramePictures pictures_;
  StreamGate gate_;
};

}  // namespace shutterline::server
