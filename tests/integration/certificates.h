#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace shutterline {

/// Runs `deploy/certs FOLDER ARGUMENTS`; fails the test where that fails.
void MakeCertificates(const std::filesystem::path& folder, const std::vector<std::string>& arguments);

/// The flags with which a client or a worker shows the certificate STEM.pem of the folder.
std::vector<std::string> CertificateFlags(const std::filesystem::path& folder, const std::string& stem);
/// The flags with which it shows the token STEM.token, over TLS.
std::vector<std::string> TokenFlags(const std::filesystem::path& folder, const std::string& stem);

}  // namespace shutterline
