#pragma once

#include <absl/time/time.h>

#include <cstdint>

#include "server/control/events.h"

namespace shutterline::server {

/// How many workers would finish what is left within `target`: what an autoscaler should aim at.
///
/// Not the depth of the queue: a scaler that divides depth by a constant pins the farm at its maximum as
/// long as tiles are many, however short they are, and starts machines for work that is over before they are
/// up. Here the work that remains is measured in seconds of a thread, at the recent times of each job's
/// tiles, and a worker counts with as many threads as the connected ones have on average (one, where none is
/// connected). Never more workers than can have a tile each for every thread; 0 without work; at least 1 with
/// some, because only a worker can measure the tiles of a job that is new.
int64_t DesiredWorkers(const FarmTotals& totals, absl::Duration target);

}  // namespace shutterline::server
