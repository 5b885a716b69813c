#include "common/base/log.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <vector>

namespace shutterline {
namespace {

/// Hands lines on to whoever listens.
class ListenerSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  static const std::shared_ptr<ListenerSink>& OfProcess() {
    static const auto* const sink = new std::shared_ptr<ListenerSink>(std::make_shared<ListenerSink>());
    return *sink;  // Outlives every thread that may still log.
  }
  void Add(LogListener* listener) {
    std::lock_guard lock(mutex_);
    listeners_.push_back(listener);
  }
  void Remove(LogListener* listener) {
    std::lock_guard lock(mutex_);
    std::erase(listeners_, listener);
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {  // Under mutex_.
    if (listeners_.empty()) return;
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    for (LogListener* listener : listeners_) {
      listener->OnLogLine({line.data(), line.size()}, {message.payload.data(), message.payload.size()});
    }
  }
  void flush_() override {}

 private:
  std::vector<LogListener*> listeners_;
};

}  // namespace

void AddLogListener(LogListener* listener) {
  ListenerSink::OfProcess()->Add(listener);
}

void RemoveLogListener(LogListener* listener) {
  ListenerSink::OfProcess()->Remove(listener);
}

absl::Status SetUpLog(absl::string_view program, absl::string_view level) {
  constexpr absl::string_view kLevels[] = {"trace", "debug", "info", "warn", "error", "off"};
  if (std::find(std::begin(kLevels), std::end(kLevels), level) == std::end(kLevels)) {
    return absl::InvalidArgumentError(absl::StrCat("log level '", absl::CHexEscape(level.substr(0, 80)),
                                                   "' is none of trace, debug, info, warn, error and off"));
  }
  const auto printed = std::make_shared<spdlog::sinks::stderr_sink_mt>();
  const auto heard = ListenerSink::OfProcess();
  auto logger =
      std::make_shared<spdlog::logger>(std::string(program), spdlog::sinks_init_list{printed, heard});
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%eZ %-5l %n: %v", spdlog::pattern_time_type::utc);
  const auto chosen = spdlog::level::from_str(std::string(level));
  printed->set_level(chosen);
  heard->set_level(spdlog::level::info);
  logger->set_level(std::min(chosen, spdlog::level::info));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
  return absl::OkStatus();
}

std::string LogValue(absl::string_view value) {
  constexpr size_t kMaxBytes = 1024;
  const absl::string_view kept = value.substr(0, kMaxBytes);
  const absl::string_view tail = value.size() > kMaxBytes ? "…" : "";
  const bool plain = !kept.empty() && std::all_of(kept.begin(), kept.end(), [](unsigned char c) {
    return c > 0x20 && c < 0x7f && c != '"' && c != '=' && c != '\\';
  });
  if (plain) return absl::StrCat(kept, tail);
  return absl::StrCat("\"", absl::StrReplaceAll(absl::CHexEscape(kept), {{"\\'", "'"}}), tail, "\"");
}

}  // namespace shutterline
