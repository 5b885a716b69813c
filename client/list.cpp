#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "client/commands.h"
#include "client/delivery.h"
#include "client/human.h"
#include "client/json_output.h"
#include "client/options.h"
#include "client/parse.h"
#include "client/server_option.h"
#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

constexpr int64_t kMaxListed = 1'000'000;

class ListCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    server_.Declare(app);
    AddValue(app, "--limit", "N", "50", "Jobs to list at most, 1 to 1000000",
             [this](const std::string& text) {
               SL_ASSIGN_OR_RETURN(limit_, ParseWhole(text, 1, kMaxListed));
               return absl::OkStatus();
             });
    AddJsonOption(app, json_);
    AddExamples(app, {"shutterline list --server farm:7400", "shutterline list --limit 5 --json"});
  }

  absl::Status Check() override { return server_.Check(); }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, nullptr));
    std::vector<v1::Job> jobs;
    v1::ListRequest request;
    bool more = true;
    while (more && static_cast<int64_t>(jobs.size()) < limit_) {
      SL_ASSIGN_OR_RETURN(const v1::ListResponse page,
                          connection->Repeat<v1::ListResponse>("list jobs", [&](auto* context, auto* reply) {
                            return connection->jobs().List(context, request, reply);
                          }));
      for (const v1::Job& job : page.jobs()) {
        if (static_cast<int64_t>(jobs.size()) < limit_) jobs.push_back(job);
      }
      more = !page.next_page_token().empty();
      // A server that hands out the same page for ever would keep us here.
      if (more && page.next_page_token() == request.page_token()) {
        return absl::InternalError("list jobs: the server repeats a page");
      }
      request.set_page_token(page.next_page_token());
    }
    if (json_) {
      Json list = Json::array();
      for (const v1::Job& job : jobs) list.push_back(ToJson(job));
      Print(Json{{"jobs", list}}, console.out);
      return ExitCode::kSuccess;
    }
    console.out << absl::StreamFormat("%-36s  %-9s  %11s  %4s  %-20s  %s\n", "JOB", "STATE", "FRAMES", "DONE",
                                      "SUBMITTED", "NAME");
    for (const v1::Job& job : jobs) {
      const uint64_t percent = job.tiles_total() == 0 ? 0 : 100 * job.tiles_done() / job.tiles_total();
      console.out << absl::StreamFormat("%-36s  %-9s  %11s  %3d%%  %-20s  %s\n", Printable(job.id()),
                                        WordOf(job.state()),
                                        absl::StrCat(job.frames_finished(), "/", job.frames_total()), percent,
                                        TimeText(job.submitted()), Printable(job.spec().name()));
    }
    return ExitCode::kSuccess;
  }

 private:
  ServerOption server_;
  int64_t limit_ = 50;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeListCommand() {
  return std::make_unique<ListCommand>();
}

}  // namespace shutterline::client
