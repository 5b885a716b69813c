#include "server/api/worker_service.h"

#include "proto/convert/status.h"
#include "server/api/limits.h"
#include "server/api/messages.h"
#include "server/api/results_reactor.h"
#include "server/api/session_reactor.h"

namespace shutterline::server {

grpc::ServerUnaryReactor* WorkerService::Register(grpc::CallbackServerContext* context,
                                                  const v1::Hello* request, v1::Welcome* response) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  const absl::StatusOr<WorkerEntry> entry = farm_.Register(FromMessage(*request));
  if (entry.ok()) {
    response->set_epoch(farm_.epoch());
    response->set_session_id(entry->session_id);
    response->set_protocol(entry->protocol);
    *response->mutable_lease_ttl() = convert::ToProto(config_.lease_ttl);
    *response->mutable_heartbeat_interval() = convert::ToProto(config_.heartbeat_interval);
    response->set_max_batch_bytes(kMaxBatchBytes);
    *response->mutable_gather() = convert::ToProto(farm_.gather());
    response->set_credit_with_results(true);
  }
  reactor->Finish(convert::ToGrpc(entry.status()));
  return reactor;
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* WorkerService::Session(
    grpc::CallbackServerContext* context) {
  return new SessionReactor(farm_, context, limits_);  // Frees itself in OnDone.
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* WorkerService::PushResults(
    grpc::CallbackServerContext*) {
  return new ResultsReactor(farm_, committer_, limits_);  // Frees itself in OnDone.
}

}  // namespace shutterline::server
