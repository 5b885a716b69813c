#include <absl/strings/str_cat.h>

#include "client/commands.h"
#include "client/delivery.h"
#include "client/in_process_farm.h"
#include "client/interrupt.h"
#include "client/job_submission.h"
#include "client/options.h"
#include "client/parse.h"
#include "client/part_file.h"
#include "client/report.h"
#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "common/job/describe_settings.h"
#include "worker/engine/shading/shading_cache.h"

namespace shutterline::client {
namespace {

constexpr int kMaxThreads = 4096;
constexpr uint64_t kDefaultCacheMb = engine::kDefaultShadingCacheBytes >> 20;
constexpr int64_t kMaxCacheMb = int64_t{1} << 24;

class RenderCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddJobOptions(app, options_);
    AddValue(app, "--threads", "N", "all processors",
             absl::StrCat("Threads that render, 1 to ", kMaxThreads, "; no pixel depends on it"),
             [this](const std::string& text) {
               SL_ASSIGN_OR_RETURN(const int64_t count, ParseWhole(text, 1, kMaxThreads));
               threads_ = static_cast<int>(count);
               return absl::OkStatus();
             })
        ->group("Speed");
    auto* cache_mb = AddValue(app, "--cache-mb", "N", absl::StrCat(kDefaultCacheMb),
                              "Memory for shadings that many pixels share, MiB; no pixel\ndepends on it",
                              [this](const std::string& text) {
                                SL_ASSIGN_OR_RETURN(const int64_t mb, ParseWhole(text, 1, kMaxCacheMb));
                                shading_cache_bytes_ = uint64_t(mb) << 20;
                                return absl::OkStatus();
                              });
    auto* no_cache = app.add_flag("--no-shading-cache", no_shading_cache_, "Keep no shadings");
    no_cache->excludes(cache_mb);
    cache_mb->excludes(no_cache);
    for (CLI::Option* option : {cache_mb, no_cache}) option->group("Speed");
    AddValue(app, "--log", "LEVEL", "warn",
             "What the renderer itself logs to standard error: trace,\ndebug, info, warn, error or off",
             [this](const std::string& text) {
               for (const char* level : {"trace", "debug", "info", "warn", "error", "off"}) {
                 if (text == level) {
                   log_level_ = text;
                   return absl::OkStatus();
                 }
               }
               return absl::InvalidArgumentError("must be trace, debug, info, warn, error or off");
             });
    AddJsonOption(app, json_);
    AddQuietOption(app, quiet_);
    AddStatsOption(app, stats_);
    AddExamples(app,
                {"shutterline render fox.glb -o fox.exr --png",
                 "shutterline render fox.glb -o fox.####.exr --frames 1-48 --fps 24 --shutter-close 0.5",
                 "shutterline render fox.glb -o truth.exr --integrator reference --spp 1024",
                 "shutterline render fox.glb -o fox.exr --target-error 0.004 --stats"},
                "Frames are written as they are finished; Ctrl-C stops cleanly and keeps those.");
  }

  absl::Status Check() override { return CheckJobOptions(options_); }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    if (!options_.output) {
      SL_ASSIGN_OR_RETURN(options_.output, OutputPath::Parse(DefaultOutput(options_.scene)));
    }
    const Destination destination{*options_.output, options_.png};
    SL_RETURN_IF_ERROR(CheckDestination(destination.output));
    SL_RETURN_IF_ERROR(SetUpLog("shutterline", log_level_));

    Interrupt interrupt;
    const SignalInterrupt signals(interrupt);
    SceneReading scene(options_, &interrupt);
    SL_ASSIGN_OR_RETURN(const auto farm,
                        InProcessFarm::Start(threads_, no_shading_cache_ ? 0 : shading_cache_bytes_));
    Connection::Options connection_options;
    connection_options.interrupt = &interrupt;
    Connection connection(farm->Channel(), "the renderer in this process", connection_options);
    Progress progress(ChooseStyle(console, quiet_), console.err);
    SL_ASSIGN_OR_RETURN(const Submission submission, SubmitJob(connection, options_, scene, {}, progress));
    const absl::StatusOr<Delivery> delivery =
        Deliver(connection, submission.job.id(), options_.frames, &destination, progress);
    if (!delivery.ok()) {
      RemoveParts(submission.job.id());
      return delivery.status();
    }
    ReportOptions report{json_, quiet_, std::nullopt};
    if (stats_) report.stats_of = DescribeSettings(options_.settings);
    return Report(console, *delivery, submission.upload, report);
  }

 private:
  /// The job ends with this process, so nobody can take up what it left half fetched.
  void RemoveParts(const std::string& job_id) const {
    const FrameRange& frames = options_.frames;
    for (int64_t i = 0; i < frames.Count(); ++i) {
      PartFile::Remove(options_.output->FrameFile(frames.Frame(i), frames.Count()),
                       FramePartTag(job_id, frames.Frame(i)));
    }
  }

  JobOptions options_;
  int threads_ = 0;  ///< 0: all processors.
  uint64_t shading_cache_bytes_ = engine::kDefaultShadingCacheBytes;
  bool no_shading_cache_ = false;
  std::string log_level_ = "warn";
  bool json_ = false, quiet_ = false, stats_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeRenderCommand() {
  return std::make_unique<RenderCommand>();
}

}  // namespace shutterline::client
