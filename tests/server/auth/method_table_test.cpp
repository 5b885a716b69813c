#include "server/auth/method_table.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "shutterline/v1/blobs.pb.h"
#include "shutterline/v1/jobs.pb.h"
#include "shutterline/v1/workers.pb.h"

namespace shutterline::server {
namespace {

/// Every method of every service of the package, found by the .proto files that there are.
std::set<std::string> DeclaredMethods() {
  // Named, so that the linker keeps their descriptors.
  v1::DigestList().CheckInitialized();
  v1::JobRef().CheckInitialized();
  v1::Hello().CheckInitialized();
  std::set<std::string> methods;
  const std::filesystem::path folder =
      std::filesystem::path(SHUTTERLINE_SOURCE_DIR) / "proto" / "shutterline" / "v1";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream stream(entry.path());
    const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    if (!absl::StrContains(text, "\nservice ")) continue;
    const std::string name = absl::StrCat("shutterline/v1/", entry.path().filename().string());
    const auto* file = google::protobuf::DescriptorPool::generated_pool()->FindFileByName(name);
    EXPECT_NE(file, nullptr) << name << " is not linked in";
    if (file == nullptr) continue;
    for (int s = 0; s < file->service_count(); ++s) {
      const auto* service = file->service(s);
      for (int m = 0; m < service->method_count(); ++m) {
        methods.insert(absl::StrCat("/", service->full_name(), "/", service->method(m)->name()));
      }
    }
  }
  return methods;
}

TEST(MethodTable, NamesEveryMethodThatThereIsAndNoOther) {
  const std::set<std::string> declared = DeclaredMethods();
  EXPECT_GE(declared.size(), 15u);
  for (const std::string& method : declared) {
    EXPECT_NE(FindRule(method), nullptr) << method << ": say in server/auth/method_table.cpp who may call it";
  }
  for (const MethodRule& rule : MethodTable()) {
    if (!absl::StartsWith(rule.path, "/shutterline.")) continue;
    EXPECT_TRUE(declared.contains(std::string(rule.path))) << rule.path << " is declared nowhere";
  }
}

TEST(MethodTable, NamesEachMethodOnceAndIsOpenForHealthAlone) {
  std::set<std::string> seen;
  for (const MethodRule& rule : MethodTable()) {
    EXPECT_TRUE(seen.emplace(rule.path).second) << rule.path;
    EXPECT_EQ(rule.open, absl::StartsWith(rule.path, "/grpc.health.v1.Health/")) << rule.path;
    EXPECT_NE(rule.open, !rule.roles.empty()) << rule.path << ": either open or for some role";
  }
}

TEST(MethodTable, KeepsWorkersAndUsersApart) {
  for (const MethodRule& rule : MethodTable()) {
    const bool of_workers = absl::StartsWith(rule.path, "/shutterline.v1.Workers/");
    if (of_workers) {
      EXPECT_TRUE(!rule.roles.Has(Role::kClient) && !rule.roles.Has(Role::kAdmin)) << rule.path;
    }
    if (rule.path == "/shutterline.v1.Jobs/Submit") {
      EXPECT_FALSE(rule.roles.Has(Role::kWorker));
    }
  }
}

TEST(MethodTable, HasNoRuleForOtherPaths) {
  for (const char* path :
       {"", "/", "/shutterline.v1.Jobs/", "/shutterline.v1.Jobs/submit", "shutterline.v1.Jobs/Submit",
        "/shutterline.v1.Jobs/Submit/", "/shutterline.v2.Jobs/Submit"}) {
    EXPECT_EQ(FindRule(path), nullptr) << path;
  }
}

}  // namespace
}  // namespace shutterline::server
