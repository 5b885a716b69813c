#pragma once

#include <absl/time/time.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "shutterline/v1/workers.grpc.pb.h"
#include "tests/integration/farm.h"

/// Measures the coordinator as a process of its own against what docs/durability.md promises of it.
namespace shutterline::bench {

struct ServiceOptions {
  int tiles = 30'000;            ///< Of `results`.
  int connections = 4;           ///< Of `results`: workers that push.
  int workers = 1000;            ///< Of `workers`.
  double tile_ms = 100;          ///< Of `workers`: what a tile takes.
  double seconds = 10;           ///< Of `workers`: measured, after as much again to settle, at most 5 s.
  int tile_width = 32;           ///< Pixels: 32 makes tiles of 16 KiB, 8 of 4 KiB.
  int repeats = 3;               ///< Of `overhead`.
  std::string size = "640x360";  ///< Of `overhead`.
  std::string scene = "debris";  ///< Of `overhead`: as `shutterline-scenes` names it.
  std::string durability;        ///< Only this one; empty: both.
};

/// Each prints a few lines. False: something went wrong.
bool MeasureResults(const ServiceOptions& options, const std::string& durability);
bool MeasureWorkers(const ServiceOptions& options, const std::string& durability);
bool MeasureOverhead(const ServiceOptions& options);

/// Processor time that a process has taken so far, all its threads, user and system.
absl::Duration CpuOf(int pid);
/// Submits a job of one frame of so many tiles at least, all of the same size, and returns its id.
std::string SubmitTiles(Farm& farm, int tiles, int tile_width);
/// Registers a worker.
v1::Welcome RegisterWorker(v1::Workers::Stub& stub, const std::string& uuid);

}  // namespace shutterline::bench
