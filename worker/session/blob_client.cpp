#include "worker/session/blob_client.h"

#include <absl/strings/str_cat.h>

#include <optional>
#include <utility>

#include "common/base/status_macros.h"
#include "proto/convert/job_spec.h"
#include "proto/convert/status.h"

namespace shutterline::worker {

BlobClient::BlobClient(std::shared_ptr<grpc::Channel> channel, const Options& options, const Clock& clock)
    : stub_(v1::Blobs::NewStub(channel)), options_(options), clock_(clock) {}

absl::StatusOr<std::string> BlobClient::Fetch(const Digest& digest, uint64_t max_bytes) {
  std::string bytes;
  size_t seen = 0;
  absl::Duration progress_at = clock_.Monotonic();
  Backoff backoff(clock_, options_.backoff, absl::Hash<Digest>()(digest));
  while (true) {
    const absl::Status status = ReadOn(digest, max_bytes, bytes);
    if (status.ok()) return bytes;
    if (!absl::IsUnavailable(status)) return status;
    if (bytes.size() > seen) {
      seen = bytes.size();
      progress_at = clock_.Monotonic();
    }
    if (clock_.Monotonic() - progress_at >= options_.patience) return status;
    const absl::Duration until = clock_.Monotonic() + backoff.NextDelay();
    absl::MutexLock lock(&mutex_);
    while (!cancelled_ && clock_.Monotonic() < until) {
      changed_.WaitWithTimeout(&mutex_, until - clock_.Monotonic());
    }
  }
}

absl::Status BlobClient::ReadOn(const Digest& digest, uint64_t max_bytes, std::string& bytes) {
  grpc::ClientContext context;
  {
    absl::MutexLock lock(&mutex_);
    if (cancelled_) return absl::CancelledError("the worker was stopped");
    calls_.insert(&context);
  }
  v1::ReadRequest request;
  *request.mutable_digest() = convert::ToProto(digest);
  request.set_offset(bytes.size());
  const auto stream = stub_->Read(&context, request);
  absl::Status problem;
  std::optional<uint64_t> size;
  v1::BlobChunk chunk;
  while (problem.ok() && stream->Read(&chunk)) {
    if (!size) size = chunk.size_bytes();
    if (*size > max_bytes) {
      problem = absl::ResourceExhaustedError(
          absl::StrCat("has ", *size, " bytes, more than the limit of ", max_bytes));
    } else if (chunk.offset() != bytes.size() || *size < bytes.size() ||
               chunk.data().size() > *size - bytes.size()) {
      problem =
          absl::DataLossError(absl::StrCat("a chunk of ", chunk.data().size(), " bytes at ", chunk.offset(),
                                           " does not follow ", bytes.size(), " of ", *size, " bytes"));
    } else {
      bytes.append(chunk.data());
    }
  }
  if (!problem.ok()) context.TryCancel();
  const absl::Status end = convert::FromGrpc(stream->Finish());
  {
    absl::MutexLock lock(&mutex_);
    calls_.erase(&context);
  }
  SL_RETURN_IF_ERROR(problem);
  SL_RETURN_IF_ERROR(end);
  if (size && bytes.size() != *size) {
    return absl::DataLossError(absl::StrCat("ended after ", bytes.size(), " of ", *size, " bytes"));
  }
  return absl::OkStatus();
}

void BlobClient::Cancel() {
  absl::MutexLock lock(&mutex_);
  cancelled_ = true;
  for (grpc::ClientContext* call : calls_) call->TryCancel();
  changed_.SignalAll();
}

}  // namespace shutterline::worker
