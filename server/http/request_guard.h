#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <functional>
#include <string>
#include <vector>

namespace shutterline::server {

/// What of an HTTP request decides whether it is answered. Absent headers are empty.
struct HttpRequestFacts {
  std::string method;
  std::string path;        ///< For logs alone.
  std::string host;        ///< The Host header.
  std::string origin;      ///< Of the page that asks; browsers alone send it.
  std::string fetch_site;  ///< Sec-Fetch-Site: likewise.
  std::string content_type;
  std::string marker;          ///< kHttpMarker's value.
  std::string remote_address;  ///< Numeric, of the peer.
};

/// A header that a form or an image of another site cannot send: asks for a preflight, which we never grant.
inline constexpr char kHttpMarker[] = "X-Shutterline-Request";

/// Whether a request may change something. PERMISSION_DENIED or UNAUTHENTICATED with the reason. The one
/// place where roles come in; it is asked after CheckHttpRequest.
using MayControl = std::function<absl::Status(const HttpRequestFacts&)>;

/// Those that come from this machine.
absl::Status LoopbackMayControl(const HttpRequestFacts& request);

/// Refuses what a browser may send on behalf of another site.
///
/// - Host must be an address, `localhost` or one of `names`: a page whose name was rebound to our address
///   (DNS rebinding) still sends its own name.
/// - Origin, where there is one, must be this very host.
/// - What is no GET or HEAD must be a POST of JSON with kHttpMarker, from the same origin.
///
/// PERMISSION_DENIED or INVALID_ARGUMENT with the reason.
absl::Status CheckHttpRequest(const HttpRequestFacts& request, const std::vector<std::string>& names);

}  // namespace shutterline::server
