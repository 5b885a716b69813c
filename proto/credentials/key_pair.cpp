#include "proto/credentials/key_pair.h"

#include <absl/strings/str_cat.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <memory>

#include "common/base/status_macros.h"
#include "proto/credentials/private_file.h"

namespace shutterline::credentials {
namespace {

using BioPtr = std::unique_ptr<BIO, decltype(&BIO_free)>;
using X509Ptr = std::unique_ptr<X509, decltype(&X509_free)>;
using KeyPtr = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

BioPtr BioOver(const std::string& pem) {
  return BioPtr(BIO_new_mem_buf(pem.data(), int(pem.size())), &BIO_free);
}

/// An encrypted key must not ask for its password on the terminal of a service.
int NoPassword(char*, int, int, void*) {
  return -1;
}

std::string TimeText(const ASN1_TIME* time) {
  const BioPtr bio(BIO_new(BIO_s_mem()), &BIO_free);
  if (ASN1_TIME_print(bio.get(), time) != 1) return "an unknown time";
  char text[64] = {};
  const int length = BIO_read(bio.get(), text, sizeof text - 1);
  return std::string(text, size_t(length > 0 ? length : 0));
}

/// The first certificate of the file, checked for its time.
absl::StatusOr<X509Ptr> FirstCertificate(const std::string& pem, const std::string& file) {
  const BioPtr bio = BioOver(pem);
  X509Ptr certificate(PEM_read_bio_X509(bio.get(), nullptr, &NoPassword, nullptr), &X509_free);
  ERR_clear_error();
  if (certificate == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(file, ": holds no certificate in PEM"));
  }
  if (X509_cmp_current_time(X509_get0_notBefore(certificate.get())) > 0) {
    return absl::FailedPreconditionError(absl::StrCat(file, ": the certificate is valid from ",
                                                      TimeText(X509_get0_notBefore(certificate.get())),
                                                      " only; is the clock right?"));
  }
  if (X509_cmp_current_time(X509_get0_notAfter(certificate.get())) < 0) {
    return absl::FailedPreconditionError(absl::StrCat(file, ": the certificate has expired on ",
                                                      TimeText(X509_get0_notAfter(certificate.get()))));
  }
  return certificate;
}

}  // namespace

absl::StatusOr<KeyPair> LoadKeyPair(const std::string& certificate_file, const std::string& key_file) {
  KeyPair pair;
  SL_ASSIGN_OR_RETURN(pair.certificate,
                      ReadPrivateFile(certificate_file, "the certificate", Secrecy::kPublic));
  SL_ASSIGN_OR_RETURN(pair.key, ReadPrivateFile(key_file, "the key", Secrecy::kSecret));
  SL_ASSIGN_OR_RETURN(const X509Ptr certificate, FirstCertificate(pair.certificate, certificate_file));
  const BioPtr bio = BioOver(pair.key);
  const KeyPtr key(PEM_read_bio_PrivateKey(bio.get(), nullptr, &NoPassword, nullptr), &EVP_PKEY_free);
  ERR_clear_error();
  if (key == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(key_file, ": holds no private key in PEM without password"));
  }
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    ERR_clear_error();
    return absl::InvalidArgumentError(
        absl::StrCat(key_file, ": is not the key of the certificate ", certificate_file));
  }
  return pair;
}

absl::StatusOr<std::string> LoadAuthorities(const std::string& file) {
  SL_ASSIGN_OR_RETURN(std::string pem, ReadPrivateFile(file, "the authorities", Secrecy::kPublic));
  SL_RETURN_IF_ERROR(FirstCertificate(pem, file).status());
  return pem;
}

}  // namespace shutterline::credentials
