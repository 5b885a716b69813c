#include "client/job_submission.h"

#include <absl/strings/str_cat.h>

#include <string>
#include <utility>

#include "client/human.h"
#include "common/base/ids.h"
#include "common/base/status_macros.h"
#include "proto/convert/job_spec.h"
#include "worker/engine/scene/environment.h"

namespace shutterline::client {
namespace {

/// What the coordinator would refuse is refused before anything travels.
absl::Status CheckSizes(const SceneManifest& scene, uint64_t max_file_bytes) {
  for (const SceneFile& file : scene.files) {
    if (file.size <= max_file_bytes) continue;
    const std::string name =
        file.name == engine::kEnvironmentFile ? "the environment" : absl::StrCat("file '", file.name, "'");
    return absl::ResourceExhaustedError(absl::StrCat("load scene ", scene.root_name, ": ", name, " has ",
                                                     file.size, " bytes, but the coordinator takes at most ",
                                                     max_file_bytes));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Submission> SubmitJob(Connection& connection, const JobOptions& options, SceneReading& scene,
                                     const v1::SubmitRequest& wishes, Progress& progress) {
  SL_ASSIGN_OR_RETURN(const v1::Capabilities capabilities, Greet(connection));
  SL_ASSIGN_OR_RETURN(SceneFiles files, scene.Get());
  JobSpec spec;
  spec.scene = files.manifest();
  spec.name = spec.scene.root_name;
  spec.frames = options.frames;
  spec.render = options.settings;
  spec.output = options.output_settings;
  spec.order = options.order;
  // What the coordinator would refuse is refused before its files travel.
  JobLimits limits;
  limits.max_frames = capabilities.max_frames();
  limits.max_tiles = static_cast<int64_t>(capabilities.max_tiles());
  limits.max_manifest_files = capabilities.max_manifest_files();
  limits.max_name_bytes = capabilities.max_name_bytes();
  SL_RETURN_IF_ERROR(Validate(spec, limits));
  SL_RETURN_IF_ERROR(CheckSizes(spec.scene, capabilities.max_blob_bytes()));

  Submission submission;
  SL_ASSIGN_OR_RETURN(submission.upload, Upload(connection, files, [&](uint64_t sent, uint64_t total) {
                        ProgressFacts facts;
                        facts.state = "uploading";
                        facts.unit = "kB";
                        facts.done = static_cast<int64_t>(sent / 1000);
                        facts.total = static_cast<int64_t>(total / 1000);
                        progress.Update(facts);
                      }));
  progress.Note(absl::StrCat(Printable(spec.name), ": ", Describe(submission.upload)));

  v1::SubmitRequest request = wishes;
  request.set_request_id(MakeUuid());  // One for all repetitions: the job is made once.
  *request.mutable_spec() = convert::ToProto(spec);
  SL_ASSIGN_OR_RETURN(submission.job, connection.Repeat<v1::Job>(
                                          "submit the job",
                                          [&](auto* context, auto* reply) {
                                            return connection.jobs().Submit(context, request, reply);
                                          },
                                          kSubmitDeadline));
  if (options.order != TileOrder::kHilbert && submission.job.spec().order() != request.spec().order()) {
    progress.Note(absl::StrCat("the server knows no --order ", ToString(options.order),
                               ": tiles come as they always did"));
  }
  return submission;
}

}  // namespace shutterline::client
