#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

namespace shutterline::bench {

/// A table as text: one row a run, every row with the same columns. Numbers are kept to the digits that
/// tell them apart.
class CsvTable {
 public:
  explicit CsvTable(std::vector<std::string> columns) : columns_(std::move(columns)) {}

  void AddRow(std::vector<std::string> cells);
  size_t rows() const { return rows_.size(); }

  /// As RFC 4180 wants it, with a line of column names.
  std::string ToString() const;
  absl::Status Write(const std::string& path) const;

 private:
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// A number for a cell; empty for what is not finite.
std::string Cell(double value);
std::string Cell(int64_t value);

}  // namespace shutterline::bench
