#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <optional>

#include "client/commands.h"
#include "client/frame_range.h"
#include "client/human.h"
#include "client/interrupt.h"
#include "client/job_log.h"
#include "client/job_watch.h"
#include "client/options.h"
#include "client/parse.h"
#include "client/server_option.h"
#include "common/base/status_macros.h"
#include "common/job/tile.h"

namespace shutterline::client {
namespace {

constexpr absl::Duration kFollowPause = absl::Seconds(1);
constexpr int64_t kMaxCoordinate = 1 << 20;

struct TilePlace {
  int column = 0, row = 0;
};

absl::StatusOr<TilePlace> ParseTile(const std::string& text) {
  const std::vector<std::string> parts = absl::StrSplit(text, ',');
  if (parts.size() == 2) {
    const absl::StatusOr<int64_t> column = ParseWhole(parts[0], 0, kMaxCoordinate);
    const absl::StatusOr<int64_t> row = ParseWhole(parts[1], 0, kMaxCoordinate);
    if (column.ok() && row.ok()) return TilePlace{int(*column), int(*row)};
  }
  return absl::InvalidArgumentError("must be COLUMN,ROW, counted from 0 at the top left, as in 3,0");
}

class LogsCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddJobArgument(app, job_);
    server_.Declare(app);
    AddValue(app, "--frame", "N", "", "Only what names this frame", [this](const std::string& t) {
      SL_ASSIGN_OR_RETURN(const FrameRange one, ParseFrame(t));
      frame_ = one.first;
      return absl::OkStatus();
    });
    AddValue(app, "--tile", "X,Y", "",
             "Only what names the tile in column X and row Y, from 0 at\nthe top left",
             [this](const std::string& t) {
               SL_ASSIGN_OR_RETURN(tile_, ParseTile(t));
               return absl::OkStatus();
             });
    app.add_flag("--follow", follow_, "Go on until the job has ended");
    AddExamples(app,
                {"shutterline logs 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400",
                 "shutterline logs 0f8fad5b-d9cb-469f-a165-70867728950e --frame 12 --tile 3,0"},
                "What the coordinator's log says of the job: who failed at what and why, what was rendered\n"
                "again, when frames were finished.");
  }

  absl::Status Check() override { return server_.Check(); }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    Interrupt interrupt;
    const SignalInterrupt signals(interrupt);
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, &interrupt));
    SL_ASSIGN_OR_RETURN(v1::Job job, Get(*connection));
    std::optional<int> tile;
    if (tile_) {
      const TileGrid grid{job.spec().render().width(), job.spec().render().height()};
      if (tile_->column >= grid.Columns() || tile_->row >= grid.Rows()) {
        return absl::NotFoundError(absl::StrCat("--tile ", tile_->column, ",", tile_->row,
                                                ": the job's frames have ", grid.Columns(), " columns and ",
                                                grid.Rows(), " rows of tiles"));
      }
      tile = tile_->row * grid.Columns() + tile_->column;
    }
    LogFilter filter(frame_, tile, [&](absl::string_view line) { console.out << Printable(line) << "\n"; });
    uint64_t offset = 0;
    while (true) {
      const bool last = !follow_ || HasEnded(job.state());
      SL_RETURN_IF_ERROR(
          ReadJobLog(*connection, job_, offset, [&](absl::string_view text) { filter.Add(text); }));
      console.out << std::flush;
      if (last) break;
      interrupt.WaitFor(kFollowPause);
      SL_ASSIGN_OR_RETURN(job, Get(*connection));
    }
    filter.Rest();
    return ExitCode::kSuccess;
  }

 private:
  absl::StatusOr<v1::Job> Get(Connection& connection) const {
    v1::JobRef request;
    request.set_job_id(job_);
    return connection.Repeat<v1::Job>("get the job", [&](auto* context, auto* reply) {
      return connection.jobs().Get(context, request, reply);
    });
  }

  std::string job_;
  ServerOption server_;
  std::optional<int> frame_;
  std::optional<TilePlace> tile_;
  bool follow_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeLogsCommand() {
  return std::make_unique<LogsCommand>();
}

}  // namespace shutterline::client
