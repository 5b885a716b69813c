#include <CLI/CLI.hpp>

#include "common/base/lock_order.h"
#include "tests/bench/service/service_bench.h"

// service-bench [results] [workers] [overhead] [OPTIONS]: what the coordinator manages, and what it costs.
int main(int argc, char** argv) {
  shutterline::TrustLockOrder();
  using shutterline::bench::ServiceOptions;
  ServiceOptions options;
  CLI::App app("Measures the service: durable results, many workers, overhead over the bare engine.",
               "service-bench");
  std::vector<std::string> parts;
  app.add_option("part", parts, "results, workers, overhead; all of them unless named")
      ->check(CLI::IsMember({"results", "workers", "overhead"}));
  app.add_option("--durability", options.durability, "Only `power` or `process`")
      ->check(CLI::IsMember({"power", "process"}));
  app.add_option("--tiles", options.tiles, "results: tiles")->capture_default_str();
  app.add_option("--connections", options.connections, "results: workers that push")->capture_default_str();
  app.add_option("--workers", options.workers, "workers: how many are connected")->capture_default_str();
  app.add_option("--tile-ms", options.tile_ms, "workers: what a tile takes")->capture_default_str();
  app.add_option("--seconds", options.seconds, "workers: measured seconds")->capture_default_str();
  app.add_option("--tile-width", options.tile_width, "Pixels; 32 makes tiles of 16 KiB")
      ->check(CLI::Range(1, 32))
      ->capture_default_str();
  app.add_option("--size", options.size, "overhead: of the frame")->capture_default_str();
  app.add_option("--scene", options.scene, "overhead: which scene of shutterline-scenes")
      ->capture_default_str();
  app.add_option("--repeats", options.repeats, "overhead: runs of each, of which the fastest counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (parts.empty()) parts = {"results", "workers", "overhead"};
  std::vector<std::string> durabilities = {"power", "process"};
  if (!options.durability.empty()) durabilities = {options.durability};
  bool sound = true;
  for (const std::string& part : parts) {
    if (part == "overhead") sound = MeasureOverhead(options) && sound;
    for (const std::string& durability : durabilities) {
      if (part == "results") sound = MeasureResults(options, durability) && sound;
      if (part == "workers") sound = MeasureWorkers(options, durability) && sound;
    }
  }
  return sound ? 0 : 1;
}
