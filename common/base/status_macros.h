#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <utility>

namespace shutterline {

/// `status` with "<context>: " before its message; OK stays OK. Each layer says what it was doing.
inline absl::Status Annotate(const absl::Status& status, absl::string_view context) {
  if (status.ok()) return status;
  absl::Status result(status.code(), absl::StrCat(context, ": ", status.message()));
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& value) { result.SetPayload(url, value); });
  return result;
}

}  // namespace shutterline

#define SL_CONCAT_INNER(a, b) a##b
#define SL_CONCAT(a, b) SL_CONCAT_INNER(a, b)

/// Returns from the function if `expression` is a status that is not OK.
#define SL_RETURN_IF_ERROR(expression)                                            \
  do {                                                                            \
    if (absl::Status sl_status = (expression); !sl_status.ok()) return sl_status; \
  } while (false)

/// SL_ASSIGN_OR_RETURN(auto value, F()); assigns, or returns the status of the absl::StatusOr.
#define SL_ASSIGN_OR_RETURN(left, expression) \
  SL_ASSIGN_OR_RETURN_IMPL(SL_CONCAT(sl_or_, __LINE__), left, expression)
#define SL_ASSIGN_OR_RETURN_IMPL(temporary, left, expression) \
  auto temporary = (expression);                              \
  if (!temporary.ok()) return temporary.status();             \
  left = *std::move(temporary)
