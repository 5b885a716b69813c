#pragma once

#include <memory>
#include <string>

namespace grpc {
class Channel;
}

namespace shutterline::worker {

/// A channel to a coordinator's "HOST:PORT", not encrypted. Dials when it is first used and again when it
/// has to; notices a dead peer within 30 s.
std::shared_ptr<grpc::Channel> DialCoordinator(const std::string& host_port);

}  // namespace shutterline::worker
