#include "tests/support/shared_scenes.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace shutterline {

std::optional<std::string> FindSharedScenes() {
  const char* variable = std::getenv("SHUTTERLINE_SCENES");
  const std::string folder = variable != nullptr ? variable : SHUTTERLINE_SOURCE_DIR "/../shared/scenes";
  std::error_code error;
  if (std::filesystem::is_directory(folder, error)) return folder;
  std::fprintf(stderr,
               "\n*** NO TEST SCENES: %s is not a folder (SHUTTERLINE_SCENES names another).\n"
               "*** Tests that need them are SKIPPED.\n\n",
               folder.c_str());
  return std::nullopt;
}

}  // namespace shutterline
