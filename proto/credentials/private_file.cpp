#include "proto/credentials/private_file.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace shutterline::credentials {
namespace {

constexpr off_t kMaxBytes = 1 << 20;

/// Closes a descriptor.
struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

}  // namespace

absl::StatusOr<std::string> ReadPrivateFile(const std::string& path, absl::string_view what,
                                            Secrecy secrecy) {
  const std::string name = absl::StrCat(what, " ", path);
  // Without O_NONBLOCK a named pipe would hold us up before we can refuse it.
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (file.fd < 0) return absl::ErrnoToStatus(errno, absl::StrCat("read ", name));
  struct stat facts {};
  if (::fstat(file.fd, &facts) != 0) return absl::ErrnoToStatus(errno, absl::StrCat("look at ", name));
  if (!S_ISREG(facts.st_mode)) return absl::InvalidArgumentError(absl::StrCat(name, ": is no regular file"));
  const mode_t mode = facts.st_mode & 0777;
  const mode_t forbidden = secrecy == Secrecy::kSecret ? 0027 : 0022;
  if ((mode & forbidden) != 0) {
    return absl::PermissionDeniedError(absl::StrFormat("%s: others may %s it (mode %04o); use chmod %s", name,
                                                       (mode & 0022) != 0 ? "write" : "read", mode,
                                                       secrecy == Secrecy::kSecret ? "0600" : "0644"));
  }
  if (facts.st_size == 0) return absl::InvalidArgumentError(absl::StrCat(name, ": is empty"));
  if (facts.st_size > kMaxBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": has ", facts.st_size, " bytes, but at most ", kMaxBytes, " are read"));
  }
  std::string bytes(size_t(facts.st_size), '\0');
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::read(file.fd, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return absl::ErrnoToStatus(errno, absl::StrCat("read ", name));
    if (count == 0) break;
    done += size_t(count);
  }
  bytes.resize(done);
  return bytes;
}

}  // namespace shutterline::credentials
