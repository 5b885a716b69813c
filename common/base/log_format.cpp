#include "common/base/log_format.h"

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <absl/time/time.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>

#include "common/base/log.h"

namespace shutterline {
namespace {

using Fields = std::vector<std::pair<std::string, std::string>>;

std::string JsonText(absl::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20) {
      absl::StrAppend(&quoted, "\\u", absl::Hex(static_cast<unsigned char>(c), absl::kZeroPad4));
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

class JsonLogFormatter final : public spdlog::formatter {
 public:
  explicit JsonLogFormatter(Fields fields) : fields_(std::move(fields)) {}

  void format(const spdlog::details::log_msg& line, spdlog::memory_buf_t& out) override {
    const LogLine parsed = ParseLogLine({line.payload.data(), line.payload.size()});
    const absl::string_view level(spdlog::level::to_string_view(line.level).data(),
                                  spdlog::level::to_string_view(line.level).size());
    std::string text = absl::StrCat(
        "{\"time\":",
        JsonText(absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", absl::FromChrono(line.time), absl::UTCTimeZone())),
        ",\"level\":", JsonText(level),
        ",\"program\":", JsonText({line.logger_name.data(), line.logger_name.size()}),
        ",\"message\":", JsonText(parsed.message));
    for (const Fields* fields : {&parsed.fields, &fields_}) {
      for (const auto& [key, value] : *fields)
        absl::StrAppend(&text, ",", JsonText(key), ":", JsonText(value));
    }
    text += "}\n";
    out.append(text.data(), text.data() + text.size());
  }

  std::unique_ptr<formatter> clone() const override { return std::make_unique<JsonLogFormatter>(fields_); }

 private:
  const Fields fields_;
};

/// The key of "key=…" at the start of `text`; empty where there is none.
absl::string_view KeyAt(absl::string_view text) {
  size_t end = 0;
  while (end < text.size() &&
         (absl::ascii_islower(text[end]) || absl::ascii_isdigit(text[end]) || text[end] == '_'))
    ++end;
  return end > 0 && end < text.size() && text[end] == '=' ? text.substr(0, end) : absl::string_view();
}

/// Takes a value from the start of `text`; false where it is neither plain nor quoted.
bool TakeValue(absl::string_view& text, std::string& value) {
  value.clear();
  if (text.empty() || text[0] != '"') {
    const size_t end = std::min(text.size(), text.find(' '));
    value = std::string(text.substr(0, end));
    text.remove_prefix(end);
    return true;
  }
  for (size_t at = 1; at < text.size(); ++at) {
    if (text[at] == '"') {
      text.remove_prefix(at + 1);
      return text.empty() || text[0] == ' ';
    }
    // Other escapes stay as they are: what they stand for may be no text.
    const bool escaped =
        text[at] == '\\' && at + 1 < text.size() && (text[at + 1] == '"' || text[at + 1] == '\\');
    if (escaped) ++at;
    value += text[at];
  }
  return false;
}

}  // namespace

LogLine ParseLogLine(absl::string_view text) {
  LogLine line;
  size_t at = 0;
  while (at < text.size() && KeyAt(text.substr(at)).empty()) {
    const size_t space = text.find(' ', at);
    at = space == absl::string_view::npos ? text.size() : space + 1;
  }
  line.message = std::string(absl::StripTrailingAsciiWhitespace(text.substr(0, at)));
  absl::string_view rest = text.substr(at);
  while (!rest.empty()) {
    const absl::string_view before = rest, key = KeyAt(rest);
    std::string value;
    if (!key.empty()) rest.remove_prefix(key.size() + 1);
    if (key.empty() || !TakeValue(rest, value)) {
      absl::StrAppend(&line.message, " ", before);
      break;
    }
    line.fields.emplace_back(key, value);
    if (!rest.empty()) rest.remove_prefix(1);
  }
  return line;
}

absl::Status SetLogFormat(absl::string_view format, const Fields& fields) {
  if (format == "json") {
    spdlog::default_logger()->set_formatter(std::make_unique<JsonLogFormatter>(fields));
    return absl::OkStatus();
  }
  if (format != "text") {
    return absl::InvalidArgumentError(
        absl::StrCat("log format '", absl::CHexEscape(format.substr(0, 80)), "' is neither text nor json"));
  }
  std::string pattern = "%Y-%m-%dT%H:%M:%S.%eZ %-5l %n: %v";
  for (const auto& [key, value] : fields)
    absl::StrAppend(&pattern, " ", key, "=", absl::StrReplaceAll(LogValue(value), {{"%", "%%"}}));
  spdlog::default_logger()->set_pattern(pattern, spdlog::pattern_time_type::utc);
  return absl::OkStatus();
}

}  // namespace shutterline
