#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/job/job_spec.h"
#include "server/coordinator.h"
#include "shutterline/v1/blobs.grpc.pb.h"
#include "shutterline/v1/jobs.grpc.pb.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::test {

/// A coordinator in this process on a folder of its own, and what a client does with it.
class CoordinatorFixture : public testing::Test {
 protected:
  CoordinatorFixture();
  ~CoordinatorFixture() override;

  void StartCoordinator();
  /// As a crash, but that the process lives: nothing is asked to drain.
  void StopCoordinator();

  /// Uploads and returns the file's entry for a manifest.
  SceneFile Upload(const std::string& name, const std::string& content);
  grpc::Status Write(const Digest& digest, const std::string& content, size_t from, size_t to,
                     v1::Committed& committed);
  /// A job of one triangle: frames first to last of width × height pixels.
  v1::SubmitRequest TriangleJob(int first, int last, int width, int height);
  grpc::Status Submit(const v1::SubmitRequest& request, v1::Job& job);
  v1::Job SubmitOrDie(const v1::SubmitRequest& request);
  v1::Job Get(const std::string& job_id);
  grpc::Status Cancel(const std::string& job_id, v1::Job& job);
  grpc::Status Control(const std::string& job_id, v1::ControlRequest::Action action, v1::Job& job,
                       int priority = 0);
  /// The same, which must succeed.
  v1::Job ControlOrDie(const std::string& job_id, v1::ControlRequest::Action action, int priority = 0);
  /// Watches until the job has ended; returns its last state.
  v1::Job WaitForEnd(const std::string& job_id, std::vector<v1::JobEvent>* events = nullptr,
                     uint64_t after_seq = 0);
  /// Watches until `reached` holds for the job, which must be before its end.
  void WatchUntil(const std::string& job_id, const std::function<bool(const v1::Job&)>& reached);
  grpc::Status Fetch(const std::string& job_id, int frame, uint64_t offset, std::string& bytes,
                     v1::FrameChunk& first);
  /// Fetches the frame, checks its digest and that every pixel is the synthetic one.
  void ExpectSyntheticFrame(const std::string& job_id, int frame, int width, int height);

  TemporaryFolder folder_;
  server::Config config_;
  std::unique_ptr<server::Coordinator> coordinator_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::Jobs::Stub> jobs_;
  std::unique_ptr<v1::Blobs::Stub> blobs_;
};

/// A glTF file with one triangle and its buffer inside it.
std::string TriangleGltf();

}  // namespace shutterline::test
