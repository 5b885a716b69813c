#pragma once

#include <absl/status/status.h>

#include <cstdint>

namespace shutterline::worker {

/// From now on this process gets no more than `bytes` of memory to write to, stacks included: what asks for
/// more fails, as std::bad_alloc, which fails a tile, instead of the machine looking for somebody to kill.
/// To be called before threads are made.
absl::Status LimitMemory(uint64_t bytes);

}  // namespace shutterline::worker
