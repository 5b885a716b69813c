#include "client/upload.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "client/human.h"
#include "common/base/status_macros.h"
#include "proto/convert/job_spec.h"

namespace shutterline::client {
namespace {

/// A message costs some hops between threads; beyond this they no longer count.
constexpr size_t kChunkBytes = 256 << 10;
/// Only whole chunks are kept, and a coordinator does not wait for ever for one: where nothing gets through,
/// smaller ones are tried, down to this.
constexpr size_t kLeastChunkBytes = 16 << 10;
constexpr int kDigestsPerCall = 1000;

/// Those of `request` that the coordinator lacks.
absl::Status AskForMissing(Connection& connection, const v1::DigestList& request, std::set<Digest>& missing) {
  SL_ASSIGN_OR_RETURN(
      const v1::DigestList reply,
      connection.Repeat<v1::DigestList>("ask for missing files", [&](auto* context, auto* list) {
        return connection.blobs().FindMissing(context, request, list);
      }));
  for (const v1::Digest& message : reply.digests()) {
    SL_ASSIGN_OR_RETURN(const Digest digest, convert::FromProto(message, "digests"));
    missing.insert(digest);
  }
  return absl::OkStatus();
}

/// The digests of `manifest` that the coordinator lacks. What it names besides is passed over by the
/// caller, who sends the manifest's files alone.
absl::StatusOr<std::set<Digest>> FindMissing(Connection& connection, const SceneManifest& manifest) {
  std::set<Digest> named, missing;
  v1::DigestList request;
  for (const SceneFile& file : manifest.files) {
    if (!named.insert(file.digest).second) continue;
    *request.add_digests() = convert::ToProto(file.digest);
    if (request.digests_size() < kDigestsPerCall) continue;
    SL_RETURN_IF_ERROR(AskForMissing(connection, request, missing));
    request.Clear();
  }
  if (request.digests_size() > 0) SL_RETURN_IF_ERROR(AskForMissing(connection, request, missing));
  return missing;
}

/// One Write stream from `offset` to the end. What the coordinator says is returned as it stands.
absl::StatusOr<v1::Committed> WriteFrom(Connection& connection, const Digest& digest,
                                        const std::string& bytes, uint64_t offset, size_t chunk_bytes,
                                        const std::function<void(uint64_t)>& sent) {
  grpc::ClientContext context;
  Interrupt::Guard guard(connection.options().interrupt, [&context] { context.TryCancel(); });
  v1::Committed committed;
  const auto writer = connection.blobs().Write(&context, &committed);
  v1::BlobChunk chunk;
  *chunk.mutable_digest() = convert::ToProto(digest);
  chunk.set_size_bytes(bytes.size());
  do {
    const size_t count = std::min<size_t>(chunk_bytes, bytes.size() - offset);
    chunk.set_offset(offset);
    chunk.set_data(bytes.data() + offset, count);
    if (!writer->Write(chunk)) break;  // The stream is over; Finish says why.
    offset += count;
    if (sent) sent(offset);
    chunk.clear_digest();
    chunk.clear_size_bytes();
  } while (offset < bytes.size());
  writer->WritesDone();
  SL_RETURN_IF_ERROR(convert::FromGrpc(writer->Finish()));
  return committed;
}

/// Uploads one blob, going on where the coordinator says that it stopped, until it is complete there.
absl::Status UploadBlob(Connection& connection, const std::string& name, const Digest& digest,
                        const std::string& bytes, const std::function<void(uint64_t)>& sent) {
  const std::string what = absl::StrCat("upload ", name);
  Backoff backoff(connection.options().retry, connection.options().interrupt);
  uint64_t furthest = 0;
  size_t chunk_bytes = kChunkBytes;
  bool tried = false;
  while (true) {
    SL_ASSIGN_OR_RETURN(const v1::Committed here,
                        connection.Repeat<v1::Committed>(what, [&](auto* context, auto* reply) {
                          return connection.blobs().QueryWrite(context, convert::ToProto(digest), reply);
                        }));
    if (here.complete()) return absl::OkStatus();
    if (here.size_bytes() > bytes.size()) {
      return absl::InternalError(absl::StrCat(what, ": ", connection.peer(), " holds ", here.size_bytes(),
                                              " of ", bytes.size(), " bytes"));
    }
    if (here.size_bytes() > furthest) {
      furthest = here.size_bytes();
      backoff.Progress();
    } else if (tried) {
      chunk_bytes = std::max(chunk_bytes / 4, kLeastChunkBytes);
    }
    tried = true;
    const auto written = WriteFrom(connection, digest, bytes, here.size_bytes(), chunk_bytes, sent);
    if (written.ok() && written->complete()) return absl::OkStatus();
    absl::Status status = written.status();
    // All of these mean "ask again where we are": the stream broke off without an error, somebody else
    // writes this very file, the size moved between the question and the answer, or a chunk took too long.
    if (written.ok() || absl::IsAborted(status) || absl::IsOutOfRange(status) ||
        absl::IsDeadlineExceeded(status)) {
      status = absl::UnavailableError(written.ok() ? "the file is not complete after all was sent"
                                                   : std::string(status.message()));
    }
    if (!connection.PauseAfter(backoff, status)) return connection.Explain(status, what);
  }
}

}  // namespace

absl::StatusOr<UploadReport> Upload(Connection& connection, SceneFiles& scene,
                                    const UploadProgress& progress) {
  const SceneManifest& manifest = scene.manifest();
  UploadReport report;
  report.files = static_cast<int64_t>(manifest.files.size());
  for (const SceneFile& file : manifest.files) report.bytes += file.size;
  SL_ASSIGN_OR_RETURN(std::set<Digest> missing, FindMissing(connection, manifest));

  uint64_t total = 0;
  std::vector<const SceneFile*> to_send;
  for (const SceneFile& file : manifest.files) {
    if (missing.erase(file.digest) == 0) continue;
    to_send.push_back(&file);
    total += file.size;
  }
  for (const SceneFile* file : to_send) {
    const absl::StatusOr<std::string> bytes = scene.Take(*file);
    if (!bytes.ok()) return Annotate(bytes.status(), absl::StrCat("upload ", file->name));
    SL_RETURN_IF_ERROR(UploadBlob(connection, file->name, file->digest, *bytes, [&](uint64_t sent) {
      if (progress) progress(report.bytes_uploaded + sent, total);
    }));
    ++report.files_uploaded;
    report.bytes_uploaded += file->size;
  }
  scene.DropBytes();
  return report;
}

std::string Describe(const UploadReport& report) {
  std::string text =
      absl::StrCat(report.files, report.files == 1 ? " file, " : " files, ", HumanBytes(report.bytes));
  if (report.files_uploaded == 0) return absl::StrCat(text, ", unchanged: 0 bytes uploaded");
  if (report.bytes_uploaded == report.bytes) return absl::StrCat(text, ": all uploaded");
  return absl::StrCat(text, ": ", HumanBytes(report.bytes_uploaded), " uploaded in ", report.files_uploaded,
                      report.files_uploaded == 1 ? " file" : " files");
}

}  // namespace shutterline::client
