#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/connection.h"
#include "shutterline/v1/blobs.grpc.pb.h"
#include "shutterline/v1/jobs.grpc.pb.h"

namespace shutterline::client {

/// A coordinator whose connections break where the test says: a real gRPC server in this process over a
/// scripted service. Stores blobs for real and serves frames and events that the test lays down.
class FakeFarm final : public v1::Jobs::Service, public v1::Blobs::Service {
 public:
  FakeFarm();
  ~FakeFarm() override;

  /// Short pauses, so that nothing waits; the interrupt may be null.
  Connection::Options FastOptions(Interrupt* interrupt = nullptr);
  std::shared_ptr<grpc::Channel> Channel() { return server_->InProcessChannel({}); }
  std::unique_ptr<Connection> Connect(Interrupt* interrupt = nullptr);

  // --- What the test lays down, before any call --------------------------------------------------
  std::map<int, std::string> frames;     ///< The EXR files by frame; others are unfinished.
  std::map<int, std::string> digest_of;  ///< What to call a frame's bytes instead of their digest.
  std::vector<v1::JobEvent> events;      ///< Of every job, in order.
  v1::Job job;                           ///< What Submit, Get and Control return.
  std::deque<uint64_t> cuts;             ///< Each stream breaks after that many bytes (events, for Watch).
  bool whole_chunks = false;             ///< Of a chunk that a cut hits, nothing is kept; it came too late.
  size_t chunk_bytes = 1000;             ///< Of FetchFrame.
  int unavailable_calls = 0;             ///< So many unary calls fail first.
  uint32_t protocol_low = 1, protocol_high = 1;
  uint64_t max_blob_bytes = 1 << 24;

  // --- What the test looks at, after the calls ---------------------------------------------------
  std::map<std::string, std::string> blobs;     ///< Complete, by SHA-256.
  std::map<std::string, std::string> partial;   ///< Begun.
  uint64_t bytes_received = 0, bytes_sent = 0;  ///< Payload of Write and of FetchFrame.
  std::vector<uint64_t> offsets;                ///< At which FetchFrame was asked to start.
  std::vector<uint64_t> after_seqs;             ///< With which Watch was asked.
  std::vector<v1::SubmitRequest> submits;
  int streams = 0;

  // --- The services ------------------------------------------------------------------------------
  grpc::Status GetCapabilities(grpc::ServerContext*, const v1::CapabilitiesRequest*,
                               v1::Capabilities* reply) override;
  grpc::Status Submit(grpc::ServerContext*, const v1::SubmitRequest* request, v1::Job* reply) override;
  grpc::Status Get(grpc::ServerContext*, const v1::JobRef*, v1::Job* reply) override;
  grpc::Status Watch(grpc::ServerContext*, const v1::WatchRequest* request,
                     grpc::ServerWriter<v1::JobEvent>* writer) override;
  grpc::Status FetchFrame(grpc::ServerContext*, const v1::FrameRequest* request,
                          grpc::ServerWriter<v1::FrameChunk>* writer) override;
  grpc::Status FindMissing(grpc::ServerContext*, const v1::DigestList* request,
                           v1::DigestList* reply) override;
  grpc::Status QueryWrite(grpc::ServerContext*, const v1::Digest* request, v1::Committed* reply) override;
  grpc::Status Write(grpc::ServerContext*, grpc::ServerReader<v1::BlobChunk>* reader,
                     v1::Committed* reply) override;

 private:
  /// How many bytes the next stream carries before it breaks.
  uint64_t NextCut();
  grpc::Status Unary();

  std::unique_ptr<grpc::Server> server_;
};

/// An event that says how a job stands.
v1::JobEvent JobEventOf(uint64_t seq, v1::JobState state, uint32_t frames_finished, uint32_t frames_total);
/// An event that says that a frame is finished.
v1::JobEvent FrameEventOf(uint64_t seq, int frame);

}  // namespace shutterline::client
