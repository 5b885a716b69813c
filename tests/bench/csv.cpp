#include "tests/bench/csv.h"

#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <cmath>

#include "common/base/atomic_file.h"
#include "common/base/check.h"

namespace shutterline::bench {
namespace {

std::string Quoted(const std::string& cell) {
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) {
    quoted += c;
    if (c == '"') quoted += c;
  }
  return quoted + "\"";
}

std::string Line(const std::vector<std::string>& cells) {
  return absl::StrJoin(cells, ",", [](std::string* out, const std::string& cell) { *out += Quoted(cell); }) +
         "\n";
}

}  // namespace

void CsvTable::AddRow(std::vector<std::string> cells) {
  SL_CHECK(cells.size() == columns_.size());
  rows_.push_back(std::move(cells));
}

std::string CsvTable::ToString() const {
  std::string text = Line(columns_);
  for (const auto& row : rows_) text += Line(row);
  return text;
}

absl::Status CsvTable::Write(const std::string& path) const {
  return WriteFileAtomically(path, ToString());
}

std::string Cell(double value) {
  return std::isfinite(value) ? absl::StrFormat("%.6g", value) : "";
}

std::string Cell(int64_t value) {
  return absl::StrFormat("%d", value);
}

}  // namespace shutterline::bench
