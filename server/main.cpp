#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <map>
#include <string>

#include "common/base/atomic_file.h"
#include "common/base/build_id.h"
#include "common/base/lock_order.h"
#include "common/base/log.h"
#include "common/base/log_format.h"
#include "server/coordinator.h"

namespace {

using shutterline::LogValue;
using shutterline::server::Durability;

struct Options {
  shutterline::server::Config config;
  std::string port_file, http_port_file, log_level = "info", log_format = "text";
  double grace_seconds = 10;
  double lease_ttl_seconds = absl::ToDoubleSeconds(config.lease_ttl);
  double scene_seconds = 120;
  double heartbeat_seconds = absl::ToDoubleSeconds(config.heartbeat_interval);
  double keep_jobs_seconds = 0;  ///< 0: for ever.
};

void Declare(CLI::App& app, Options& options) {
  app.add_option("--listen", options.config.listen, "HOST:PORT to serve on; port 0 takes a free one")
      ->capture_default_str();
  app.add_option("--data", options.config.data_dir,
                 "Folder for jobs, blobs, tiles and frames; made if missing")
      ->required();
  app.add_option("--port-file", options.port_file, "File to write the port to, once it is served");
  app.add_flag(
      "--insecure-listen", options.config.insecure_listen,
      "Serve also on addresses that other machines reach, though nothing is encrypted or authenticated");
  app.add_option(
      "--http", options.config.http,
      "HOST:PORT to serve the dashboard, /metrics and /healthz on, in a browser's reach; not served "
      "unless given");
  app.add_option(
      "--http-name", options.config.http_names,
      "A name under which browsers may ask for the dashboard, beside addresses and localhost; may be "
      "repeated");
  app.add_option("--http-port-file", options.http_port_file, "File to write the port of --http to");
  shutterline::server::ListenSecurity& security = options.config.security;
  app.add_option("--tls-cert", security.tls_cert,
                 "The coordinator's certificate (PEM): everything is encrypted")
      ->type_name("FILE");
  app.add_option("--tls-key", security.tls_key, "Its private key (PEM)")->type_name("FILE");
  app.add_option("--tls-client-ca", security.tls_client_ca,
                 "Authority (PEM) whose certificates callers may show; they hold the callers' roles")
      ->type_name("FILE");
  app.add_option("--token-file", security.token_file,
                 "Lines 'role name sha256': tokens that callers may show instead")
      ->type_name("FILE");
  app.add_option("--grace", options.grace_seconds, "Seconds that workers get to finish when told to stop")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  app.add_option("--lease-ttl", options.lease_ttl_seconds,
                 "Seconds of a worker's silence after which its tiles go to others; at least two heartbeats")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  app.add_option("--heartbeat", options.heartbeat_seconds, "Seconds between two signs of life of a worker")
      ->check(CLI::Range(0.05, 60.0))
      ->capture_default_str();
  app.add_option(
         "--scene-seconds", options.scene_seconds,
         "Seconds that the import of a submitted scene may take before the job is refused (0: no limit)")
      ->check(CLI::Range(0.0, 86'400.0))
      ->capture_default_str();
  app.add_option("--log-format", options.log_format, "text, or json: one object a line")
      ->capture_default_str();
  app.add_option(
         "--durability", options.config.durability,
         "What acknowledged data outlives: `power` (losses of power: waits for the disk) or `process` "
         "(ends of this process: waits for the kernel alone)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Durability>{
          {"power", Durability::kPower}, {"process", Durability::kProcess}}))
      ->default_str("power");
  app.add_option(
         "--blob-limit-bytes", options.config.blob_limit_bytes,
         "Bytes that uploaded files may take together, as 20GB; beyond it those that no live job needs "
         "go, least recently used first; 0: no limit")
      ->transform(CLI::AsSizeValue(false))
      ->default_str("0");
  app.add_option("--keep-jobs", options.keep_jobs_seconds,
                 "How long jobs that have ended are kept, as 12h, 30d or 90m; then they are removed, with "
                 "their frames "
                 "and logs. For ever unless given")
      ->transform(
          CLI::AsNumberWithUnit(std::map<std::string, double>{{"s", 1}, {"m", 60}, {"h", 3600}, {"d", 86400}},
                                CLI::AsNumberWithUnit::UNIT_REQUIRED, "DURATION"))
      ->check(CLI::Range(1.0, 1e10));
  app.add_option(
         "--keep-jobs-max", options.config.keep_jobs_max,
         "How many jobs that have ended are kept at most; beyond it those go that ended first; 0: no limit")
      ->check(CLI::Range(int64_t{0}, int64_t{1'000'000'000}))
      ->capture_default_str();
  app.add_option("--log-level", options.log_level, "trace, debug, info, warn, error or off")
      ->capture_default_str();
  app.set_version_flag("--version", shutterline::kBuildId);
  app.footer(
      "Accepts jobs from `shutterline submit`, hands their tiles to every `shutterline-worker` that "
      "connects,\n"
      "and writes the frames. All that it has acknowledged survives a crash: start it again on the same "
      "folder.");
}

int Serve(const Options& options) {
  // Blocked before any thread starts, so that all threads inherit it and sigwait below gets the signal.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  auto coordinator = shutterline::server::Coordinator::Start(options.config);
  if (!coordinator.ok()) {
    spdlog::error("cannot start reason={}", LogValue(coordinator.status().message()));
    return 1;
  }
  if (!options.port_file.empty()) {
    const absl::Status written =
        shutterline::WriteFileAtomically(options.port_file, std::to_string((*coordinator)->port()) + "\n");
    if (!written.ok()) {
      spdlog::error("cannot write the port file reason={}", LogValue(written.message()));
      return 1;
    }
  }
  if (!options.http_port_file.empty()) {
    const absl::Status written = shutterline::WriteFileAtomically(
        options.http_port_file, std::to_string((*coordinator)->http_port()) + "\n");
    if (!written.ok()) {
      spdlog::error("cannot write the HTTP port file reason={}", LogValue(written.message()));
      return 1;
    }
  }
  int signal = 0;
  sigwait(&signals, &signal);
  spdlog::info("stopping signal={}", signal);
  (*coordinator)->Shutdown(absl::Seconds(options.grace_seconds));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  shutterline::TrustLockOrder();
  Options options;
  options.config.listen = "127.0.0.1:7400";
  CLI::App app{"The coordinator of a Shutterline farm.", "shutterline-server"};
  Declare(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  options.config.lease_ttl = absl::Seconds(options.lease_ttl_seconds);
  if (options.scene_seconds > 0) options.config.scene_time = absl::Seconds(options.scene_seconds);
  options.config.heartbeat_interval = absl::Seconds(options.heartbeat_seconds);
  if (options.keep_jobs_seconds > 0) options.config.keep_jobs = absl::Seconds(options.keep_jobs_seconds);
  if (options.config.listen.empty()) {
    std::fprintf(stderr, "shutterline-server: --listen is empty, but must be HOST:PORT\n");
    return 2;
  }
  absl::Status log = shutterline::SetUpLog("server", options.log_level);
  if (log.ok()) log = shutterline::SetLogFormat(options.log_format);
  if (!log.ok()) {
    std::fprintf(stderr, "shutterline-server: %s\n", std::string(log.message()).c_str());
    return 2;
  }
  return Serve(options);
}
