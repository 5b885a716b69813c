#pragma once

#include <memory>
#include <string>

namespace grpc {
class Channel;
class ChannelCredentials;
}  // namespace grpc

namespace shutterline::worker {

/// A channel to a coordinator's "HOST:PORT", as secure as `credentials` are. Dials when it is first used and
/// again when it has to; notices a dead peer within 30 s.
std::shared_ptr<grpc::Channel> DialCoordinator(const std::string& host_port,
                                               const std::shared_ptr<grpc::ChannelCredentials>& credentials);

}  // namespace shutterline::worker
