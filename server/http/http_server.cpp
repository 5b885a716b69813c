#include "server/http/http_server.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>

#include <atomic>
#include <thread>
#include <utility>

#include "server/http/limited_server.h"
#include "server/http/routes.h"

namespace shutterline::server {

class HttpServer::Impl {
 public:
  explicit Impl(Parts parts) : routes_(std::move(parts)) {}
  ~Impl() { Stop(); }

  absl::Status Start(const std::string& listen) {
    const size_t colon = listen.rfind(':');
    absl::string_view host = absl::string_view(listen).substr(0, colon);
    if (absl::ConsumePrefix(&host, "[")) absl::ConsumeSuffix(&host, "]");
    if (colon == std::string::npos || !absl::SimpleAtoi(listen.substr(colon + 1), &port_))
      return absl::InvalidArgumentError(absl::StrCat("'", listen, "' is not HOST:PORT"));
    routes_.Install(server_);
    const std::string name(host);
    if (port_ == 0) {
      port_ = server_.bind_to_any_port(name);
    } else if (!server_.bind_to_port(name, port_)) {
      port_ = -1;
    }
    if (port_ <= 0) return absl::UnavailableError(absl::StrCat("cannot listen on ", listen, " for HTTP"));
    thread_ = std::thread([this] {
      server_.listen_after_bind();
      ended_ = true;
    });
    return absl::OkStatus();
  }

  void Stop() {
    if (stopped_.exchange(true)) return;
    routes_.EndStreams();
    if (!thread_.joinable()) return;
    // `stop` is for a server that runs; a thread that was only just started may not be that far.
    while (!server_.is_running() && !ended_) std::this_thread::yield();
    server_.stop();
    thread_.join();
  }

  int port() const { return port_; }

 private:
  Routes routes_;
  LimitedServer server_{LimitedServer::Limits()};
  std::thread thread_;
  std::atomic<bool> stopped_ = false, ended_ = false;
  int port_ = 0;
};

HttpServer::HttpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HttpServer::~HttpServer() = default;

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(Parts parts) {
  const std::string listen = parts.listen;
  auto impl = std::make_unique<Impl>(std::move(parts));
  const absl::Status started = impl->Start(listen);
  if (!started.ok()) return started;
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

int HttpServer::port() const {
  return impl_->port();
}
void HttpServer::Stop() {
  impl_->Stop();
}

}  // namespace shutterline::server
