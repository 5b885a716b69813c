#include "worker/config.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "common/base/build_id.h"

namespace shutterline::worker {
namespace {

constexpr char kFooter[] = R"(
The worker dials the coordinator, takes tiles, renders them with all its threads and sends them back. It
tries again for as long as the coordinator is away. SIGTERM or SIGINT lets it finish and deliver the tiles
that it holds and leave; a second signal ends it at once (its tiles then go to other workers, and no pixel
is lost). The process that renders is a child of the one that is started: where it crashes, it is started
again, and the coordinator is told the signal and the last lines of its log.

Exit status: 0 left as told, 1 failed (refused by the coordinator, or tiles undelivered), 2 wrong usage. Where
the process that renders crashes after it was told to leave, so does this one, by the same signal.

  shutterline-worker --coordinator render-host:7400
  shutterline-worker --coordinator render-host:7400 --threads 8 --cache-dir /var/cache/shutterline
)";

/// Empty if `value` is HOST:PORT with a port from 1 to 65535; else what is wrong.
std::string CheckHostPort(const std::string& value) {
  const size_t colon = value.rfind(':');
  int port = 0;
  if (colon == std::string::npos || colon == 0 || !absl::SimpleAtoi(value.substr(colon + 1), &port) ||
      port < 1 || port > 65535) {
    return absl::StrCat("'", value, "' is not HOST:PORT");
  }
  return "";
}

/// Empty if `value` is 0 or what a worker can start with, MiB; else what is wrong.
std::string CheckMemory(const std::string& value) {
  uint64_t mb = 0;
  if (absl::SimpleAtoi(value, &mb) && (mb == 0 || (mb >= 512 && mb <= uint64_t{1} << 32))) return "";
  return absl::StrCat("'", value, "' is neither 0 nor at least 512");
}

}  // namespace

std::filesystem::path DefaultCacheDir() {
  const char* const cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && cache[0] == '/') return std::filesystem::path(cache) / "shutterline" / "blobs";
  const char* const home = std::getenv("HOME");
  if (home != nullptr && home[0] == '/') {
    return std::filesystem::path(home) / ".cache" / "shutterline" / "blobs";
  }
  std::error_code error;
  std::filesystem::path temporary = std::filesystem::temp_directory_path(error);
  if (error) temporary = "/tmp";
  return temporary / absl::StrCat("shutterline-blobs-", getuid());
}

std::optional<Config> ParseCommandLine(int argc, const char* const* argv, int& exit_code) {
  Config config;
  config.worker.cache_dir = DefaultCacheDir();
  std::string cache_dir = config.worker.cache_dir.string();
  uint64_t cache_mb = config.worker.cache_bytes >> 20;
  uint64_t shading_cache_mb = config.shading_cache_bytes >> 20;

  CLI::App app("Renders tiles for a Shutterline coordinator.", "shutterline-worker");
  app.footer(kFooter);
  app.set_version_flag("--version", kBuildId);
  app.add_option("--coordinator", config.coordinator, "The coordinator to work for")
      ->type_name("HOST:PORT")
      ->required()
      ->check(CLI::Validator(CheckHostPort, "", "host:port"));
  app.add_option("--tls-ca", config.security.tls_ca,
                 "Authority (PEM) that the coordinator is checked by: everything is encrypted")
      ->type_name("FILE")
      ->envname("SHUTTERLINE_TLS_CA");
  app.add_option("--tls-cert", config.security.tls_cert, "This worker's certificate (PEM)")
      ->type_name("FILE")
      ->envname("SHUTTERLINE_TLS_CERT");
  app.add_option("--tls-key", config.security.tls_key, "Its private key (PEM)")
      ->type_name("FILE")
      ->envname("SHUTTERLINE_TLS_KEY");
  app.add_option("--token-file", config.security.token_file,
                 "File of a token, which says who this worker is instead of a certificate")
      ->type_name("FILE")
      ->envname("SHUTTERLINE_TOKEN_FILE");
  app.add_option("--threads", config.worker.threads, "Threads that render (0: one for each processor)")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_option("--cache-dir", cache_dir, "Folder for scene files, may be shared by workers of a machine")
      ->type_name("DIR")
      ->capture_default_str();
  app.add_option("--blob-cache-mb", cache_mb, "What the scene files may take of the disk, MiB")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1} << 32))
      ->capture_default_str();
  CLI::Option* shading_cache =
      app.add_option("--cache-mb", shading_cache_mb,
                     "What shadings may take of the memory, MiB; no pixel depends on it")
          ->check(CLI::Range(uint64_t{1}, uint64_t{1} << 24))
          ->capture_default_str();
  uint64_t memory_mb = 0;
  app.add_option(
         "--memory-mb", memory_mb,
         "What the whole worker may take of the memory, MiB: scenes that need more fail (0: no limit)")
      ->check(CLI::Validator(CheckMemory, "", "memory"))
      ->capture_default_str();
  double scene_seconds = 120;
  app.add_option(
         "--scene-seconds", scene_seconds,
         "Seconds that the import of a scene, and the making of a frame of it, may take each before its "
         "tiles fail (0: no limit)")
      ->check(CLI::Range(0.0, 86'400.0))
      ->capture_default_str();
  bool no_shading_cache = false;
  app.add_flag("--no-shading-cache", no_shading_cache, "Keep no shadings")->excludes(shading_cache);
  bool no_supervise = false;
  app.add_flag(
      "--no-supervise", no_supervise,
      "Render in this very process, which then ends with its first crash, instead of one of its own that is "
      "started again and whose end is told");
  app.add_option("--name", config.worker.name, "How people know this worker (default HOST:PID)");
  app.add_option("--log-format", config.log_format, "text, or json: one object a line")
      ->capture_default_str();
  app.add_option("--log-level", config.log_level, "trace, debug, info, warn, error or off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    exit_code = app.exit(e) == 0 ? 0 : 2;
    return std::nullopt;
  }
  config.worker.cache_dir = cache_dir;
  config.worker.cache_bytes = cache_mb << 20;
  config.memory_bytes = memory_mb << 20;
  config.supervise = !no_supervise;
  config.worker.scene_time = scene_seconds > 0 ? absl::Seconds(scene_seconds) : absl::InfiniteDuration();
  config.shading_cache_bytes = no_shading_cache ? 0 : shading_cache_mb << 20;
  return config;
}

}  // namespace shutterline::worker
