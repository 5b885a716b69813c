#include "server/schedule/worker_exit.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <csignal>
#include <utility>

#include "common/base/utf8.h"

namespace shutterline::server {
namespace {

constexpr size_t kMaxIdBytes = 256, kMaxTailBytes = 16 << 10, kMaxTiles = 4096;

absl::Status Refused(absl::string_view field, absl::string_view reason) {
  return absl::InvalidArgumentError(absl::StrCat("exits: ", field, " ", reason));
}

}  // namespace

absl::Status Validate(const WorkerExit& exit) {
  if (exit.boot_id.empty() || exit.boot_id.size() > kMaxIdBytes) {
    return Refused("boot_id",
                   absl::StrCat("has ", exit.boot_id.size(), " bytes, but must have 1 to ", kMaxIdBytes));
  }
  if (exit.signal < 1 || exit.signal > 64) return Refused("signal", absl::StrCat("is ", exit.signal));
  if (exit.log_tail.size() > kMaxTailBytes) {
    return Refused("log_tail", absl::StrCat("has ", exit.log_tail.size(), " bytes, but at most ",
                                            kMaxTailBytes, " may be"));
  }
  if (WithoutControls(exit.log_tail) != exit.log_tail) {
    return Refused("log_tail", "has control characters");
  }
  if (exit.tiles.size() > kMaxTiles) {
    return Refused("tiles",
                   absl::StrCat("has ", exit.tiles.size(), " entries, but at most ", kMaxTiles, " may be"));
  }
  return absl::OkStatus();
}

std::string SignalName(int signal) {
  constexpr std::pair<int, const char*> kNames[] = {
      {SIGHUP, "SIGHUP"},   {SIGINT, "SIGINT"},   {SIGQUIT, "SIGQUIT"}, {SIGILL, "SIGILL"},
      {SIGTRAP, "SIGTRAP"}, {SIGABRT, "SIGABRT"}, {SIGBUS, "SIGBUS"},   {SIGFPE, "SIGFPE"},
      {SIGKILL, "SIGKILL"}, {SIGUSR1, "SIGUSR1"}, {SIGSEGV, "SIGSEGV"}, {SIGUSR2, "SIGUSR2"},
      {SIGPIPE, "SIGPIPE"}, {SIGALRM, "SIGALRM"}, {SIGTERM, "SIGTERM"}, {SIGXCPU, "SIGXCPU"},
      {SIGXFSZ, "SIGXFSZ"}, {SIGSYS, "SIGSYS"}};
  for (const auto& [number, name] : kNames) {
    if (number == signal) return name;
  }
  return absl::StrCat("signal ", signal);
}

}  // namespace shutterline::server
