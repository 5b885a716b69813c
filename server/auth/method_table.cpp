#include "server/auth/method_table.h"

namespace shutterline::server {
namespace {

constexpr RoleSet kUsers = {Role::kClient, Role::kAdmin};
constexpr RoleSet kWorkers = {Role::kWorker};
constexpr RoleSet kAll = {Role::kClient, Role::kWorker, Role::kAdmin};

}  // namespace

const std::vector<MethodRule>& MethodTable() {
  static const auto& table = *new std::vector<MethodRule>{
      {"/shutterline.v1.Jobs/GetCapabilities", false, kAll},
      {"/shutterline.v1.Jobs/Submit", false, kUsers},
      {"/shutterline.v1.Jobs/Get", false, kUsers},
      {"/shutterline.v1.Jobs/List", false, kUsers},
      {"/shutterline.v1.Jobs/Watch", false, kUsers},
      {"/shutterline.v1.Jobs/Control", false, kUsers},
      {"/shutterline.v1.Jobs/FetchFrame", false, kUsers},
      {"/shutterline.v1.Jobs/ReadTiles", false, kUsers},
      {"/shutterline.v1.Jobs/ReadLog", false, kUsers},
      {"/shutterline.v1.Jobs/ReadTrace", false, kUsers},
      {"/shutterline.v1.Jobs/ListWorkers", false, kUsers},

      {"/shutterline.v1.Blobs/FindMissing", false, kUsers},
      {"/shutterline.v1.Blobs/Write", false, kUsers},
      {"/shutterline.v1.Blobs/QueryWrite", false, kUsers},
      // Clients have their files; those of others are none of their business.
      {"/shutterline.v1.Blobs/Read", false, {Role::kWorker, Role::kAdmin}},

      {"/shutterline.v1.Workers/Register", false, kWorkers},
      {"/shutterline.v1.Workers/Session", false, kWorkers},
      {"/shutterline.v1.Workers/PushResults", false, kWorkers},

      // Probes have no certificates, and learn no more than that somebody serves.
      {"/grpc.health.v1.Health/Check", true},
      {"/grpc.health.v1.Health/Watch", true},
      {"/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", false, kUsers},
  };
  return table;
}

const MethodRule* FindRule(absl::string_view path) {
  for (const MethodRule& rule : MethodTable()) {
    if (rule.path == path) return &rule;
  }
  return nullptr;
}

}  // namespace shutterline::server
