#include "server/jobs/sqlite.h"

#include <absl/strings/str_cat.h>
#include <sqlite3.h>

#include "common/base/retry_hint.h"

namespace shutterline::server {

absl::Status SqliteError(sqlite3* database, absl::string_view doing) {
  const std::string message = absl::StrCat("job store: ", doing, ": ", sqlite3_errmsg(database));
  switch (sqlite3_errcode(database) & 0xff) {
    case SQLITE_FULL:
      return WithRetryHint(absl::ResourceExhaustedError(message), absl::Seconds(1));
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::DataLossError(message);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return absl::FailedPreconditionError(message);
    default:
      return absl::UnavailableError(message);
  }
}

SqliteStatement::SqliteStatement(sqlite3* database, absl::string_view sql) : database_(database) {
  Keep(sqlite3_prepare_v2(database, sql.data(), int(sql.size()), &statement_, nullptr), "prepare");
}

SqliteStatement::~SqliteStatement() {
  sqlite3_finalize(statement_);
}

void SqliteStatement::Keep(int code, absl::string_view doing) {
  if (code != SQLITE_OK && status_.ok()) status_ = SqliteError(database_, doing);
}

SqliteStatement& SqliteStatement::Text(absl::string_view value) {
  if (status_.ok()) {
    Keep(sqlite3_bind_text64(statement_, ++bound_, value.data() ? value.data() : "", value.size(),
                             SQLITE_TRANSIENT, SQLITE_UTF8),
         "bind");
  }
  return *this;
}

SqliteStatement& SqliteStatement::Blob(absl::string_view value) {
  if (status_.ok()) {
    Keep(sqlite3_bind_blob64(statement_, ++bound_, value.data() ? value.data() : "", value.size(),
                             SQLITE_TRANSIENT),
         "bind");
  }
  return *this;
}

SqliteStatement& SqliteStatement::Int(int64_t value) {
  if (status_.ok()) Keep(sqlite3_bind_int64(statement_, ++bound_, value), "bind");
  return *this;
}

bool SqliteStatement::Step() {
  if (!status_.ok()) return false;
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) Keep(code, "step");
  return false;
}

absl::Status SqliteStatement::Run() {
  while (Step()) {
  }
  return status_;
}

int64_t SqliteStatement::ColumnInt(int column) {
  return sqlite3_column_int64(statement_, column);
}

std::string SqliteStatement::ColumnBytes(int column) {
  const void* data = sqlite3_column_blob(statement_, column);
  const int size = sqlite3_column_bytes(statement_, column);
  return data == nullptr ? std::string() : std::string(static_cast<const char*>(data), size_t(size));
}

bool SqliteStatement::ColumnIsNull(int column) {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

}  // namespace shutterline::server
