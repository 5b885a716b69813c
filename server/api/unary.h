#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>

#include <utility>

#include "proto/convert/status.h"
#include "server/control/work_pool.h"

namespace shutterline::server {

/// Answers a unary call from the pool: `work` fills in the response and returns the status.
template <typename Work>
grpc::ServerUnaryReactor* AnswerFrom(WorkPool& pool, grpc::CallbackServerContext* context, Work work) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  const bool accepted =
      pool.Run([reactor, work = std::move(work)] { reactor->Finish(convert::ToGrpc(work())); });
  if (!accepted) reactor->Finish(grpc::Status(grpc::StatusCode::UNAVAILABLE, "the coordinator is stopping"));
  return reactor;
}

}  // namespace shutterline::server
