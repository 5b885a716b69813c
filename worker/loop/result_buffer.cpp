#include "worker/loop/result_buffer.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

namespace shutterline::worker {

bool ResultBuffer::WaitForRoom() {
  absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(this, &ResultBuffer::HasRoomLocked));
  return !closed_;
}

void ResultBuffer::Add(TileResult result) {
  absl::MutexLock lock(&mutex_);
  bytes_ += result.Bytes();
  gather_.Add(result.Bytes(), clock_.Monotonic());
  unsent_.push_back(std::make_shared<const TileResult>(std::move(result)));
}

void ResultBuffer::DropForgottenLocked() {
  std::erase_if(unsent_, [this](const Result& result) {
    if (!result->task.job->forgotten) return false;
    bytes_ -= result->Bytes();
    gather_.Remove(result->Bytes());
    return true;
  });
}

ResultBuffer::Batch ResultBuffer::NextBatch(size_t max_bytes) {
  absl::MutexLock lock(&mutex_);
  // A buffer that is about to be full does not wait for what finds no room in it.
  const size_t enough_bytes = std::min(max_bytes, max_bytes_) / 2;
  Batch batch;
  while (true) {
    const absl::Duration due = gather_.Due(enough_bytes);
    const auto woken = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return interrupted_ || closed_ || gather_.Due(enough_bytes) != due;
    };
    if (interrupted_ || closed_) return batch;
    if (const absl::Duration now = clock_.Monotonic(); now < due) {
      mutex_.AwaitWithTimeout(absl::Condition(&woken), due - now);
      continue;
    }
    DropForgottenLocked();
    if (!unsent_.empty()) break;
  }
  size_t bytes = 0;
  while (!unsent_.empty() && (batch.results.empty() || bytes + unsent_.front()->Bytes() <= max_bytes)) {
    bytes += unsent_.front()->Bytes();
    gather_.Remove(unsent_.front()->Bytes());
    batch.results.push_back(std::move(unsent_.front()));
    unsent_.pop_front();
  }
  batch.id = next_batch_++;
  under_way_.push_back(batch);
  return batch;
}

void ResultBuffer::SetPace(absl::Duration pace) {
  absl::MutexLock lock(&mutex_);
  gather_.SetPace(pace);
}

bool ResultBuffer::Hurry() {
  absl::MutexLock lock(&mutex_);
  return gather_.Hurry();
}

void ResultBuffer::Interrupt() {
  absl::MutexLock lock(&mutex_);
  interrupted_ = true;
}

absl::StatusOr<std::vector<ResultBuffer::Result>> ResultBuffer::Acknowledge(uint64_t id, size_t count) {
  absl::MutexLock lock(&mutex_);
  if (under_way_.empty() || under_way_.front().id != id) {
    return absl::NotFoundError(absl::StrCat("batch ", id, " is not the next to be acknowledged"));
  }
  if (under_way_.front().results.size() != count) {
    return absl::InvalidArgumentError(absl::StrCat("batch ", id, " has ", under_way_.front().results.size(),
                                                   " tiles, but ", count, " were acknowledged"));
  }
  std::vector<Result> results = std::move(under_way_.front().results);
  under_way_.pop_front();
  for (const Result& result : results) bytes_ -= result->Bytes();
  return results;
}

void ResultBuffer::Rewind() {
  absl::MutexLock lock(&mutex_);
  while (!under_way_.empty()) {
    std::vector<Result>& results = under_way_.back().results;
    for (auto it = results.rbegin(); it != results.rend(); ++it) {
      gather_.Add((*it)->Bytes(), clock_.Monotonic());
      unsent_.push_front(std::move(*it));
    }
    under_way_.pop_back();
  }
  gather_.Hurry();
  next_batch_ = 1;
  interrupted_ = false;
}

bool ResultBuffer::Empty() const {
  absl::MutexLock lock(&mutex_);
  return EmptyLocked();
}

size_t ResultBuffer::size() const {
  absl::MutexLock lock(&mutex_);
  size_t count = unsent_.size();
  for (const Batch& batch : under_way_) count += batch.results.size();
  return count;
}

bool ResultBuffer::WaitUntilEmpty(absl::Duration timeout) const {
  absl::MutexLock lock(&mutex_);
  return mutex_.AwaitWithTimeout(absl::Condition(this, &ResultBuffer::EmptyLocked), timeout);
}

void ResultBuffer::Close() {
  absl::MutexLock lock(&mutex_);
  closed_ = true;
}

}  // namespace shutterline::worker
