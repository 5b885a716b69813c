#pragma once

#include <absl/status/statusor.h>

#include <vector>

#include "server/config/config.h"
#include "server/control/events.h"
#include "server/schedule/worker_registry.h"
#include "shutterline/v1/jobs.pb.h"
#include "shutterline/v1/workers.pb.h"

/// The farm's structs to and from messages.
namespace shutterline::server {

/// How much of the specification a job message carries.
enum class SpecDetail { kNone, kWithoutFiles, kFull };

v1::Job ToMessage(const JobSnapshot& job, SpecDetail detail);
void AddQuarantined(const std::vector<QuarantinedTile>& tiles, v1::Job& job);
v1::FrameStatus ToMessage(const FrameSnapshot& frame);
v1::Worker ToMessage(const WorkerSnapshot& worker);
v1::JobEvent ToMessage(const JobChange& change);
v1::CoordinatorMessage ToMessage(const WorkerEvent& event);
v1::Capabilities CapabilitiesOf(const Config& config, const CoordinatorIdentity& identity, uint64_t epoch);
v1::ResultAck::Outcome ToMessage(ReportOutcome outcome);

JobWishes WishesOf(const v1::SubmitRequest& request);
absl::StatusOr<std::vector<HeldLease>> HeldOf(const v1::Open& open);
WorkerHello FromMessage(const v1::Hello& hello);
/// Takes the pixels out of the message. INVALID_ARGUMENT where it holds neither pixels nor a failure.
absl::StatusOr<TileReport> TakeReport(v1::TileResult& result);

}  // namespace shutterline::server
