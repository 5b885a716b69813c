#include "client/stats_report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <optional>
#include <utility>

#include "common/base/status_macros.h"
#include "proto/convert/render_stats.h"

namespace shutterline::client {
namespace {

/// What follows from the counts: a figure for people and for JSON, in one list.
struct Derived {
  absl::string_view name;    ///< In JSON.
  absl::string_view column;  ///< Of the table of frames.
  absl::string_view words;   ///< In the list of all figures.
  double over = 0, under = 0;
  int digits = 0;  ///< After the point.

  /// Nothing where `under` is nothing.
  std::optional<double> Value() const { return under > 0 ? std::optional(over / under) : std::nullopt; }
  std::string Text() const { return Value() ? absl::StrFormat("%.*f", digits, *Value()) : "-"; }
};

std::vector<Derived> DerivedOf(const FrameStats& f) {
  const RenderStats& s = f.stats;
  return {
      {"instants_per_line", "inst/line", "instants a line, on average", double(s.instants), double(s.lines),
       2},
      {"spans_per_segment", "seen/segm", "visible spans a segment", double(s.spans), double(s.segments), 3},
      {"tiles_per_thread_second", "tiles/s", "tiles a second of one thread", double(s.tiles),
       s.TotalSeconds(), 1},
      {"file_bytes_per_tile", "B/tile", "bytes a tile in the file", double(f.file_bytes),
       double(f.tiles_total), 0},
  };
}

constexpr int kWidth = 11;  // Of a column of the table.

std::string TilesText(const FrameStats& f) {
  return f.stats.tiles == f.tiles_total ? absl::StrCat(f.tiles_total)
                                        : absl::StrCat(f.stats.tiles, "/", f.tiles_total);
}

void PrintFrame(const std::string& name, const FrameStats& f, std::ostream& out) {
  out << absl::StreamFormat("%7s%*s", name, kWidth, TilesText(f));
  for (const auto& row : kRenderSeconds) out << absl::StreamFormat("%*.3f", kWidth, f.stats.*row.member);
  for (const Derived& figure : DerivedOf(f)) out << absl::StreamFormat("%*s", kWidth, figure.Text());
  out << "\n";
}

void PrintTable(const StatsReport& report, std::ostream& out) {
  out << absl::StreamFormat("%7s%*s", "frame", kWidth, "tiles");
  for (const auto& row : kRenderSeconds)
    out << absl::StreamFormat("%*s", kWidth, absl::StrCat(row.words, " s"));
  for (const Derived& figure : DerivedOf({})) out << absl::StreamFormat("%*s", kWidth, figure.column);
  out << "\n";
  for (const auto& [frame, stats] : report.frames) PrintFrame(absl::StrCat(frame), stats, out);
  if (report.frames.size() > 1) PrintFrame("all", report.Total(), out);
}

void PrintFigures(const FrameStats& total, std::ostream& out) {
  const auto line = [&out](absl::string_view words, const std::string& value) {
    out << absl::StreamFormat("  %-30s%s\n", words, value);
  };
  for (const auto& row : kRenderCounts) line(row.words, absl::StrCat(total.stats.*row.member));
  const double seconds = total.stats.TotalSeconds();
  for (const auto& row : kRenderSeconds) {
    const double part = total.stats.*row.member;
    line(row.words,
         absl::StrFormat("%.3f s of thread time%s", part,
                         seconds > 0 ? absl::StrFormat(", %.0f%%", 100 * part / seconds) : std::string()));
  }
  for (const Derived& figure : DerivedOf(total)) line(figure.words, figure.Text());
}

}  // namespace

FrameStats& FrameStats::operator+=(const FrameStats& other) {
  stats += other.stats;
  tiles_total += other.tiles_total;
  file_bytes += other.file_bytes;
  return *this;
}

FrameStats StatsReport::Total() const {
  FrameStats total;
  for (const auto& [frame, stats] : frames) total += stats;
  return total;
}

absl::StatusOr<StatsReport> MakeStatsReport(std::string method,
                                            const std::map<int, v1::FrameStatus>& frames) {
  StatsReport report{std::move(method), {}};
  for (const auto& [frame, status] : frames) {
    FrameStats& stats = report.frames[frame];
    stats.tiles_total = status.tiles_total();
    stats.file_bytes = status.size_bytes();
    SL_ASSIGN_OR_RETURN(stats.stats,
                        convert::FromProto(status.stats(), absl::StrCat("frame ", frame, ": stats")));
  }
  return report;
}

Json ToJson(const FrameStats& stats) {
  Json json;
  json["tiles_total"] = stats.tiles_total;
  json["file_bytes"] = stats.file_bytes;
  for (const auto& row : kRenderCounts) json[std::string(row.name)] = stats.stats.*row.member;
  for (const auto& row : kRenderSeconds) json[std::string(row.name)] = stats.stats.*row.member;
  json["thread_seconds"] = stats.stats.TotalSeconds();
  for (const Derived& figure : DerivedOf(stats)) {
    const std::optional<double> value = figure.Value();
    json[std::string(figure.name)] = value ? Json(*value) : Json(nullptr);
  }
  return json;
}

Json ToJson(const StatsReport& report) {
  Json frames = Json::array();
  for (const auto& [frame, stats] : report.frames) {
    Json json{{"frame", frame}};
    json.update(ToJson(stats));
    frames.push_back(std::move(json));
  }
  return {{"method", report.method}, {"frames", std::move(frames)}, {"total", ToJson(report.Total())}};
}

void PrintStats(const StatsReport& report, std::ostream& out) {
  if (report.frames.empty()) {
    out << "statistics: no frame is finished\n";
    return;
  }
  const FrameStats total = report.Total();
  out << "\n" << report.method << "\n\n";
  PrintTable(report, out);
  out << "\nall frames together\n";
  PrintFigures(total, out);
  if (total.stats.tiles < total.tiles_total) {
    out << absl::StreamFormat(
        "%d tiles were not measured: a coordinator that is restarted forgets what the tiles of unfinished "
        "frames "
        "took.\n",
        total.tiles_total - total.stats.tiles);
  }
  out << "How things move in a frame: shutterline info SCENE --frame N\n";
}

}  // namespace shutterline::client
