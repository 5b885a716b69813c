#include "tests/integration/certificates.h"

#include <gtest/gtest.h>

#include "tests/support/process.h"

namespace shutterline {

void MakeCertificates(const std::filesystem::path& folder, const std::vector<std::string>& arguments) {
  std::vector<std::string> all = {SHUTTERLINE_SOURCE_DIR "/deploy/certs", folder.string()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const auto made = Process::Start(all, folder.parent_path() / "certs");
  ASSERT_NE(made, nullptr);
  ASSERT_EQ(made->Wait(), 0) << made->Errors();
}

std::vector<std::string> CertificateFlags(const std::filesystem::path& folder, const std::string& stem) {
  return {"--tls-ca",  folder / "ca.pem",       "--tls-cert", folder / (stem + ".pem"),
          "--tls-key", folder / (stem + ".key")};
}

std::vector<std::string> TokenFlags(const std::filesystem::path& folder, const std::string& stem) {
  return {"--tls-ca", folder / "ca.pem", "--token-file", folder / (stem + ".token")};
}

}  // namespace shutterline
