#include "tests/server/sqlite_faults.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "common/base/check.h"
#include "server/files/file_faults.h"

namespace shutterline::test {
namespace {

using server::AskFileFaults;
using server::FileFaults;
using Kind = server::FileOperation::Kind;

bool Fails(Kind kind) {
  const int error = AskFileFaults({kind, "sqlite", 0}).error;
  if (error != 0) errno = error;
  return error != 0;
}

int Open(const char* path, int flags, int mode) {
  if ((flags & O_CREAT) != 0 && Fails(Kind::kCreate)) return -1;
  return ::open(path, flags, mode);
}

ssize_t Pwrite(int fd, const void* data, size_t count, off_t offset) {
  const FileFaults::Verdict verdict = AskFileFaults({Kind::kWrite, "sqlite", count});
  if (verdict.error != 0) {
    errno = verdict.error;
    return -1;
  }
  return ::pwrite(fd, data, std::min(count, verdict.bytes), offset);
}

int Ftruncate(int fd, off_t size) {
  return Fails(Kind::kTruncate) ? -1 : ::ftruncate(fd, size);
}

int Unlink(const char* path) {
  return Fails(Kind::kRemove) ? -1 : ::unlink(path);
}

template <typename Function>
void Replace(const char* name, Function* function) {
  sqlite3_vfs* const vfs = sqlite3_vfs_find(nullptr);
  SL_CHECK(vfs != nullptr && vfs->xSetSystemCall != nullptr);
  SL_CHECK(vfs->xSetSystemCall(vfs, name, reinterpret_cast<sqlite3_syscall_ptr>(function)) == SQLITE_OK);
}

}  // namespace

void LetFaultsSeeSqlite() {
  Replace("open", &Open);
  Replace("pwrite", &Pwrite);
  Replace("pwrite64", &Pwrite);  // Which of the two is used depends on how SQLite was built.
  Replace("ftruncate", &Ftruncate);
  Replace("unlink", &Unlink);
}

}  // namespace shutterline::test
