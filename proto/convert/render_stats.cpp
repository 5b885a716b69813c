#include "proto/convert/render_stats.h"

#include <absl/strings/str_cat.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <string>

#include "common/base/check.h"

namespace shutterline::convert {
namespace {

/// The message's field of this name. That there is one for each row is a matter of the build, which a test
/// holds.
const google::protobuf::FieldDescriptor& FieldNamed(absl::string_view name) {
  const auto* field = v1::RenderStats::descriptor()->FindFieldByName(std::string(name));
  SL_CHECK(field != nullptr);
  return *field;
}

}  // namespace

v1::RenderStats ToProto(const RenderStats& stats) {
  v1::RenderStats message;
  const google::protobuf::Reflection& fields = *message.GetReflection();
  for (const auto& row : kRenderCounts) fields.SetInt64(&message, &FieldNamed(row.name), stats.*row.member);
  for (const auto& row : kRenderSeconds) fields.SetDouble(&message, &FieldNamed(row.name), stats.*row.member);
  return message;
}

absl::StatusOr<RenderStats> FromProto(const v1::RenderStats& message, absl::string_view field) {
  RenderStats stats;
  const google::protobuf::Reflection& fields = *message.GetReflection();
  const auto refuse = [&](absl::string_view name, auto value, absl::string_view rule) {
    return absl::InvalidArgumentError(absl::StrCat(field, ".", name, ": is ", value, ", but must be ", rule));
  };
  for (const auto& row : kRenderCounts) {
    const int64_t value = fields.GetInt64(message, &FieldNamed(row.name));
    if (value < 0) return refuse(row.name, value, "at least 0");
    stats.*row.member = value;
  }
  for (const auto& row : kRenderSeconds) {
    const double value = fields.GetDouble(message, &FieldNamed(row.name));
    // Written so that NaN is refused as well.
    if (!(value >= 0 && value <= kMaxStatsSeconds)) {
      return refuse(row.name, value, absl::StrCat("from 0 to ", kMaxStatsSeconds, " seconds"));
    }
    stats.*row.member = value;
  }
  return stats;
}

}  // namespace shutterline::convert
