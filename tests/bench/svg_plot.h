#pragma once

#include <optional>
#include <string>
#include <vector>

/// Plots as SVG text, complete in themselves: no scripts, no fonts or styles from elsewhere.
namespace shutterline::bench {

struct PlotPoint {
  double x = 0, y = 0;
};

struct PlotSeries {
  std::string label;
  std::string color;                   ///< "#rrggbb"
  std::vector<PlotPoint> points = {};  ///< Drawn as marks.
  std::vector<PlotPoint> line = {};    ///< Drawn as a line through them, in order.
  bool hollow = false;                 ///< Marks are rings.
  std::optional<PlotPoint> star = {};  ///< One point that stands out.
};

struct PlotAxis {
  std::string label;
  bool log = true;
};

/// A horizontal line at `y`, named at its right end.
struct PlotRule {
  double y = 0;
  std::string label;
};

struct Plot {
  std::string title;
  PlotAxis x, y;
  std::vector<PlotSeries> series = {};
  std::vector<PlotRule> rules = {};
  int width = 460, height = 330;  ///< Pixels.
  bool legend = true;
};

/// Points that cannot stand on a log axis (not above 0), or are not finite, are left out.
std::string RenderPlot(const Plot& plot);

/// Horizontal bars, each of stacked parts.
struct BarChart {
  struct Bar {
    std::string label;
    std::vector<double> parts;  ///< One for each of part_labels.
    std::string note;           ///< Behind the bar.
  };
  std::string title, unit;
  std::vector<std::string> part_labels;
  std::vector<Bar> bars;
  int width = 760;
};
std::string RenderBars(const BarChart& chart);

/// The colours of series, distinct also for most who see few colours (Okabe and Ito's).
const std::vector<std::string>& PlotColors();

/// Text for XML.
std::string XmlEscape(const std::string& text);

}  // namespace shutterline::bench
