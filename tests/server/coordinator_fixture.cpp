#include "tests/server/coordinator_fixture.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <grpcpp/grpcpp.h>

#include <cstring>

#include "common/base/check.h"
#include "common/base/ids.h"
#include "common/image/exr.h"
#include "proto/convert/job_spec.h"
#include "tests/server/fake_worker.h"

namespace shutterline::test {

std::string TriangleGltf() {
  const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::string buffer = absl::Base64Escape({reinterpret_cast<const char*>(positions), sizeof positions});
  return absl::StrCat(
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)",
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)",
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",)",
      R"("min":[0,0,0],"max":[1,1,0]}],"bufferViews":[{"buffer":0,"byteLength":36}],)",
      R"("buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)", buffer, R"("}]})");
}

CoordinatorFixture::CoordinatorFixture() {
  config_.data_dir = folder_.path() + "/data";
  config_.stream_grace = absl::Milliseconds(50);
  StartCoordinator();
}

CoordinatorFixture::~CoordinatorFixture() {
  StopCoordinator();
}

void CoordinatorFixture::StartCoordinator() {
  auto coordinator = server::Coordinator::Start(config_);
  SL_CHECK(coordinator.ok());
  coordinator_ = *std::move(coordinator);
  channel_ = coordinator_->InProcessChannel();
  jobs_ = v1::Jobs::NewStub(channel_);
  blobs_ = v1::Blobs::NewStub(channel_);
}

void CoordinatorFixture::StopCoordinator() {
  jobs_.reset();
  blobs_.reset();
  channel_.reset();
  coordinator_.reset();
}

grpc::Status CoordinatorFixture::Write(const Digest& digest, const std::string& content, size_t from,
                                       size_t to, v1::Committed& committed) {
  grpc::ClientContext context;
  const auto writer = blobs_->Write(&context, &committed);
  constexpr size_t kPiece = 1000;
  for (size_t at = from; at == from || at < to; at += kPiece) {
    v1::BlobChunk chunk;
    *chunk.mutable_digest() = convert::ToProto(digest);
    chunk.set_size_bytes(content.size());
    chunk.set_offset(at);
    chunk.set_data(content.substr(at, std::min(kPiece, to - at)));
    if (!writer->Write(chunk)) break;
  }
  writer->WritesDone();
  return writer->Finish();
}

SceneFile CoordinatorFixture::Upload(const std::string& name, const std::string& content) {
  const Digest digest = Sha256(content);
  v1::Committed committed;
  SL_CHECK(Write(digest, content, 0, content.size(), committed).ok());
  SL_CHECK(committed.complete());
  return {name, digest, content.size()};
}

v1::SubmitRequest CoordinatorFixture::TriangleJob(int first, int last, int width, int height) {
  JobSpec spec;
  spec.name = "triangle";
  spec.scene.root_name = "triangle.gltf";
  spec.scene.files = {Upload("triangle.gltf", TriangleGltf())};
  spec.frames = {first, last, 1};
  spec.render.width = width;
  spec.render.height = height;
  spec.output.pixel_type = PixelType::kFloat;
  v1::SubmitRequest request;
  request.set_request_id(MakeUuid());
  *request.mutable_spec() = convert::ToProto(spec);
  return request;
}

grpc::Status CoordinatorFixture::Submit(const v1::SubmitRequest& request, v1::Job& job) {
  grpc::ClientContext context;
  return jobs_->Submit(&context, request, &job);
}

v1::Job CoordinatorFixture::SubmitOrDie(const v1::SubmitRequest& request) {
  v1::Job job;
  const grpc::Status status = Submit(request, job);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return job;
}

v1::Job CoordinatorFixture::Get(const std::string& job_id) {
  grpc::ClientContext context;
  v1::JobRef ref;
  ref.set_job_id(job_id);
  v1::Job job;
  EXPECT_TRUE(jobs_->Get(&context, ref, &job).ok());
  return job;
}

grpc::Status CoordinatorFixture::Control(const std::string& job_id, v1::ControlRequest::Action action,
                                         v1::Job& job, int priority) {
  grpc::ClientContext context;
  v1::ControlRequest request;
  request.set_job_id(job_id);
  request.set_action(action);
  request.set_priority(priority);
  return jobs_->Control(&context, request, &job);
}

v1::Job CoordinatorFixture::ControlOrDie(const std::string& job_id, v1::ControlRequest::Action action,
                                         int priority) {
  v1::Job job;
  const grpc::Status status = Control(job_id, action, job, priority);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return job;
}

grpc::Status CoordinatorFixture::Cancel(const std::string& job_id, v1::Job& job) {
  return Control(job_id, v1::ControlRequest::ACTION_CANCEL, job);
}

v1::Job CoordinatorFixture::WaitForEnd(const std::string& job_id, std::vector<v1::JobEvent>* events,
                                       uint64_t after_seq) {
  grpc::ClientContext context;
  v1::WatchRequest request;
  request.set_job_id(job_id);
  request.set_after_seq(after_seq);
  const auto reader = jobs_->Watch(&context, request);
  v1::JobEvent event;
  v1::Job last;
  while (reader->Read(&event)) {
    if (event.has_job()) last = event.job();
    if (events != nullptr) events->push_back(event);
  }
  const grpc::Status status = reader->Finish();
  EXPECT_TRUE(status.ok()) << status.error_message();
  return last;
}

void CoordinatorFixture::WatchUntil(const std::string& job_id,
                                    const std::function<bool(const v1::Job&)>& reached) {
  grpc::ClientContext context;
  v1::WatchRequest request;
  request.set_job_id(job_id);
  const auto reader = jobs_->Watch(&context, request);
  v1::JobEvent event;
  bool is_reached = false;
  while (!is_reached && reader->Read(&event)) is_reached = event.has_job() && reached(event.job());
  EXPECT_TRUE(is_reached) << "the job ended before: " << event.ShortDebugString();
  context.TryCancel();
  reader->Finish();
}

grpc::Status CoordinatorFixture::Fetch(const std::string& job_id, int frame, uint64_t offset,
                                       std::string& bytes, v1::FrameChunk& first) {
  grpc::ClientContext context;
  v1::FrameRequest request;
  request.set_job_id(job_id);
  request.set_frame(frame);
  request.set_offset(offset);
  const auto reader = jobs_->FetchFrame(&context, request);
  v1::FrameChunk chunk;
  bool is_first = true;
  while (reader->Read(&chunk)) {
    EXPECT_EQ(chunk.offset(), offset + bytes.size());
    if (is_first) first = chunk;
    is_first = false;
    bytes += chunk.data();
  }
  return reader->Finish();
}

void CoordinatorFixture::ExpectSyntheticFrame(const std::string& job_id, int frame, int width, int height) {
  std::string bytes;
  v1::FrameChunk first;
  const grpc::Status status = Fetch(job_id, frame, 0, bytes, first);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(first.size_bytes(), bytes.size());
  EXPECT_EQ(convert::FromProto(first.digest(), "digest").value(), Sha256(bytes));
  const absl::StatusOr<Image> image = DecodeExr(bytes, "frame");
  ASSERT_TRUE(image.ok()) << image.status();
  ASSERT_EQ(image->width(), width);
  ASSERT_EQ(image->height(), height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float expected[4];
      SyntheticPixel(frame, x, y, expected);
      ASSERT_EQ(std::memcmp(image->At(x, y), expected, sizeof expected), 0) << "pixel " << x << ", " << y;
    }
  }
}

}  // namespace shutterline::test
