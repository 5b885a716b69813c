#include "client/server_option.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "client/human.h"
#include "client/parse.h"
#include "common/base/status_macros.h"
#include "proto/credentials/channel_credentials.h"

namespace shutterline::client {

absl::Status CheckHostPort(absl::string_view text) {
  const absl::Status refused = absl::InvalidArgumentError(
      "must be HOST:PORT with a port from 1 to 65535, as in localhost:7400 or [::1]:7400");
  const size_t colon = text.rfind(':');
  if (colon == absl::string_view::npos || !ParseWhole(text.substr(colon + 1), 1, 65535).ok()) return refused;
  absl::string_view host = text.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
    const bool address = std::all_of(host.begin(), host.end(), [](char c) {
      return absl::ascii_isxdigit(static_cast<unsigned char>(c)) || c == ':' || c == '.';
    });
    return address ? absl::OkStatus() : refused;
  }
  const bool name = !host.empty() && host.size() <= 253 && std::all_of(host.begin(), host.end(), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.' || c == '_';
  });
  return name ? absl::OkStatus() : refused;
}

void ServerOption::Declare(CLI::App& app) {
  AddValue(app, "--server", "HOST:PORT", "$SHUTTERLINE_SERVER", "The coordinator to speak to",
           [this](const std::string& text) {
             SL_RETURN_IF_ERROR(CheckHostPort(text));
             host_port_ = text;
             return absl::OkStatus();
           })
      ->envname("SHUTTERLINE_SERVER");
  const struct {
    const char *name, *variable, *description;
    std::string& file;
  } files[] = {
      {"--tls-ca", "SHUTTERLINE_TLS_CA",
       "Authority (PEM) that the server is checked by:\neverything is encrypted", security_.tls_ca},
      {"--tls-cert", "SHUTTERLINE_TLS_CERT", "Your certificate (PEM)", security_.tls_cert},
      {"--tls-key", "SHUTTERLINE_TLS_KEY", "Its private key (PEM)", security_.tls_key},
      {"--token-file", "SHUTTERLINE_TOKEN_FILE",
       "File of a token, which says who you are instead\nof a certificate", security_.token_file},
  };
  for (const auto& option : files) {
    std::string& file = option.file;
    AddValue(app, option.name, "FILE", absl::StrCat("$", option.variable), option.description,
             [&file](const std::string& text) {
               file = text;
               return absl::OkStatus();
             })
        ->envname(option.variable)
        ->group("Security");
  }
}

absl::Status ServerOption::Check() const {
  if (!host_port_.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "no coordinator is named: give --server HOST:PORT or set SHUTTERLINE_SERVER");
}

absl::StatusOr<std::unique_ptr<Connection>> ServerOption::Connect(Console& console, Interrupt* interrupt,
                                                                  bool quiet) const {
  Connection::Options options;
  options.interrupt = interrupt;
  if (!quiet) {
    options.on_wait = [&console](absl::string_view text) {
      console.err << Printable(text) << "\n" << std::flush;
    };
  }
  SL_ASSIGN_OR_RETURN(const auto credentials, credentials::MakeChannelCredentials(security_, host_port_));
  std::unique_ptr<Connection> connection = Connection::Dial(host_port_, credentials, std::move(options));
  SL_RETURN_IF_ERROR(Greet(*connection).status());
  return connection;
}

}  // namespace shutterline::client
