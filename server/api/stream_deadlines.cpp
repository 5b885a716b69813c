#include "server/api/stream_deadlines.h"

#include <utility>
#include <vector>

namespace shutterline::server {

StreamDeadlines::Id StreamDeadlines::Add(absl::Duration within, std::function<void()> expire) {
  absl::MutexLock lock(&mutex_);
  entries_.emplace(++last_id_, Entry{clock_.Monotonic() + within, std::move(expire)});
  return last_id_;
}

void StreamDeadlines::Cancel(Id id) {
  absl::MutexLock lock(&mutex_);
  entries_.erase(id);
  if (running_ != id || runner_ == std::this_thread::get_id()) return;
  const auto ended = [this, id]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return running_ != id; };
  mutex_.Await(absl::Condition(&ended));
}

void StreamDeadlines::Tick() {
  std::vector<Id> due;
  {
    absl::MutexLock lock(&mutex_);
    const absl::Duration now = clock_.Monotonic();
    for (const auto& [id, entry] : entries_) {
      if (entry.deadline <= now) due.push_back(id);
    }
  }
  for (const Id id : due) {
    std::function<void()> expire;
    {
      absl::MutexLock lock(&mutex_);
      const auto entry = entries_.find(id);
      if (entry == entries_.end()) continue;
      expire = std::move(entry->second.expire);
      entries_.erase(entry);
      running_ = id;
      runner_ = std::this_thread::get_id();
    }
    expire();
    absl::MutexLock lock(&mutex_);
    running_.reset();
  }
}

}  // namespace shutterline::server
