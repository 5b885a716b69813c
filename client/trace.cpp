#include <absl/strings/str_cat.h>
#include <grpcpp/client_context.h>

#include <optional>
#include <sstream>

#include "client/chrome_trace.h"
#include "client/commands.h"
#include "client/frame_range.h"
#include "client/human.h"
#include "client/interrupt.h"
#include "client/options.h"
#include "client/server_option.h"
#include "common/base/atomic_file.h"
#include "common/base/status_macros.h"
#include "proto/convert/status.h"

namespace shutterline::client {
namespace {

class TraceCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddJobArgument(app, job_);
    server_.Declare(app);
    AddValue(app, "-o,--output", "FILE", output_, "The file to write; - is standard output",
             [this](const std::string& text) {
               if (text.empty()) return absl::InvalidArgumentError("must be a file's path, or -");
               output_ = text;
               return absl::OkStatus();
             });
    AddValue(app, "--frame", "N", "all that the server remembers", "The one frame to trace",
             [this](const std::string& text) {
               SL_ASSIGN_OR_RETURN(const FrameRange one, ParseFrame(text));
               frame_ = one.first;
               return absl::OkStatus();
             });
    AddExamples(
        app,
        {"shutterline trace 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400",
         "shutterline trace 0f8fad5b-d9cb-469f-a165-70867728950e --frame 12 -o frame12.json"},
        "Open the file in https://ui.perfetto.dev or chrome://tracing. The server remembers the frames\n"
        "of late, and forgets them when it is restarted.");
  }

  absl::Status Check() override { return server_.Check(); }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    Interrupt interrupt;
    const SignalInterrupt signals(interrupt);
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, &interrupt));
    ChromeTrace trace;
    SL_RETURN_IF_ERROR(Read(*connection, interrupt, trace));
    if (trace.tiles() == 0) {
      return absl::NotFoundError(
          absl::StrCat("trace job ", job_, ": the server remembers no tile of ",
                       frame_ ? absl::StrCat("frame ", *frame_) : std::string("it"),
                       "; none has come, or it was long ago, or before the server's start"));
    }
    std::ostringstream text;
    Print(trace.Finish(), text, /*one_line=*/true);
    if (output_ == "-") {
      console.out << text.str();
      return ExitCode::kSuccess;
    }
    SL_RETURN_IF_ERROR(Annotate(WriteFileAtomically(output_, text.str()), absl::StrCat("write ", output_)));
    console.out << Printable(output_) << ": " << trace.tiles() << " tiles\n";
    return ExitCode::kSuccess;
  }

 private:
  absl::Status Read(Connection& connection, Interrupt& interrupt, ChromeTrace& trace) const {
    grpc::ClientContext context;
    Interrupt::Guard guard(&interrupt, [&context] { context.TryCancel(); });
    v1::TraceRequest request;
    request.set_job_id(job_);
    if (frame_) request.set_frame(*frame_);
    const auto reader = connection.jobs().ReadTrace(&context, request);
    v1::FrameTrace message;
    while (reader->Read(&message)) trace.Add(message);
    const absl::Status status = convert::FromGrpc(reader->Finish());
    return status.ok() ? status : connection.Explain(status, absl::StrCat("trace job ", job_));
  }

  std::string job_, output_ = "trace.json";
  ServerOption server_;
  std::optional<int> frame_;
};

}  // namespace

std::unique_ptr<Command> MakeTraceCommand() {
  return std::make_unique<TraceCommand>();
}

}  // namespace shutterline::client
