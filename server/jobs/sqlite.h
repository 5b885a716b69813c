#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace shutterline::server {

/// The status for the connection's last error: RESOURCE_EXHAUSTED (disk full), DATA_LOSS (damaged),
/// FAILED_PRECONDITION (locked by another process), otherwise UNAVAILABLE.
absl::Status SqliteError(sqlite3* database, absl::string_view doing);

/// A prepared statement: bind in order from 1, Step until it says false, read columns from 0. The first
/// error of any call is kept, later calls do nothing, and `status` tells it. Not thread-safe.
class SqliteStatement {
 public:
  SqliteStatement(sqlite3* database, absl::string_view sql);
  ~SqliteStatement();
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  SqliteStatement& Text(absl::string_view value);
  SqliteStatement& Blob(absl::string_view value);
  SqliteStatement& Int(int64_t value);

  /// True: there is a row to read.
  bool Step();
  int64_t ColumnInt(int column);
  std::string ColumnBytes(int column);
  bool ColumnIsNull(int column);

  const absl::Status& status() const { return status_; }
  /// Runs a statement that returns no rows.
  absl::Status Run();

 private:
  void Keep(int code, absl::string_view doing);

  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
  absl::Status status_;
};

}  // namespace shutterline::server
