#include "server/schedule/worker_registry.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

namespace shutterline::server {
namespace {

TEST(WorkerRegistry, TakesNoMoreThanABound) {
  WorkerRegistry registry({"build", 1, 1});
  WorkerHello hello{"uuid", "boot", "build", "isa", "name", 1, 1, 1, {}};
  WorkerId last = 0;
  for (int i = 0; i < 8192; ++i) {
    hello.uuid = absl::StrCat("uuid-", i);
    const auto entry = registry.Register(hello, absl::ZeroDuration());
    ASSERT_TRUE(entry.ok()) << i << ": " << entry.status();
    last = (*entry)->id;
  }
  EXPECT_TRUE(absl::IsResourceExhausted(registry.Register(hello, absl::ZeroDuration()).status()));
  registry.Remove(last);
  EXPECT_TRUE(registry.Register(hello, absl::ZeroDuration()).ok());
}

}  // namespace
}  // namespace shutterline::server
