#include "worker/loop/result_buffer.h"

#include <absl/strings/str_cat.h>

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
  unsent_bytes_ += result.Bytes();
  unsent_.push_back(std::make_shared<const TileResult>(std::move(result)));
}

void ResultBuffer::DropForgottenLocked() {
  std::erase_if(unsent_, [this](const Result& result) {
    if (!result->task.job->forgotten) return false;
    bytes_ -= result->Bytes();
    unsent_bytes_ -= result->Bytes();
    return true;
  });
}

void ResultBuffer::Hurry() {
  absl::MutexLock lock(&mutex_);
  if (!unsent_.empty()) hurry_ = true;
}

ResultBuffer::Batch ResultBuffer::NextBatch(size_t max_bytes, absl::Duration linger) {
  absl::MutexLock lock(&mutex_);
  const auto woken = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return interrupted_ || closed_ || !unsent_.empty();
  };
  const auto enough = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return interrupted_ || closed_ || hurry_ || unsent_bytes_ >= max_bytes / 2;
  };
  Batch batch;
  while (true) {
    mutex_.Await(absl::Condition(&woken));
    if (!interrupted_ && !closed_) mutex_.AwaitWithTimeout(absl::Condition(&enough), linger);
    if (interrupted_ || closed_) return batch;
    DropForgottenLocked();
    if (!unsent_.empty()) break;
    hurry_ = false;
  }
  size_t bytes = 0;
  while (!unsent_.empty() && (batch.results.empty() || bytes + unsent_.front()->Bytes() <= max_bytes)) {
    bytes += unsent_.front()->Bytes();
    batch.results.push_back(std::move(unsent_.front()));
    unsent_.pop_front();
  }
  unsent_bytes_ -= bytes;
  if (unsent_.empty()) hurry_ = false;
  batch.id = next_batch_++;
  under_way_.push_back(batch);
  return batch;
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
      unsent_bytes_ += (*it)->Bytes();
      unsent_.push_front(std::move(*it));
    }
    under_way_.pop_back();
  }
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
