#pragma once

#include <cstddef>
#include <cstdint>

/// Bounds of single requests; those that a well-meaning client may meet are in Capabilities.
namespace shutterline::server {

inline constexpr uint32_t kMaxPageSize = 100;
inline constexpr uint32_t kDefaultPageSize = 50;
inline constexpr uint32_t kMaxDigests = 20'000;                  ///< Of one FindMissing.
inline constexpr size_t kChunkBytes = size_t{64} << 10;          ///< Of files that are streamed out.
inline constexpr size_t kMaxFailureBytes = 2048;                 ///< Of a tile failure's message.
inline constexpr uint64_t kMaxBatchBytes = uint64_t{1} << 20;    ///< Asked of workers.
inline constexpr size_t kMaxUncommittedBytes = size_t{8} << 20;  ///< Of one worker: then reading pauses.
inline constexpr size_t kMaxToldQuarantined = 100;               ///< Tiles of a job that Get tells of.
inline constexpr int kMaxHeartbeatLeases = 1 << 16;

}  // namespace shutterline::server
