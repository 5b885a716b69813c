#include "server/assets/blob_ledger.h"

#include "common/base/check.h"

namespace shutterline::server {

void BlobLedger::Set(const Digest& digest, uint64_t bytes, absl::Duration now) {
  Remove(digest);
  const uint64_t turn = next_turn_++;
  entries_[digest] = {bytes, turn, now};
  order_[turn] = digest;
  bytes_ += bytes;
}

void BlobLedger::Touch(const Digest& digest, absl::Duration now) {
  const auto entry = entries_.find(digest);
  if (entry == entries_.end()) return;
  order_.erase(entry->second.turn);
  entry->second.turn = next_turn_++;
  entry->second.used = now;
  order_[entry->second.turn] = digest;
}

void BlobLedger::Remove(const Digest& digest) {
  const auto entry = entries_.find(digest);
  if (entry == entries_.end()) return;
  bytes_ -= entry->second.bytes;
  order_.erase(entry->second.turn);
  entries_.erase(entry);
}

void BlobLedger::Pin(const Digest& digest) {
  ++pins_[digest];
}

void BlobLedger::Unpin(const Digest& digest) {
  const auto pin = pins_.find(digest);
  SL_CHECK(pin != pins_.end());
  if (--pin->second == 0) pins_.erase(pin);
}

std::optional<std::vector<Digest>> BlobLedger::Victims(uint64_t most, absl::Duration now) const {
  std::vector<Digest> victims;
  uint64_t left = bytes_;
  for (auto next = order_.begin(); left > most; ++next) {
    if (next == order_.end()) return std::nullopt;
    const Entry& entry = entries_.at(next->second);
    if (Pinned(next->second) || now - entry.used < grace_) continue;
    victims.push_back(next->second);
    left -= entry.bytes;
  }
  return victims;
}

}  // namespace shutterline::server
