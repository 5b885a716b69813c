#include "client/job_log.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <utility>

namespace shutterline::client {
namespace {

std::string Field(absl::string_view name, std::optional<int> value) {
  return value ? absl::StrCat(name, "=", *value) : "";
}

bool HasField(absl::string_view line, absl::string_view field) {
  const auto words = absl::StrSplit(line, ' ');
  return field.empty() || std::find(words.begin(), words.end(), field) != words.end();
}

}  // namespace

absl::Status ReadJobLog(Connection& connection, const std::string& job_id, uint64_t& offset,
                        const std::function<void(absl::string_view)>& on_text) {
  Backoff backoff(connection.options().retry, connection.options().interrupt);
  while (true) {
    grpc::ClientContext context;
    Interrupt::Guard guard(connection.options().interrupt, [&context] { context.TryCancel(); });
    v1::LogRequest request;
    request.set_job_id(job_id);
    request.set_offset(offset);
    const auto reader = connection.jobs().ReadLog(&context, request);
    v1::LogChunk chunk;
    while (reader->Read(&chunk)) {
      if (chunk.offset() != offset || chunk.data().empty()) {
        context.TryCancel();
        static_cast<void>(reader->Finish());
        return absl::InternalError(absl::StrCat("read the log: the server sent bytes from ", chunk.offset(),
                                                " on, where those from ", offset, " on were asked for"));
      }
      backoff.Progress();
      offset += chunk.data().size();
      on_text(chunk.data());
    }
    const absl::Status status = convert::FromGrpc(reader->Finish());
    if (status.ok()) return status;
    if (!connection.PauseAfter(backoff, status)) {
      return connection.Explain(status, absl::StrCat("read the log of job ", job_id));
    }
  }
}

LogFilter::LogFilter(std::optional<int> frame, std::optional<int> tile, OnLine on_line)
    : frame_field_(Field("frame", frame)), tile_field_(Field("tile", tile)), on_line_(std::move(on_line)) {}

void LogFilter::Judge(absl::string_view line) const {
  if (HasField(line, frame_field_) && HasField(line, tile_field_)) on_line_(line);
}

void LogFilter::Add(absl::string_view piece) {
  while (true) {
    const size_t end = piece.find('\n');
    absl::StrAppend(&unfinished_, piece.substr(0, end));
    if (end == absl::string_view::npos) return;
    Judge(unfinished_);
    unfinished_.clear();
    piece.remove_prefix(end + 1);
  }
}

void LogFilter::Rest() {
  if (!unfinished_.empty()) Judge(unfinished_);
  unfinished_.clear();
}

}  // namespace shutterline::client
