// Durable results a second, and what they cost the coordinator.
#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <grpcpp/grpcpp.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <thread>

#include "common/base/build_id.h"
#include "common/base/ids.h"
#include "common/job/tile.h"
#include "proto/convert/protocol.h"
#include "tests/bench/service/service_bench.h"

namespace shutterline::bench {
namespace {

constexpr int kBatch = 16;   ///< Tiles a message.
constexpr int kWindow = 16;  ///< Messages that wait for their acknowledgement.

/// Pushes tiles first, first + step, ... of the job; false where the stream breaks or a tile is not stored.
bool Push(const std::string& address, const std::string& job, int first, int step, int tiles, size_t bytes) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const auto stub =
      v1::Workers::NewStub(grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
  const v1::Welcome welcome = RegisterWorker(*stub, MakeUuid());
  grpc::ClientContext session_context, results_context;
  const auto session = stub->Session(&session_context);
  v1::WorkerMessage open;
  open.mutable_open()->set_session_id(welcome.session_id());
  open.mutable_open()->set_epoch(welcome.epoch());
  session->Write(open);
  const auto stream = stub->PushResults(&results_context);
  const std::string pixels(bytes, '\0');
  bool sound = true;
  int outstanding = 0;
  const auto read = [&] {
    v1::ResultAck ack;
    if (!stream->Read(&ack)) return false;
    for (const int outcome : ack.outcomes()) sound = sound && outcome == v1::ResultAck::OUTCOME_STORED;
    --outstanding;
    return sound;
  };
  uint64_t batches = 0;
  for (int tile = first; tile < tiles && sound;) {
    v1::ResultBatch batch;
    batch.set_session_id(welcome.session_id());
    batch.set_epoch(welcome.epoch());
    batch.set_batch_id(++batches);
    for (int i = 0; i < kBatch && tile < tiles; ++i, tile += step) {
      v1::TileResult& result = *batch.add_tiles();
      result.set_job_id(job);
      result.set_tile(uint32_t(tile));
      result.set_pixels(pixels);
      result.mutable_render_time()->set_nanos(1'000'000);
    }
    sound = stream->Write(batch);
    if (++outstanding == kWindow) sound = sound && read();
  }
  while (sound && outstanding > 0) sound = read();
  session_context.TryCancel();
  results_context.TryCancel();
  session->Finish();
  stream->Finish();
  return sound;
}

}  // namespace

absl::Duration CpuOf(int pid) {
  std::ifstream file(absl::StrCat("/proc/", pid, "/stat"));
  std::string text((std::istreambuf_iterator<char>(file)), {});
  // The program's name, which may hold anything, ends at the last parenthesis; times are fields 14 and 15.
  std::istringstream fields(text.substr(text.rfind(')') + 1));
  std::string word;
  for (int i = 3; i < 14; ++i) fields >> word;
  double user = 0, system = 0;
  fields >> user >> system;
  return absl::Seconds((user + system) / double(::sysconf(_SC_CLK_TCK)));
}

v1::Welcome RegisterWorker(v1::Workers::Stub& stub, const std::string& uuid) {
  v1::Hello hello;
  hello.set_worker_uuid(uuid);
  hello.set_boot_id(MakeUuid());
  hello.mutable_protocol()->set_low(convert::kProtocolLow);
  hello.mutable_protocol()->set_high(convert::kProtocolHigh);
  hello.set_build_id(kBuildId);
  hello.set_isa("bench");
  hello.set_slots(1);
  hello.set_name("bench");
  grpc::ClientContext context;
  v1::Welcome welcome;
  const grpc::Status status = stub.Register(&context, hello, &welcome);
  if (!status.ok()) std::fprintf(stderr, "register: %s\n", status.error_message().c_str());
  return welcome;
}

std::string SubmitTiles(Farm& farm, int tiles, int tile_width) {
  // A frame of whole tiles, or, for narrower ones, a single column of them.
  const int columns = tile_width == kTileSize ? int(std::ceil(std::sqrt(double(tiles)))) : 1;
  const int rows = (tiles + columns - 1) / columns;
  return farm.Submit({farm.Scene("plane"), "--size",
                      absl::StrCat(columns * tile_width, "x", rows * kTileSize), "--float", "--compression",
                      "none", "--frame", "0"});
}

bool MeasureResults(const ServiceOptions& options, const std::string& durability) {
  Farm farm;
  farm.server_flags = {"--durability", durability, "--log-level", "warn"};
  farm.StartServer();
  // One more than is pushed: the frame is not written, which is another matter.
  const std::string job = SubmitTiles(farm, options.tiles + 1, options.tile_width);
  const size_t bytes = size_t(options.tile_width) * kTileSize * 4 * sizeof(float);
  std::atomic<bool> sound = true;
  const absl::Duration cpu = CpuOf(farm.server().pid());
  const absl::Time start = absl::Now();
  std::vector<std::thread> threads;
  for (int i = 0; i < options.connections; ++i) {
    threads.emplace_back([&, i] {
      if (!Push(farm.Address(), job, i, options.connections, options.tiles, bytes)) sound = false;
    });
  }
  for (std::thread& thread : threads) thread.join();
  const absl::Duration wall = absl::Now() - start;
  const absl::Duration spent = CpuOf(farm.server().pid()) - cpu;
  std::printf(
      "results    durability=%-7s tile_bytes=%zu tiles=%d seconds=%.2f tiles_per_second=%.0f "
      "coordinator_cpu_ms_per_tile=%.4f%s\n",
      durability.c_str(), bytes, options.tiles, absl::ToDoubleSeconds(wall),
      options.tiles / absl::ToDoubleSeconds(wall), absl::ToDoubleMilliseconds(spent) / options.tiles,
      sound ? "" : "  FAILED");
  std::fflush(stdout);
  return sound;
}

}  // namespace shutterline::bench
