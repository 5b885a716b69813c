#include "server/api/blob_reactors.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "common/base/status_macros.h"
#include "proto/convert/job_spec.h"
#include "proto/convert/status.h"
#include "server/api/limits.h"

namespace shutterline::server {

BlobWriteReactor::BlobWriteReactor(AssetStore& store, WorkPool& pool, StreamLimits& limits,
                                   grpc::CallbackServerContext* context, v1::Committed* response)
    : store_(store), pool_(pool), limits_(limits), context_(context), response_(response) {
  if (const absl::Status taken = slot_.Take(limits_.uploads); !taken.ok()) {
    End(taken);
    return;
  }
  ReadNext();
}

void BlobWriteReactor::ReadNext() {
  absl::MutexLock lock(&mutex_);
  stall_deadline_ = limits_.deadlines.Add(limits_.config.upload_stall, [this] { Expire(); });
  reading_ = true;
  StartRead(&chunk_);
}

void BlobWriteReactor::Expire() {
  {
    absl::MutexLock lock(&mutex_);
    if (!reading_ || finished_) return;
    finished_ = true;
  }
  Close(absl::DeadlineExceededError(
      absl::StrCat("no chunk came for ", absl::FormatDuration(limits_.config.upload_stall))));
}

void BlobWriteReactor::OnDone() {
  StreamDeadlines::Id deadline = 0;
  {
    absl::MutexLock lock(&mutex_);
    deadline = stall_deadline_;
  }
  limits_.deadlines.Cancel(deadline);
  delete this;
}

void BlobWriteReactor::OnReadDone(bool ok) {
  StreamDeadlines::Id deadline = 0;
  {
    absl::MutexLock lock(&mutex_);
    reading_ = false;
    if (finished_) return;
    deadline = stall_deadline_;
  }
  limits_.deadlines.Cancel(deadline);
  const bool accepted = pool_.Run([this, ok] {
    // Both ends of a stream look like this: the writer is done, or it is gone.
    if (!ok) return End(context_->IsCancelled() ? absl::CancelledError("the writer went away") : Complete());
    const absl::Status status = Store();
    if (!status.ok() || response_->complete()) return End(status);
    ReadNext();
  });
  if (!accepted) End(absl::UnavailableError("the coordinator is stopping"));
}

absl::Status BlobWriteReactor::Begin() {
  begun_ = true;
  SL_ASSIGN_OR_RETURN(const Digest digest, convert::FromProto(chunk_.digest(), "digest"));
  SL_ASSIGN_OR_RETURN(const CommittedBlob blob, store_.Query(digest));
  if (blob.complete) {
    response_->set_size_bytes(blob.size);
    response_->set_complete(true);
    return absl::OkStatus();
  }
  SL_RETURN_IF_ERROR(share_.Take(limits_.upload_quota, chunk_.size_bytes()));
  position_ = chunk_.offset();
  SL_ASSIGN_OR_RETURN(writer_, store_.Write(digest, chunk_.size_bytes(), position_));
  return absl::OkStatus();
}

absl::Status BlobWriteReactor::Store() {
  if (!begun_) {
    SL_RETURN_IF_ERROR(Begin());
    if (response_->complete()) return absl::OkStatus();
  }
  if (chunk_.offset() != position_) {
    return absl::OutOfRangeError(
        absl::StrCat("offset: is ", chunk_.offset(), ", but the last chunk ended at ", position_));
  }
  SL_RETURN_IF_ERROR(writer_->Append(chunk_.data()));
  position_ += chunk_.data().size();
  return absl::OkStatus();
}

absl::Status BlobWriteReactor::Complete() {
  if (!begun_) return absl::InvalidArgumentError("the stream ended before its first chunk");
  SL_ASSIGN_OR_RETURN(const CommittedBlob blob, writer_->Finish());
  response_->set_size_bytes(blob.size);
  response_->set_complete(blob.complete);
  return absl::OkStatus();
}

void BlobWriteReactor::End(const absl::Status& status) {
  {
    absl::MutexLock lock(&mutex_);
    finished_ = true;
  }
  Close(status);
}

void BlobWriteReactor::Close(const absl::Status& status) {
  // All given back before the client hears of the end, so that it may write again at once.
  writer_.reset();
  share_.Release();
  slot_.Release();
  Finish(convert::ToGrpc(status));
}

BlobReadReactor::BlobReadReactor(AssetStore& store, WorkPool& pool, StreamLimits& limits,
                                 const v1::ReadRequest& request)
    : DownloadReactor(pool), store_(store), request_(request) {
  Start(limits);
}

absl::Status BlobReadReactor::Open() {
  SL_ASSIGN_OR_RETURN(digest_, convert::FromProto(request_.digest(), "digest"));
  SL_ASSIGN_OR_RETURN(size_, store_.Size(digest_));
  offset_ = request_.offset();
  if (offset_ > size_) {
    return absl::OutOfRangeError(
        absl::StrCat("offset: is ", offset_, ", but the blob has ", size_, " bytes"));
  }
  return absl::OkStatus();
}

absl::StatusOr<bool> BlobReadReactor::Next(v1::BlobChunk& chunk) {
  SL_ASSIGN_OR_RETURN(std::string data, store_.Read(digest_, offset_, kChunkBytes));
  if (data.empty() && offset_ < size_) return absl::DataLossError("the blob is shorter than it was");
  if (request_.offset() == 0) hash_.Update(data);
  if (offset_ == request_.offset()) {  // The first.
    *chunk.mutable_digest() = request_.digest();
    chunk.set_size_bytes(size_);
  }
  chunk.set_offset(offset_);
  offset_ += data.size();
  chunk.set_data(std::move(data));
  return true;
}

absl::Status BlobReadReactor::Verify() {
  if (request_.offset() != 0 || hash_.Finish() == digest_) return absl::OkStatus();
  store_.ReportDamage(digest_);
  return absl::DataLossError(
      absl::StrCat("blob ", digest_.ToHex(), ": the disk holds other bytes; upload it again"));
}

std::optional<absl::Status> BlobReadReactor::End() {
  return offset_ >= size_ ? std::optional(Verify()) : std::nullopt;
}

}  // namespace shutterline::server
