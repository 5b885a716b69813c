#include "tests/bench/contenders.h"

#include <absl/strings/str_cat.h>

#include <optional>

#include "tests/bench/svg_plot.h"

namespace shutterline::bench {
namespace {

/// Settings that come with a method which this build may not have.
template <typename Settings>
void SetTargetError(Settings& settings, double error) {
  if constexpr (requires { settings.target_error; }) settings.target_error = error;
}

/// Lines with a pinned number of instants.
Rung Lines(PatternKind pattern, int instants, ResolverKind resolver) {
  return {absl::StrCat(std::string(ToString(pattern)), ", ", instants, " instants"), [=](RenderSettings& s) {
            s.integrator = IntegratorKind::kLine;
            s.resolver = resolver;
            s.pattern = pattern;
            s.time_samples = instants;
          }};
}

/// As fine as an error asks for.
Rung Target(double error) {
  return {absl::StrCat("error ", error), [=](RenderSettings& s) {
            s.integrator = IntegratorKind::kLine;
            s.resolver = ResolverKind::kSlice;
            SetTargetError(s, error);
          }};
}

Rung Defaults(ResolverKind resolver) {
  return {"defaults", [=](RenderSettings& s) {
            s.integrator = IntegratorKind::kLine;
            s.resolver = resolver;
          }};
}

Contender Slice(bool quick) {
  Contender slice{
      .name = "line/slice", .color = PlotColors()[0], .ours = true, .random = false, .ladder = {}};
  const ResolverKind kind = ResolverKind::kSlice;
  // Few lines at many instants are the best of few samples; more lines serve what stands still.
  for (const int instants : {4, 8, 16}) slice.ladder.push_back(Lines(PatternKind::k1h1v, instants, kind));
  for (const double error : {0.01, 0.005}) slice.ladder.push_back(Target(error));
  slice.default_rung = int(slice.ladder.size());
  slice.ladder.push_back(Defaults(kind));
  slice.ladder.push_back(Target(0.00125));
  slice.ladder.push_back(Lines(PatternKind::k4h4v, 16, kind));
  if (!quick) slice.ladder.push_back(Lines(PatternKind::k4h4v, 128, kind));
  return slice;
}

template <typename Settings>
void SetTimeCells(Settings& settings, int cells) {
  if constexpr (requires { settings.time_cells; }) settings.time_cells = cells;
}

/// Rays at instants that all pixels share, a static hierarchy for each; false where there are none.
template <typename Settings>
bool ShareInstants(Settings& settings) {
  if constexpr (requires { settings.reference_layout; }) {
    using Layout = decltype(settings.reference_layout);
    settings.reference_layout = Layout::kSharedInstants;
    return true;
  } else {
    return false;
  }
}

std::optional<Contender> Paper() {
  const auto kind = ParseResolver("paper");
  if (!kind) return std::nullopt;
  Contender paper{
      .name = "line/paper", .color = PlotColors()[3], .ours = true, .random = false, .ladder = {}};
  for (const auto& [pattern, cells] : {std::pair(PatternKind::k1h1v, 1),
                                       {PatternKind::k1h1v, 4},
                                       {PatternKind::kRgls, 1},
                                       {PatternKind::kRgls, 4},
                                       {PatternKind::kRgls, 16}}) {
    paper.ladder.push_back({absl::StrCat(std::string(ToString(pattern)), ", ", cells, " time cells"),
                            [=, pattern = pattern, cells = cells](RenderSettings& s) {
                              s.integrator = IntegratorKind::kLine;
                              s.resolver = *kind;
                              s.pattern = pattern;
                              SetTimeCells(s, cells);
                            }});
  }
  paper.default_rung = 3;
  return paper;
}

std::optional<Contender> Points(const std::string& integrator, const std::string& color, bool quick) {
  const auto kind = ParseIntegrator(integrator);
  if (!kind) return std::nullopt;
  Contender points{.name = integrator, .color = color, .ours = false, .random = true, .ladder = {}};
  const int most = quick ? 256 : 4096;  // Ladders end sooner where runs get long.
  for (int spp = 1; spp <= most; spp *= 4) {
    points.ladder.push_back({absl::StrCat(spp, " spp"), [=](RenderSettings& s) {
                               s.integrator = *kind;
                               s.spp = spp;
                             }});
  }
  return points;
}

/// The ray caster at its best layout for wide motion.
std::optional<Contender> SharedInstants(bool quick) {
  RenderSettings probe;
  std::optional<Contender> points = Points("reference", PlotColors()[5], quick);
  if (!points || !ShareInstants(probe)) return std::nullopt;
  points->name = "reference, shared instants";
  for (Rung& rung : points->ladder) {
    rung.apply = [inner = rung.apply](RenderSettings& s) {
      inner(s);
      ShareInstants(s);
    };
  }
  return points;
}

}  // namespace

std::vector<Contender> AllContenders(bool quick) {
  std::vector<Contender> all = {Slice(quick)};
  if (auto paper = Paper()) all.push_back(*std::move(paper));
  if (auto points = Points("stochastic", PlotColors()[2], quick)) all.push_back(*std::move(points));
  if (auto points = Points("reference", PlotColors()[1], quick)) all.push_back(*std::move(points));
  if (auto points = SharedInstants(quick)) all.push_back(*std::move(points));
  return all;
}

}  // namespace shutterline::bench
