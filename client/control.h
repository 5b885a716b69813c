#pragma once

#include <string>

#include "client/command_line.h"
#include "client/server_option.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::client {

/// A command that asks the server to change one job, and tells how the job stands then.
class ControlCommand : public Command {
 public:
  ControlCommand(v1::ControlRequest::Action action, std::string doing) : doing_(std::move(doing)) {
    request_.set_action(action);
  }
  void Declare(CLI::App& app) override;
  absl::Status Check() override { return server_.Check(); }
  absl::StatusOr<ExitCode> Run(Console& console) override;

 protected:
  /// The job is set by its argument.
  v1::ControlRequest& request() { return request_; }

 private:
  const std::string doing_;  ///< "cancel the job": for errors.
  v1::ControlRequest request_;
  std::string job_;
  ServerOption server_;
  bool json_ = false;
};

}  // namespace shutterline::client
