#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/asset/digest.h"

namespace shutterline::server {

/// How much of a blob is here.
struct CommittedBlob {
  uint64_t size = 0;      ///< Bytes, from the beginning.
  bool complete = false;  ///< All of it, and its digest was right.
};

/// Writes one blob from an offset on: Append* Finish. Destroyed without Finish it leaves what was written for
/// the next writer. Not thread-safe.
class BlobWriter {
 public:
  virtual ~BlobWriter() = default;
  /// INVALID_ARGUMENT where more comes than the blob has.
  virtual absl::Status Append(absl::string_view data) = 0;
  /// Where all bytes are there, verifies the digest and makes the blob durable and visible: INVALID_ARGUMENT
  /// where it is another one, and then all bytes are dropped. Otherwise says how far it came.
  virtual absl::StatusOr<CommittedBlob> Finish() = 0;
};

/// Keeps blobs from being evicted for as long as it lives. The store outlives it.
class BlobPins {
 public:
  virtual ~BlobPins() = default;
};

/// Blobs by content. A blob is visible only when it is complete, verified and on the disk. Thread-safe.
class AssetStore {
 public:
  virtual ~AssetStore() = default;

  virtual absl::StatusOr<CommittedBlob> Query(const Digest& digest) = 0;
  /// Of a blob that is not here yet. OUT_OF_RANGE where `offset` is not where the last writer stopped,
  /// ABORTED where another writer is at it, RESOURCE_EXHAUSTED where `size` is beyond the limit of a blob,
  /// or, with a retry hint, where the store or its disk is full.
  virtual absl::StatusOr<std::unique_ptr<BlobWriter>> Write(const Digest& digest, uint64_t size,
                                                            uint64_t offset) = 0;
  /// NOT_FOUND where the blob is not here.
  virtual absl::StatusOr<uint64_t> Size(const Digest& digest) = 0;
  /// Up to `count` bytes from `offset`; fewer only at the blob's end.
  virtual absl::StatusOr<std::string> Read(const Digest& digest, uint64_t offset, size_t count) = 0;
  /// Reads a whole blob and verifies it. RESOURCE_EXHAUSTED beyond `max_bytes`, DATA_LOSS where the disk does
  /// not hold what was written.
  virtual absl::StatusOr<std::string> ReadVerified(const Digest& digest, uint64_t max_bytes) = 0;
  /// A reader has found that the blob's bytes have another digest: it is not here any more, and can be
  /// uploaded again.
  virtual void ReportDamage(const Digest& digest) = 0;
  /// These are not evicted while the result lives, be they here already or not: to be called before one looks
  /// whether they are.
  virtual std::shared_ptr<const BlobPins> Pin(std::vector<Digest> digests) = 0;
};

}  // namespace shutterline::server
