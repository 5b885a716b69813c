#include "server/schedule/worker_registry.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

#include <algorithm>

#include "common/base/ids.h"
#include "common/base/status_macros.h"

namespace shutterline::server {
namespace {

constexpr size_t kMaxTextBytes = 256;
constexpr int64_t kMaxSlots = 4096;
constexpr size_t kMaxWorkers = 8192;  ///< Twice what may be connected: some have just gone.

absl::Status CheckText(absl::string_view field, absl::string_view text, bool may_be_empty) {
  if (text.empty() && !may_be_empty) return absl::InvalidArgumentError(absl::StrCat(field, ": is empty"));
  if (text.size() <= kMaxTextBytes) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": has ", text.size(), " bytes, but at most ", kMaxTextBytes, " may be"));
}

}  // namespace

absl::StatusOr<WorkerEntry*> WorkerRegistry::Register(const WorkerHello& hello, absl::Duration now) {
  SL_RETURN_IF_ERROR(CheckText("worker_uuid", hello.uuid, false));
  SL_RETURN_IF_ERROR(CheckText("boot_id", hello.boot_id, false));
  SL_RETURN_IF_ERROR(CheckText("build_id", hello.build_id, true));
  SL_RETURN_IF_ERROR(CheckText("isa", hello.isa, true));
  SL_RETURN_IF_ERROR(CheckText("name", hello.name, true));
  if (hello.exits.size() > kMaxWorkerExits) {
    return absl::InvalidArgumentError(absl::StrCat("exits: has ", hello.exits.size(),
                                                   " entries, but at most ", kMaxWorkerExits, " may be"));
  }
  for (const WorkerExit& exit : hello.exits) SL_RETURN_IF_ERROR(Validate(exit));
  if (hello.slots < 1 || hello.slots > kMaxSlots) {
    return absl::InvalidArgumentError(
        absl::StrCat("slots: is ", hello.slots, ", but must be 1 to ", kMaxSlots));
  }
  if (hello.protocol_low > identity_.protocol_high || hello.protocol_high < identity_.protocol_low ||
      hello.protocol_low > hello.protocol_high) {
    return absl::FailedPreconditionError(
        absl::StrCat("protocol: the worker speaks ", hello.protocol_low, " to ", hello.protocol_high,
                     ", the coordinator ", identity_.protocol_low, " to ", identity_.protocol_high));
  }
  if (hello.build_id != identity_.build_id) {
    return absl::FailedPreconditionError(
        absl::StrCat("build_id: the worker is '", absl::CHexEscape(hello.build_id), "', the coordinator '",
                     identity_.build_id, "'; pixels of different builds may differ"));
  }
  if (entries_.size() >= kMaxWorkers) {
    return absl::ResourceExhaustedError(
        absl::StrCat(kMaxWorkers, " workers are registered, and more are not taken"));
  }
  WorkerEntry& entry = entries_[next_];
  entry.id = next_++;
  entry.session_id = MakeUuid();
  entry.hello = hello;
  entry.hello.exits.clear();  // They are heard once.
  entry.protocol = std::min(hello.protocol_high, identity_.protocol_high);
  entry.registered = entry.last_heard = now;
  by_session_[entry.session_id] = entry.id;
  return &entry;
}

WorkerEntry* WorkerRegistry::Find(WorkerId id) {
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : &found->second;
}

WorkerEntry* WorkerRegistry::FindSession(absl::string_view session_id) {
  const auto found = by_session_.find(std::string(session_id));
  return found == by_session_.end() ? nullptr : Find(found->second);
}

std::vector<WorkerId> WorkerRegistry::Predecessors(const WorkerEntry& entry) const {
  std::vector<WorkerId> ids;
  for (const auto& [id, other] : entries_) {
    if (id != entry.id && other.hello.uuid == entry.hello.uuid &&
        other.hello.boot_id != entry.hello.boot_id) {
      ids.push_back(id);
    }
  }
  return ids;
}

std::vector<WorkerId> WorkerRegistry::Siblings(const WorkerEntry& entry) const {
  std::vector<WorkerId> ids;
  for (const auto& [id, other] : entries_) {
    if (id < entry.id && other.hello.uuid == entry.hello.uuid && other.hello.boot_id == entry.hello.boot_id) {
      ids.push_back(id);
    }
  }
  return ids;
}

void WorkerRegistry::Remove(WorkerId id) {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return;
  by_session_.erase(found->second.session_id);
  entries_.erase(found);
}

}  // namespace shutterline::server
