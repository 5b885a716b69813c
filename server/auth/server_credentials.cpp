#include "server/auth/server_credentials.h"

#include <grpc/grpc_security_constants.h>

#include <utility>

#include "common/base/status_macros.h"
#include "proto/credentials/key_pair.h"

namespace shutterline::server {

absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> MakeServerCredentials(
    const ListenSecurity& security, std::shared_ptr<const Authorizer> authorizer) {
  std::shared_ptr<grpc::ServerCredentials> made;
  if (security.encrypts()) {
    SL_ASSIGN_OR_RETURN(credentials::KeyPair pair,
                        credentials::LoadKeyPair(security.tls_cert, security.tls_key));
    grpc::SslServerCredentialsOptions options(GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE);
    if (!security.tls_client_ca.empty()) {
      SL_ASSIGN_OR_RETURN(options.pem_root_certs, credentials::LoadAuthorities(security.tls_client_ca));
      options.client_certificate_request = GRPC_SSL_REQUEST_CLIENT_CERTIFICATE_AND_VERIFY;
    }
    options.pem_key_cert_pairs.push_back({std::move(pair.key), std::move(pair.certificate)});
    made = grpc::SslServerCredentials(options);
  } else if (security.authenticates()) {
    made = grpc::experimental::LocalServerCredentials(LOCAL_TCP);
  } else {
    return grpc::InsecureServerCredentials();
  }
  made->SetAuthMetadataProcessor(Authorizer::Processor(std::move(authorizer)));
  return made;
}

}  // namespace shutterline::server
