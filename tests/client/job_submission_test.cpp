#include "client/job_submission.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <sstream>
#include <string>

#include "client/scene_source.h"
#include "tests/client/fake_farm.h"
#include "tests/client/temp_folder.h"
#include "worker/engine/scene/environment.h"

namespace shutterline::client::job_submission_test {
namespace {

class JobSubmission : public testing::Test {
 protected:
  JobSubmission() {
    folder_.Write("scene.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":4}]})");
    folder_.Write("a.bin", std::string(1000, 'a'));
    options_.scene = folder_.File("scene.gltf");
  }

  absl::StatusOr<Submission> Submit() {
    SceneReading scene(options_, &interrupt_);
    std::ostringstream out;
    Progress progress(ProgressStyle::kQuiet, out);
    return SubmitJob(*farm_.Connect(), options_, scene, {}, progress);
  }

  TempFolder folder_;
  FakeFarm farm_;
  JobOptions options_;
  Interrupt interrupt_;
};

TEST_F(JobSubmission, TheJobNamesTheFilesThatTravelled) {
  const auto submission = Submit();
  ASSERT_TRUE(submission.ok()) << submission.status();
  EXPECT_EQ(submission->upload.files_uploaded, 2);
  ASSERT_EQ(farm_.submits.size(), 1u);
  const v1::SceneManifest& scene = farm_.submits[0].spec().scene();
  ASSERT_EQ(scene.files_size(), 2);
  for (const v1::SceneFile& file : scene.files()) {
    EXPECT_EQ(farm_.blobs.at(file.digest().sha256()), folder_.Read(file.name())) << file.name();
  }
}

TEST_F(JobSubmission, WhatTheCoordinatorWouldRefuseDoesNotTravel) {
  farm_.max_blob_bytes = 999;
  const auto submission = Submit();
  EXPECT_EQ(submission.status().code(), absl::StatusCode::kResourceExhausted) << submission.status();
  EXPECT_NE(submission.status().message().find("'a.bin' has 1000 bytes"), absl::string_view::npos)
      << submission.status();
  EXPECT_EQ(farm_.bytes_received, 0u);
  EXPECT_TRUE(farm_.submits.empty());
}

TEST_F(JobSubmission, ASceneThatCannotBeReadIsSaid) {
  options_.scene = folder_.File("none.gltf");
  EXPECT_EQ(Submit().status().code(), absl::StatusCode::kNotFound);
  options_.scene = folder_.File("a.bin");
  EXPECT_EQ(Submit().status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(farm_.bytes_received, 0u);
}

TEST_F(JobSubmission, AnInterruptEndsTheReadingBetweenTwoFiles) {
  interrupt_.Raise();
  const auto submission = Submit();
  EXPECT_EQ(submission.status().code(), absl::StatusCode::kCancelled) << submission.status();
  EXPECT_EQ(farm_.bytes_received, 0u);
}

TEST_F(JobSubmission, ASceneThatIsNotWantedAnyMoreIsNotReadToItsEnd) {
  std::filesystem::remove(folder_.File("a.bin"));  // It would be missed.
  std::atomic<bool> stop = true;
  auto source = OpenSceneSource(options_.scene, "");
  ASSERT_TRUE(source.ok()) << source.status();
  const auto files = SceneFiles::Read(*std::move(source), {}, &stop);
  EXPECT_EQ(files.status().code(), absl::StatusCode::kCancelled) << files.status();
  { const SceneReading reading(options_, nullptr); }  // Returns.
}

TEST_F(JobSubmission, NoFileOfASceneGoesByTheNameOfItsEnvironment) {
  const std::string name(engine::kEnvironmentFile);
  folder_.Write("scene.gltf", R"({"asset":{"version":"2.0"},"images":[{"uri":")" + name + R"("}]})");
  folder_.Write(name, "anything");
  const auto submission = Submit();
  EXPECT_EQ(submission.status().code(), absl::StatusCode::kInvalidArgument) << submission.status();
  EXPECT_NE(submission.status().message().find(name), absl::string_view::npos) << submission.status();
}

}  // namespace
}  // namespace shutterline::client::job_submission_test
