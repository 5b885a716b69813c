#pragma once

#include <absl/status/statusor.h>

#include "client/connection.h"
#include "client/options.h"
#include "client/progress.h"
#include "client/scene_reading.h"
#include "client/upload.h"

namespace shutterline::client {

struct Submission {
  v1::Job job;
  UploadReport upload;
};

/// Waits for the job's scene, uploads those of its files that the coordinator lacks and submits the job: what
/// `render` and `submit` have in common. Once this returns OK, the job is on the coordinator's disk. `wishes`
/// has what the request asks for beside the specification.
absl::StatusOr<Submission> SubmitJob(Connection& connection, const JobOptions& options, SceneReading& scene,
                                     const v1::SubmitRequest& wishes, Progress& progress);

}  // namespace shutterline::client
