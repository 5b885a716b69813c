#pragma once

#include <absl/status/statusor.h>

#include <future>

#include "client/connection.h"
#include "client/options.h"
#include "client/progress.h"
#include "client/scene_files.h"
#include "client/upload.h"

namespace shutterline::client {

struct Submission {
  v1::Job job;
  UploadReport upload;
};

using SceneReading = std::future<absl::StatusOr<SceneFiles>>;

/// Begins to read and hash the job's scene, in a thread of its own: the coordinator can be found, or started,
/// meanwhile. The result's destructor waits for the thread.
SceneReading StartReading(const JobOptions& options);

/// Uploads those files of the job's scene that the coordinator lacks and submits the job: what `render` and
/// `submit` have in common. Once this returns OK, the job is on the coordinator's disk.
/// `wishes` has what the request asks for beside the specification.
absl::StatusOr<Submission> SubmitJob(Connection& connection, const JobOptions& options, SceneReading scene,
                                     const v1::SubmitRequest& wishes, Progress& progress);

}  // namespace shutterline::client
