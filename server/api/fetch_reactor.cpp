#include "server/api/fetch_reactor.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "common/base/status_macros.h"
#include "proto/convert/job_spec.h"
#include "server/api/limits.h"

namespace shutterline::server {

FetchReactor::FetchReactor(Farm& farm, WorkPool& pool, StreamLimits& limits, const v1::FrameRequest& request)
    : DownloadReactor(pool), farm_(farm), request_(request) {
  Start(limits);
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
  digest_ = frame.digest;
  return absl::OkStatus();
}

absl::StatusOr<bool> FetchReactor::Next(v1::FrameChunk& chunk) {
  SL_ASSIGN_OR_RETURN(std::string data, file_->ReadAt(offset_, kChunkBytes));
  if (data.empty() && offset_ < size_) return absl::DataLossError("the frame's file is shorter than it was");
  if (offset_ == request_.offset()) {  // The first.
    *chunk.mutable_digest() = convert::ToProto(digest_);
    chunk.set_size_bytes(size_);
  }
  chunk.set_offset(offset_);
  offset_ += data.size();
  chunk.set_data(std::move(data));
  return true;
}

std::optional<absl::Status> FetchReactor::End() {
  return offset_ >= size_ ? std::optional(absl::OkStatus()) : std::nullopt;
}

}  // namespace shutterline::server
