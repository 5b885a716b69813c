#include "proto/convert/render_stats.h"

#include <absl/strings/str_cat.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <string>
#include <vector>

#include "common/base/check.h"

namespace shutterline::convert {
namespace {

using Field = google::protobuf::FieldDescriptor;

/// The message's fields of the rows' names, found once: each tile is converted. That there is one for each
/// row is a matter of the build, which a test holds.
template <typename Rows>
std::vector<const Field*> FieldsOf(const Rows& rows) {
  std::vector<const Field*> fields;
  for (const auto& row : rows) {
    fields.push_back(v1::RenderStats::descriptor()->FindFieldByName(std::string(row.name)));
    SL_CHECK(fields.back() != nullptr);
  }
  return fields;
}
const std::vector<const Field*>& CountFields() {
  static const auto* const fields = new std::vector<const Field*>(FieldsOf(kRenderCounts));
  return *fields;
}
const std::vector<const Field*>& SecondFields() {
  static const auto* const fields = new std::vector<const Field*>(FieldsOf(kRenderSeconds));
  return *fields;
}

}  // namespace

v1::RenderStats ToProto(const RenderStats& stats) {
  v1::RenderStats message;
  const google::protobuf::Reflection& fields = *message.GetReflection();
  const Field* const* count = CountFields().data();
  for (const auto& row : kRenderCounts) fields.SetInt64(&message, *count++, stats.*row.member);
  const Field* const* second = SecondFields().data();
  for (const auto& row : kRenderSeconds) fields.SetDouble(&message, *second++, stats.*row.member);
  return message;
}

absl::StatusOr<RenderStats> FromProto(const v1::RenderStats& message, absl::string_view field) {
  RenderStats stats;
  const google::protobuf::Reflection& fields = *message.GetReflection();
  const auto refuse = [&](absl::string_view name, auto value, absl::string_view rule) {
    return absl::InvalidArgumentError(absl::StrCat(field, ".", name, ": is ", value, ", but must be ", rule));
  };
  const Field* const* count = CountFields().data();
  for (const auto& row : kRenderCounts) {
    const int64_t value = fields.GetInt64(message, *count++);
    if (value < 0) return refuse(row.name, value, "at least 0");
    stats.*row.member = value;
  }
  const Field* const* second = SecondFields().data();
  for (const auto& row : kRenderSeconds) {
    const double value = fields.GetDouble(message, *second++);
    // Written so that NaN is refused as well.
    if (!(value >= 0 && value <= kMaxStatsSeconds)) {
      return refuse(row.name, value, absl::StrCat("from 0 to ", kMaxStatsSeconds, " seconds"));
    }
    stats.*row.member = value;
  }
  return stats;
}

}  // namespace shutterline::convert
