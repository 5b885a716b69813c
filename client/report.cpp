#include "client/report.h"

#include "client/human.h"
#include "client/json_output.h"

namespace shutterline::client {

ExitCode Report(Console& console, const Delivery& delivery, const UploadReport& upload, bool json,
                bool quiet) {
  if (json) {
    Json frames = Json::array();
    for (const FetchedFrame& frame : delivery.frames) frames.push_back(ToJson(frame));
    Print(Json{{"job", ToJson(delivery.job)}, {"upload", ToJson(upload)}, {"frames", frames}}, console.out);
  } else if (!quiet) {
    for (const FetchedFrame& frame : delivery.frames) {
      console.out << Printable(frame.path) << "\n";
      if (!frame.preview.empty()) console.out << Printable(frame.preview) << "\n";
    }
  }
  const ExitCode code = delivery.Code();
  if (code != ExitCode::kSuccess) console.err << "shutterline: " << DescribeEnd(delivery.job) << "\n";
  return code;
}

}  // namespace shutterline::client
