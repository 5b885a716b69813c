#include "server/logs/job_logs.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <optional>

#include "common/base/ids.h"
#include "common/base/status_macros.h"

namespace shutterline::server {
namespace {

constexpr absl::string_view kFull =
    "The log of this job is full: what follows is in the coordinator's alone.\n";
constexpr size_t kUuidBytes = 36;

/// The job that a message speaks of: the value of its field job. What strangers chose stands in quotes where
/// it has spaces (LogValue), so that a field within quotes is none.
std::optional<absl::string_view> JobOf(absl::string_view message) {
  constexpr absl::string_view kField = " job=";
  bool quoted = false;
  for (size_t i = 0; i < message.size(); ++i) {
    if (quoted && message[i] == '\\') {
      ++i;  // What follows is escaped.
    } else if (message[i] == '"') {
      quoted = !quoted;
    } else if (!quoted && absl::StartsWith(message.substr(i), kField)) {
      const absl::string_view id = message.substr(i + kField.size(), kUuidBytes);
      return IsUuid(id) ? std::optional(id) : std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace

absl::StatusOr<std::unique_ptr<JobLogs>> JobLogs::Open(const std::string& folder, const Options& options) {
  SL_RETURN_IF_ERROR(MakeFolders(folder, Durability::kProcess));
  std::unique_ptr<JobLogs> logs(new JobLogs(folder, options));
  AddLogListener(logs.get());
  return logs;
}

JobLogs::~JobLogs() {
  RemoveLogListener(this);
}

std::string JobLogs::Path(absl::string_view job_id) const {
  return absl::StrCat(folder_, "/", job_id, ".log");
}

absl::StatusOr<std::string> JobLogs::Read(const std::string& job_id, uint64_t offset, size_t count) const {
  if (!IsUuid(job_id)) return absl::InvalidArgumentError("is no job's id");
  const absl::StatusOr<File> file = File::OpenToRead(Path(job_id));
  if (absl::IsNotFound(file.status())) return std::string();
  SL_RETURN_IF_ERROR(file.status());
  return file->ReadAt(offset, count);
}

absl::Status JobLogs::Remove(const std::string& job_id, Durability durability) {
  if (!IsUuid(job_id)) return absl::InvalidArgumentError("is no job's id");
  absl::MutexLock lock(&mutex_);
  open_.remove_if([&](const OpenLog& log) { return log.job_id == job_id; });
  SL_RETURN_IF_ERROR(RemoveFile(Path(job_id)));
  return SyncFolder(folder_, durability);
}

void JobLogs::OnLogLine(absl::string_view line, absl::string_view message) {
  const std::optional<absl::string_view> job = JobOf(message);
  if (!job) return;
  absl::MutexLock lock(&mutex_);
  if (!Append(*job, line).ok()) {  // To log it would be to call ourselves.
    ++missing_;
    open_.clear();
  }
}

absl::StatusOr<JobLogs::OpenLog*> JobLogs::Find(absl::string_view job_id) {
  const auto found =
      std::find_if(open_.begin(), open_.end(), [&](const OpenLog& log) { return log.job_id == job_id; });
  if (found != open_.end()) {
    open_.splice(open_.begin(), open_, found);
    return &open_.front();
  }
  SL_ASSIGN_OR_RETURN(File file, File::OpenToWrite(Path(job_id)));
  SL_ASSIGN_OR_RETURN(const uint64_t size, file.Size());
  if (open_.size() >= options_.max_open_files) open_.pop_back();
  open_.push_front({std::string(job_id), std::move(file), size});
  return &open_.front();
}

absl::Status JobLogs::Append(absl::string_view job_id, absl::string_view line) {
  SL_ASSIGN_OR_RETURN(OpenLog* const log, Find(job_id));
  const auto write = [&](absl::string_view text) {
    const absl::Status status = log->file.WriteAt(log->size, text);
    if (status.ok()) log->size += text.size();
    return status;
  };
  if (log->size > options_.max_bytes) return absl::OkStatus();  // Full.
  if (missing_ > 0) {
    SL_RETURN_IF_ERROR(
        write(absl::StrCat("The disk refused ", missing_, " lines of jobs before this one.\n")));
    missing_ = 0;
  }
  SL_RETURN_IF_ERROR(write(line));
  // The line that crosses the limit is the last, so that a full log is known by its size, after a restart
  // too.
  return log->size > options_.max_bytes ? write(kFull) : absl::OkStatus();
}

}  // namespace shutterline::server
