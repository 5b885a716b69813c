#include "client/frame_fetch.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <memory>
#include <optional>
#include <utility>

#include "client/output_path.h"
#include "client/part_file.h"
#include "common/base/status_macros.h"
#include "common/image/exr.h"
#include "common/image/png.h"
#include "proto/convert/job_spec.h"

namespace shutterline::client {
namespace {

/// What the first chunk of a stream says of the whole file.
struct FileFacts {
  Digest digest;
  uint64_t bytes = 0;

  friend bool operator==(const FileFacts&, const FileFacts&) = default;
};

absl::StatusOr<FileFacts> FactsOf(const v1::FrameChunk& first) {
  SL_ASSIGN_OR_RETURN(const Digest digest, convert::FromProto(first.digest(), "digest"));
  return FileFacts{digest, first.size_bytes()};
}

/// One FetchFrame stream from the part's end on. `facts` is set by its first chunk; where it was set by
/// an earlier stream, both must agree. OUT_OF_RANGE where the part is longer than the file.
absl::Status ReadStream(Connection& connection, const v1::FrameRequest& request, PartFile& part,
                        std::optional<FileFacts>& facts, Backoff& backoff) {
  grpc::ClientContext context;
  Interrupt::Guard guard(connection.options().interrupt, [&context] { context.TryCancel(); });
  const auto reader = connection.jobs().FetchFrame(&context, request);
  // A stream that is left early must be cancelled and drained, or Finish would wait for the rest.
  const auto leave = [&](const absl::Status& reason) {
    context.TryCancel();
    static_cast<void>(reader->Finish());
    return reason;
  };
  v1::FrameChunk chunk;
  bool first = true;
  while (reader->Read(&chunk)) {
    if (first) {
      const absl::StatusOr<FileFacts> named = FactsOf(chunk);
      if (!named.ok()) return leave(named.status());
      if (facts && *facts != *named) {
        return leave(absl::DataLossError("the frame's file changed between two streams"));
      }
      facts = *named;
      first = false;
    }
    if (chunk.offset() != part.size() || chunk.data().size() > facts->bytes - part.size()) {
      return leave(absl::DataLossError(absl::StrCat("a chunk of ", chunk.data().size(), " bytes at offset ",
                                                    chunk.offset(), " does not follow the ", part.size(),
                                                    " of ", facts->bytes, " bytes that came")));
    }
    if (const absl::Status status = part.Append(chunk.data()); !status.ok()) return leave(status);
    if (!chunk.data().empty()) backoff.Progress();
  }
  SL_RETURN_IF_ERROR(convert::FromGrpc(reader->Finish()));
  if (!facts || part.size() != facts->bytes) {
    return absl::UnavailableError(absl::StrCat("the stream ended after ", part.size(), " bytes"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<FetchedFrame> FetchFrame(Connection& connection, const std::string& job_id, int frame,
                                        const std::string& path, bool png) {
  const std::string what = absl::StrCat("fetch frame ", frame);
  SL_ASSIGN_OR_RETURN(const std::unique_ptr<PartFile> part,
                      PartFile::Open(path, FramePartTag(job_id, frame)));
  bool inherited = part->size() > 0;
  std::optional<FileFacts> facts;
  Backoff backoff(connection.options().retry, connection.options().interrupt);
  v1::FrameRequest request;
  request.set_job_id(job_id);
  request.set_frame(frame);
  while (true) {
    request.set_offset(part->size());
    absl::Status status = ReadStream(connection, request, *part, facts, backoff);
    if (status.ok()) status = part->Commit(facts->digest);
    if (status.ok()) break;
    const bool wrong_bytes = absl::IsDataLoss(status) || absl::IsOutOfRange(status);
    if (wrong_bytes && inherited) {
      // What an earlier process left is not this file's beginning.
      inherited = false;
      facts.reset();
      SL_RETURN_IF_ERROR(part->Restart());
      continue;
    }
    if (connection.PauseAfter(backoff, status)) continue;
    // What came so far is worth keeping if the next attempt may go on from there.
    const bool resumable =
        part->size() > 0 && !wrong_bytes && (absl::IsUnavailable(status) || absl::IsCancelled(status));
    if (!resumable) part->Discard();
    return connection.Explain(status, what);
  }

  FetchedFrame result{frame, path, facts->bytes, facts->digest, ""};
  if (png) {
    SL_ASSIGN_OR_RETURN(const Image image, ReadExr(path));
    result.preview = OutputPath::PreviewOf(path);
    SL_RETURN_IF_ERROR(WritePng(result.preview, image));
  }
  return result;
}

}  // namespace shutterline::client
