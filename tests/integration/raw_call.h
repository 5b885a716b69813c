#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

namespace shutterline {

/// A channel of its own, which knows nothing of other channels' connections.
std::shared_ptr<grpc::Channel> OwnChannel(const std::string& address,
                                          const std::shared_ptr<grpc::ChannelCredentials>& credentials);

/// One message there and one back, by the method's path and as bytes: what a client without our stubs may
/// try. Streaming methods get the message and the end of the stream.
grpc::Status RawCall(const std::shared_ptr<grpc::Channel>& channel, const std::string& path,
                     const std::string& message = "");

}  // namespace shutterline
