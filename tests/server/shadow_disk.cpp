#include "tests/server/shadow_disk.h"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/base/check.h"

namespace shutterline::test {
namespace {

namespace fs = std::filesystem;
using Kind = server::FileOperation::Kind;

std::string Contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

ino_t Inode(const std::string& path) {
  struct stat info {};
  return ::stat(path.c_str(), &info) == 0 ? info.st_ino : 0;
}

}  // namespace

void ShadowDisk::Before(const server::FileOperation& operation) {
  Settle();
  pending_kind_ = operation.kind;
  pending_path_ = std::string(operation.path);
}

void ShadowDisk::Settle() {
  if (pending_kind_ == Kind::kSync) contents_[Inode(pending_path_)] = Contents(pending_path_);
  if (pending_kind_ == Kind::kSyncFolder) {
    std::map<std::string, ino_t>& names = names_[pending_path_];
    names.clear();
    for (const auto& entry : fs::directory_iterator(pending_path_)) {
      names[entry.path().filename().string()] = Inode(entry.path().string());
    }
  }
  pending_kind_ = Kind::kWrite;
}

void ShadowDisk::Restore(const std::string& target) const {
  if (!fs::exists(folder_)) return;
  RestoreFolder(folder_, target);
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const fs::path name = entry.path().filename();
    if (name.string().rfind("jobs.sqlite", 0) != 0) continue;
    fs::copy_file(entry.path(), fs::path(target) / name, fs::copy_options::overwrite_existing);
  }
}

void ShadowDisk::RestoreFolder(const std::string& path, const std::string& target) const {
  fs::create_directories(target);
  const auto names = names_.find(path);
  if (names == names_.end()) return;
  for (const auto& [name, inode] : names->second) {
    const std::string from = path + "/" + name, to = target + "/" + name;
    if (fs::is_directory(from)) {
      RestoreFolder(from, to);
      continue;
    }
    const auto contents = contents_.find(inode);
    std::ofstream(to, std::ios::binary) << (contents == contents_.end() ? std::string() : contents->second);
  }
}

}  // namespace shutterline::test
