#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "client/commands.h"
#include "client/human.h"
#include "client/json_output.h"
#include "client/options.h"
#include "client/server_option.h"
#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

class WorkersCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    server_.Declare(app);
    AddJsonOption(app, json_);
    AddExamples(app, {"shutterline workers --server farm:7400", "shutterline workers --json"});
  }

  absl::Status Check() override { return server_.Check(); }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, nullptr));
    SL_ASSIGN_OR_RETURN(
        const v1::ListWorkersResponse reply,
        connection->Repeat<v1::ListWorkersResponse>("list workers", [&](auto* context, auto* response) {
          return connection->jobs().ListWorkers(context, v1::ListWorkersRequest(), response);
        }));
    if (json_) {
      Json list = Json::array();
      for (const v1::Worker& worker : reply.workers()) list.push_back(ToJson(worker));
      Print(Json{{"workers", list}}, console.out);
      return ExitCode::kSuccess;
    }
    if (reply.workers().empty()) {
      console.out << "no worker is connected\n";
      return ExitCode::kSuccess;
    }
    console.out << absl::StreamFormat("%-24s  %5s  %6s  %8s  %9s  %6s  %-8s  %s\n", "WORKER", "SLOTS",
                                      "LEASED", "TILES", "MS/TILE", "SILENT", "ISA", "BUILD");
    for (const v1::Worker& worker : reply.workers()) {
      const std::string speed =
          worker.tile_seconds() > 0 ? absl::StrFormat("%.1f", worker.tile_seconds() * 1e3) : "-";
      console.out << absl::StreamFormat(
          "%-24s  %5d  %6d  %8d  %9s  %5.1fs  %-8s  %s%s\n", Printable(worker.name()), worker.slots(),
          worker.leased_tiles(), worker.tiles_done(), speed, worker.silent_seconds(), Printable(worker.isa()),
          Printable(worker.build_id()), worker.draining() ? " (draining)" : "");
    }
    return ExitCode::kSuccess;
  }

 private:
  ServerOption server_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeWorkersCommand() {
  return std::make_unique<WorkersCommand>();
}

}  // namespace shutterline::client
