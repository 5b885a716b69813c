#include "server/api/fetch_reactor.h"

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "proto/convert/job_spec.h"
#include "proto/convert/status.h"
#include "server/api/limits.h"

namespace shutterline::server {

FetchReactor::FetchReactor(Farm& farm, WorkPool& pool, StreamLimits& limits, const v1::FrameRequest& request)
    : farm_(farm), pool_(pool), request_(request) {
  if (const absl::Status taken = slot_.Take(limits.downloads); !taken.ok()) {
    Finish(convert::ToGrpc(taken));
    return;
  }
  const bool accepted = pool_.Run([this] {
    const absl::Status status = Open();
    if (!status.ok()) return Finish(convert::ToGrpc(status));
    Next();
  });
  if (!accepted) Finish(grpc::Status(grpc::StatusCode::UNAVAILABLE, "the coordinator is stopping"));
}

absl::Status FetchReactor::Open() {
  SL_ASSIGN_OR_RETURN(const auto found, farm_.FindFrame(request_.job_id(), request_.frame()));
  const auto& [frame, path] = found;
  size_ = frame.size;
  offset_ = request_.offset();
  if (offset_ > size_) {
    return absl::OutOfRangeError(
        absl::StrCat("offset: is ", offset_, ", but the frame has ", size_, " bytes"));
  }
  absl::StatusOr<File> file = File::OpenToRead(path);
  if (!file.ok()) return absl::DataLossError(absl::StrCat("the frame's file: ", file.status().message()));
  file_ = *std::move(file);
  *chunk_.mutable_digest() = convert::ToProto(frame.digest);
  chunk_.set_size_bytes(size_);
  return absl::OkStatus();
}

void FetchReactor::Next() {
  absl::StatusOr<std::string> data = file_->ReadAt(offset_, kChunkBytes);
  if (data.ok() && data->empty() && offset_ < size_) {
    data = absl::DataLossError("the frame's file is shorter than it was");
  }
  if (!data.ok()) return Finish(convert::ToGrpc(data.status()));
  chunk_.set_offset(offset_);
  offset_ += data->size();
  chunk_.set_data(*std::move(data));
  StartWrite(&chunk_);
}

void FetchReactor::OnWriteDone(bool ok) {
  if (!ok) return Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the reader went away"));
  if (offset_ >= size_) return Finish(grpc::Status::OK);
  chunk_.clear_digest();
  chunk_.clear_size_bytes();
  if (!pool_.Run([this] { Next(); })) {
    Finish(grpc::Status(grpc::StatusCode::UNAVAILABLE, "the coordinator is stopping"));
  }
}

}  // namespace shutterline::server
