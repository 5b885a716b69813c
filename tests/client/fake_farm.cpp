#include "tests/client/fake_farm.h"

#include <algorithm>

#include "common/asset/digest.h"
#include "proto/convert/job_spec.h"

namespace shutterline::client {

FakeFarm::FakeFarm() {
  grpc::ServerBuilder builder;
  builder.RegisterService(static_cast<v1::Jobs::Service*>(this));
  builder.RegisterService(static_cast<v1::Blobs::Service*>(this));
  server_ = builder.BuildAndStart();
}

FakeFarm::~FakeFarm() {
  server_->Shutdown();
}

Connection::Options FakeFarm::FastOptions(Interrupt* interrupt) {
  Connection::Options options;
  options.interrupt = interrupt;
  options.retry.first_pause = absl::Microseconds(100);
  options.retry.longest_pause = absl::Milliseconds(1);
  return options;
}

std::unique_ptr<Connection> FakeFarm::Connect(Interrupt* interrupt) {
  return std::make_unique<Connection>(server_->InProcessChannel({}), "the fake farm", FastOptions(interrupt));
}

uint64_t FakeFarm::NextCut() {
  ++streams;
  if (cuts.empty()) return ~uint64_t{0};
  const uint64_t cut = cuts.front();
  cuts.pop_front();
  return cut;
}

grpc::Status FakeFarm::Unary() {
  if (unavailable_calls == 0) return grpc::Status::OK;
  --unavailable_calls;
  return {grpc::StatusCode::UNAVAILABLE, "starting"};
}

grpc::Status FakeFarm::GetCapabilities(grpc::ServerContext*, const v1::CapabilitiesRequest*,
                                       v1::Capabilities* reply) {
  reply->mutable_protocol()->set_low(protocol_low);
  reply->mutable_protocol()->set_high(protocol_high);
  reply->set_build_id("fake");
  reply->set_max_frames(100'000);
  reply->set_max_tiles(1'000'000);
  reply->set_max_manifest_files(1000);
  reply->set_max_blob_bytes(max_blob_bytes);
  reply->set_max_name_bytes(1024);
  return Unary();
}

grpc::Status FakeFarm::Submit(grpc::ServerContext*, const v1::SubmitRequest* request, v1::Job* reply) {
  submits.push_back(*request);
  *reply = job;
  return Unary();
}

grpc::Status FakeFarm::Get(grpc::ServerContext*, const v1::JobRef*, v1::Job* reply) {
  *reply = job;
  return Unary();
}

grpc::Status FakeFarm::Watch(grpc::ServerContext*, const v1::WatchRequest* request,
                             grpc::ServerWriter<v1::JobEvent>* writer) {
  after_seqs.push_back(request->after_seq());
  uint64_t left = NextCut();
  for (const v1::JobEvent& event : events) {
    if (event.seq() <= request->after_seq()) continue;
    if (left-- == 0) return {grpc::StatusCode::UNAVAILABLE, "cut"};
    if (!writer->Write(event)) return grpc::Status::CANCELLED;
  }
  return grpc::Status::OK;
}

grpc::Status FakeFarm::FetchFrame(grpc::ServerContext*, const v1::FrameRequest* request,
                                  grpc::ServerWriter<v1::FrameChunk>* writer) {
  offsets.push_back(request->offset());
  const auto found = frames.find(request->frame());
  if (found == frames.end()) return {grpc::StatusCode::FAILED_PRECONDITION, "the frame is not finished"};
  const std::string& file = found->second;
  if (request->offset() > file.size()) return {grpc::StatusCode::OUT_OF_RANGE, "beyond the file"};
  const auto named = digest_of.find(request->frame());
  v1::FrameChunk chunk;
  *chunk.mutable_digest() = convert::ToProto(Sha256(named == digest_of.end() ? file : named->second));
  chunk.set_size_bytes(file.size());
  uint64_t left = NextCut();
  uint64_t offset = request->offset();
  do {
    const uint64_t count = std::min<uint64_t>({chunk_bytes, file.size() - offset, left});
    chunk.set_offset(offset);
    chunk.set_data(file.substr(offset, count));
    if (!writer->Write(chunk)) return grpc::Status::CANCELLED;
    offset += count;
    left -= count;
    bytes_sent += count;
    chunk.clear_digest();
    chunk.clear_size_bytes();
    if (left == 0 && offset < file.size()) return {grpc::StatusCode::UNAVAILABLE, "cut"};
  } while (offset < file.size());
  return grpc::Status::OK;
}

grpc::Status FakeFarm::FindMissing(grpc::ServerContext*, const v1::DigestList* request,
                                   v1::DigestList* reply) {
  for (const v1::Digest& digest : request->digests()) {
    if (!blobs.contains(digest.sha256())) *reply->add_digests() = digest;
  }
  return Unary();
}

grpc::Status FakeFarm::QueryWrite(grpc::ServerContext*, const v1::Digest* request, v1::Committed* reply) {
  if (const auto blob = blobs.find(request->sha256()); blob != blobs.end()) {
    reply->set_complete(true);
    reply->set_size_bytes(blob->second.size());
  } else {
    reply->set_size_bytes(partial[request->sha256()].size());
  }
  return Unary();
}

grpc::Status FakeFarm::Write(grpc::ServerContext*, grpc::ServerReader<v1::BlobChunk>* reader,
                             v1::Committed* reply) {
  uint64_t left = NextCut();
  v1::BlobChunk chunk;
  std::string key;
  uint64_t size = 0;
  while (reader->Read(&chunk)) {
    if (key.empty()) {
      key = chunk.digest().sha256();
      size = chunk.size_bytes();
    }
    std::string& have = partial[key];
    if (chunk.offset() != have.size()) return {grpc::StatusCode::OUT_OF_RANGE, "not the committed size"};
    if (whole_chunks && chunk.data().size() > left) {
      return {grpc::StatusCode::DEADLINE_EXCEEDED, "no chunk for too long"};
    }
    const uint64_t take = std::min<uint64_t>(left, chunk.data().size());
    have += chunk.data().substr(0, take);
    bytes_received += take;
    left -= take;
    if (left == 0 && have.size() < size) return {grpc::StatusCode::UNAVAILABLE, "cut"};
  }
  if (partial[key].size() == size) {
    if (convert::ToProto(Sha256(partial[key])).sha256() != key) {
      partial.erase(key);
      return {grpc::StatusCode::INVALID_ARGUMENT, "digest mismatch"};
    }
    blobs[key] = partial[key];
    partial.erase(key);
    reply->set_complete(true);
  }
  reply->set_size_bytes(size);
  return grpc::Status::OK;
}

v1::JobEvent JobEventOf(uint64_t seq, v1::JobState state, uint32_t frames_finished, uint32_t frames_total) {
  v1::JobEvent event;
  event.set_seq(seq);
  event.mutable_job()->set_id("0f8fad5b-d9cb-469f-a165-70867728950e");
  event.mutable_job()->set_state(state);
  event.mutable_job()->set_frames_finished(frames_finished);
  event.mutable_job()->set_frames_total(frames_total);
  return event;
}

v1::JobEvent FrameEventOf(uint64_t seq, int frame) {
  v1::JobEvent event;
  event.set_seq(seq);
  event.mutable_frame()->set_frame(frame);
  event.mutable_frame()->set_state(v1::FRAME_STATE_FINISHED);
  return event;
}

}  // namespace shutterline::client
