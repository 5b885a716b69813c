#include "client/report.h"

#include "client/human.h"
#include "client/json_output.h"
#include "client/stats_report.h"
#include "common/base/status_macros.h"

namespace shutterline::client {

absl::StatusOr<ExitCode> Report(Console& console, const Delivery& delivery, const UploadReport& upload,
                                const ReportOptions& options) {
  std::optional<StatsReport> stats;
  if (options.stats_of) {
    SL_ASSIGN_OR_RETURN(stats, MakeStatsReport(*options.stats_of, delivery.finished));
  }
  if (options.json) {
    Json frames = Json::array();
    for (const FetchedFrame& frame : delivery.frames) frames.push_back(ToJson(frame));
    Json json{{"job", ToJson(delivery.job)}, {"upload", ToJson(upload)}, {"frames", frames}};
    if (stats) json["stats"] = ToJson(*stats);
    Print(json, console.out);
  } else if (!options.quiet) {
    for (const FetchedFrame& frame : delivery.frames) {
      console.out << Printable(frame.path) << "\n";
      if (!frame.preview.empty()) console.out << Printable(frame.preview) << "\n";
    }
  }
  if (stats && !options.json) PrintStats(*stats, console.out);
  const ExitCode code = delivery.Code();
  if (code != ExitCode::kSuccess) console.err << "shutterline: " << DescribeEnd(delivery.job) << "\n";
  return code;
}

}  // namespace shutterline::client
