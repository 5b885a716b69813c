#include <absl/strings/str_cat.h>
#include <grpcpp/grpcpp.h>

#include <map>
#include <random>
#include <utility>

#include "common/base/check.h"
#include "common/base/ids.h"
#include "proto/convert/job_spec.h"
#include "server/api/messages.h"
#include "server/coordinator.h"
#include "shutterline/v1/blobs.grpc.pb.h"
#include "shutterline/v1/jobs.grpc.pb.h"
#include "shutterline/v1/workers.grpc.pb.h"
#include "tests/fuzz/fuzz_tile_result.h"
#include "tests/fuzz/message_mutator.h"
#include "tests/support/gltf_builder.h"
#include "tests/support/temporary_folder.h"

namespace shutterline {
namespace {

using Outcome = v1::ResultAck::Outcome;

constexpr int kFrames = 1000, kTiles = 4, kSide = 64;
constexpr size_t kPixelBytes = size_t{32} * 32 * 4 * sizeof(float);

}  // namespace

struct ResultStreamFuzzer::Parts {
  Parts();
  ~Parts() { CloseStream(); }

  void OpenStream();
  grpc::Status CloseStream();
  /// Pushes the batch; what is broken, or nothing.
  std::string Push(v1::ResultBatch batch);
  std::string Judge(const v1::TileResult& tile, Outcome outcome);

  test::TemporaryFolder folder;
  std::unique_ptr<server::Coordinator> coordinator;
  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::Workers::Stub> workers;
  std::string job_id;
  v1::Welcome welcome;
  std::unique_ptr<grpc::ClientContext> session_context, context;
  std::unique_ptr<grpc::ClientReaderWriter<v1::WorkerMessage, v1::CoordinatorMessage>> session;
  std::unique_ptr<grpc::ClientReaderWriter<v1::ResultBatch, v1::ResultAck>> stream;
  std::map<std::pair<int, uint32_t>, std::string> stored;  ///< By frame and tile: pixels.
  std::map<int, int> stored_in_frame;
};

ResultStreamFuzzer::Parts::Parts() {
  server::Config config;
  config.data_dir = absl::StrCat(folder.path(), "/data");
  config.max_tile_failures = INT32_MAX;  // A job that has failed takes nothing any more.
  config.commit_interval = absl::ZeroDuration();
  auto started = server::Coordinator::Start(config);
  SL_CHECK(started.ok());
  coordinator = *std::move(started);
  channel = coordinator->InProcessChannel();

  GltfBuilder scene;
  scene.DrawTriangle();
  const std::string file = scene.Glb();
  JobSpec spec;
  spec.scene.root_name = "triangle.glb";
  spec.scene.files.push_back({"triangle.glb", Sha256(file), file.size()});
  spec.frames = {0, kFrames - 1, 1};
  spec.render.width = spec.render.height = kSide;
  {
    grpc::ClientContext upload;
    v1::Committed committed;
    const auto writer = v1::Blobs::NewStub(channel)->Write(&upload, &committed);
    v1::BlobChunk chunk;
    *chunk.mutable_digest() = convert::ToProto(Sha256(file));
    chunk.set_size_bytes(file.size());
    chunk.set_data(file);
    writer->Write(chunk);
    writer->WritesDone();
    SL_CHECK(writer->Finish().ok());
  }
  grpc::ClientContext submit;
  v1::SubmitRequest request;
  request.set_request_id("fuzz");
  *request.mutable_spec() = convert::ToProto(spec);
  v1::Job job;
  SL_CHECK(v1::Jobs::NewStub(channel)->Submit(&submit, request, &job).ok());
  job_id = job.id();

  workers = v1::Workers::NewStub(channel);
  v1::Hello hello;
  hello.set_worker_uuid("fuzzer");
  hello.set_boot_id("boot");
  hello.mutable_protocol()->set_low(1);
  hello.mutable_protocol()->set_high(1);
  grpc::ClientContext capabilities;
  v1::Capabilities can;
  SL_CHECK(v1::Jobs::NewStub(channel)->GetCapabilities(&capabilities, {}, &can).ok());
  hello.set_build_id(can.build_id());
  hello.set_isa("fuzz");
  hello.set_slots(1);
  grpc::ClientContext registration;
  SL_CHECK(workers->Register(&registration, hello, &welcome).ok());
  session_context = std::make_unique<grpc::ClientContext>();
  session = workers->Session(session_context.get());
  v1::WorkerMessage open;
  open.mutable_open()->set_session_id(welcome.session_id());
  open.mutable_open()->set_epoch(welcome.epoch());
  session->Write(open);
  OpenStream();
}

void ResultStreamFuzzer::Parts::OpenStream() {
  context = std::make_unique<grpc::ClientContext>();
  stream = workers->PushResults(context.get());
  v1::ResultBatch introduction;
  introduction.set_session_id(welcome.session_id());
  introduction.set_epoch(welcome.epoch());
  stream->Write(introduction);
  // Keeps the session's leases (it has none) and the session itself.
  v1::WorkerMessage beat;
  beat.mutable_heartbeat();
  session->Write(beat);
}

grpc::Status ResultStreamFuzzer::Parts::CloseStream() {
  stream->WritesDone();
  v1::ResultAck ignored;
  while (stream->Read(&ignored)) {
  }
  return stream->Finish();
}

std::string ResultStreamFuzzer::Parts::Judge(const v1::TileResult& tile, Outcome outcome) {
  const auto wrong = [&](const char* rule) {
    return absl::StrCat("frame ", tile.frame(), " tile ", tile.tile(), ": ",
                        v1::ResultAck::Outcome_Name(outcome), ", but ", rule);
  };
  if (tile.job_id() != job_id) return outcome == v1::ResultAck::OUTCOME_UNWANTED ? "" : wrong("of no job");
  const bool fits = tile.frame() >= 0 && tile.frame() < kFrames && tile.tile() < kTiles &&
                    (tile.has_failure() || tile.pixels().size() == kPixelBytes);
  if (!fits) return outcome == v1::ResultAck::OUTCOME_REFUSED ? "" : wrong("it does not fit");
  // Once all are there the frame is written, some time, and then nothing is wanted.
  const bool full = stored_in_frame[tile.frame()] == kTiles;
  if (full && outcome == v1::ResultAck::OUTCOME_UNWANTED) return "";
  // Where it was written between the look at the job and the journal's, the journal has forgotten the first
  // by then: the second is taken, and dropped at once.
  if (full && outcome == v1::ResultAck::OUTCOME_STORED && !tile.has_failure()) return "";
  if (tile.has_failure()) return outcome == v1::ResultAck::OUTCOME_STORED ? "" : wrong("a failure is noted");
  const auto [entry, is_new] = stored.try_emplace({tile.frame(), tile.tile()}, tile.pixels());
  if (is_new) {
    ++stored_in_frame[tile.frame()];
    return outcome == v1::ResultAck::OUTCOME_STORED ? "" : wrong("it is the first");
  }
  if (entry->second == tile.pixels())
    return outcome == v1::ResultAck::OUTCOME_DUPLICATE ? "" : wrong("it is the same");
  return outcome == v1::ResultAck::OUTCOME_MISMATCH ? "" : wrong("it differs");
}

std::string ResultStreamFuzzer::Parts::Push(v1::ResultBatch batch) {
  if (batch.tiles().empty()) return "";
  bool well_formed = batch.SerializeAsString().size() < (1 << 20);
  for (const v1::TileResult& tile : batch.tiles()) {
    v1::TileResult copy = tile;
    well_formed = well_formed && server::TakeReport(copy).ok();
  }
  v1::ResultAck ack;
  if (!stream->Write(batch) || !stream->Read(&ack)) {
    const grpc::Status status = stream->Finish();
    OpenStream();
    if (well_formed) return absl::StrCat("the stream ended: ", status.error_message());
    return status.error_code() == grpc::StatusCode::INVALID_ARGUMENT
               ? ""
               : absl::StrCat("ended with code ", int(status.error_code()), ": ", status.error_message());
  }
  if (!well_formed) return "a malformed batch was acknowledged";
  if (ack.batch_id() != batch.batch_id()) return "another batch was acknowledged";
  if (ack.outcomes_size() != batch.tiles_size()) return "not one outcome for each tile";
  for (int i = 0; i < batch.tiles_size(); ++i) {
    if (std::string broken = Judge(batch.tiles(i), ack.outcomes(i)); !broken.empty()) return broken;
  }
  return "";
}

ResultStreamFuzzer::ResultStreamFuzzer() : parts_(std::make_unique<Parts>()) {}
ResultStreamFuzzer::~ResultStreamFuzzer() = default;

std::string ResultStreamFuzzer::Fuzz(uint64_t seed) {
  // A job that has all its tiles ends, and then wants nothing: before that, another one.
  constexpr size_t kLeft = 256;
  if (parts_->stored.size() + kLeft > size_t(kFrames) * kTiles) parts_ = std::make_unique<Parts>();
  std::mt19937_64 random(seed);
  v1::ResultBatch batch = ValidBatch(parts_->job_id, random);
  for (v1::TileResult& tile : *batch.mutable_tiles()) tile.set_frame(int(random() % kFrames));
  if (random() % 4 != 0) MutateFields(batch, random);
  // Only text that a message may carry can be sent at all.
  v1::ResultBatch sent;
  if (!sent.ParseFromString(batch.SerializeAsString())) return "";
  std::string broken = parts_->Push(std::move(sent));
  return broken.empty() ? "" : absl::StrCat("result stream: ", broken);
}

}  // namespace shutterline
