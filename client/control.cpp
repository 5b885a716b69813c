#include "client/control.h"

#include "client/delivery.h"
#include "client/json_output.h"
#include "client/options.h"
#include "common/base/status_macros.h"

namespace shutterline::client {

void ControlCommand::Declare(CLI::App& app) {
  AddJobArgument(app, job_);
  server_.Declare(app);
  AddJsonOption(app, json_);
}

absl::StatusOr<ExitCode> ControlCommand::Run(Console& console) {
  SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, nullptr));
  request_.set_job_id(job_);
  SL_ASSIGN_OR_RETURN(const v1::Job job, connection->Repeat<v1::Job>(doing_, [&](auto* context, auto* reply) {
    return connection->jobs().Control(context, request_, reply);
  }));
  if (json_) {
    Print(ToJson(job), console.out);
  } else {
    console.out << DescribeEnd(job) << "\n";
  }
  return ExitCode::kSuccess;
}

}  // namespace shutterline::client
