#include "server/http/request_guard.h"

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>
#include <arpa/inet.h>

#include <algorithm>

namespace shutterline::server {
namespace {

std::string Shown(absl::string_view text) {
  return absl::StrCat("'", absl::CHexEscape(text.substr(0, 80)), "'");
}

/// The name of "NAME", "NAME:PORT" or "[ADDRESS]:PORT", in lower case and without brackets; empty where it is
/// none of these.
std::string NameOf(absl::string_view host) {
  absl::string_view name = host, port;
  const size_t end = absl::StartsWith(host, "[") ? host.find(']') : host.rfind(':');
  if (absl::StartsWith(host, "[")) {
    if (end == absl::string_view::npos) return "";
    name = host.substr(1, end - 1);
    port = host.substr(end + 1);
  } else if (end != absl::string_view::npos) {
    name = host.substr(0, end);
    port = host.substr(end);
  }
  if (!port.empty() && (port[0] != ':' || port.size() > 6 ||
                        port.substr(1).find_first_not_of("0123456789") != absl::string_view::npos)) {
    return "";
  }
  return absl::AsciiStrToLower(name);
}

bool IsAddress(const std::string& name) {
  unsigned char buffer[16];
  return inet_pton(AF_INET, name.c_str(), buffer) == 1 || inet_pton(AF_INET6, name.c_str(), buffer) == 1;
}

bool IsJson(absl::string_view content_type) {
  const absl::string_view type = content_type.substr(0, content_type.find(';'));
  return absl::EqualsIgnoreCase(absl::StripAsciiWhitespace(type), "application/json");
}

}  // namespace

absl::Status LoopbackMayControl(const HttpRequestFacts& request) {
  absl::string_view address = request.remote_address;
  absl::ConsumePrefix(&address, "::ffff:");
  if (address == "::1" || absl::StartsWith(address, "127.")) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat("control is for this machine alone, and the request comes from ", Shown(address)));
}

absl::Status CheckHttpRequest(const HttpRequestFacts& request, const std::vector<std::string>& names) {
  const std::string name = NameOf(request.host);
  const bool known = name == "localhost" || IsAddress(name) ||
                     std::any_of(names.begin(), names.end(), [&](const std::string& allowed) {
                       return absl::AsciiStrToLower(allowed) == name;
                     });
  if (name.empty() || !known) {
    return absl::PermissionDeniedError(
        absl::StrCat("the host ", Shown(request.host), " is none of ours; permit its name with --http-name"));
  }
  if (!request.origin.empty() &&
      !absl::EqualsIgnoreCase(request.origin, absl::StrCat("http://", request.host)) &&
      !absl::EqualsIgnoreCase(request.origin, absl::StrCat("https://", request.host))) {
    return absl::PermissionDeniedError(
        absl::StrCat("a page of ", Shown(request.origin), " may not ask ", Shown(request.host)));
  }
  if (request.method == "GET" || request.method == "HEAD") return absl::OkStatus();
  if (request.method != "POST")
    return absl::InvalidArgumentError(absl::StrCat("the method ", Shown(request.method), " is not served"));
  if (!request.fetch_site.empty() && request.fetch_site != "same-origin") {
    return absl::PermissionDeniedError(
        absl::StrCat("a request that is ", Shown(request.fetch_site), " may not change anything"));
  }
  if (!IsJson(request.content_type)) return absl::InvalidArgumentError("the body must be application/json");
  if (request.marker.empty())
    return absl::PermissionDeniedError(absl::StrCat("the header ", kHttpMarker, " is missing"));
  return absl::OkStatus();
}

}  // namespace shutterline::server
