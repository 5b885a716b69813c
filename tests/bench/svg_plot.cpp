#include "tests/bench/svg_plot.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>

namespace shutterline::bench {
namespace {

constexpr const char* kFont = "font-family=\"Helvetica Neue, Helvetica, Arial, sans-serif\"";

std::string Number(double value) {
  return absl::StrFormat("%.2f", value);
}

/// As people write it: 0.005, 20, 1000; powers of ten beyond.
std::string TickLabel(double value) {
  if (value == 0) return "0";
  if (std::abs(value) >= 1e-4 && std::abs(value) < 1e5) return absl::StrFormat("%g", value);
  const int exponent = int(std::floor(std::log10(std::abs(value)) + 1e-9));
  const double mantissa = value / std::pow(10, exponent);
  const std::string power = absl::StrCat("10<tspan dy=\"-4\" font-size=\"8\">", exponent, "</tspan>");
  if (std::abs(mantissa - 1) < 1e-6) return power;
  return absl::StrCat(absl::StrFormat("%g", mantissa), "·", power);
}

/// From values to pixels along one axis, and where its ticks are.
class Scale {
 public:
  Scale(bool log, double low, double high, double from, double to) : log_(log), from_(from), to_(to) {
    if (log) {
      low_ = std::log10(low);
      high_ = std::log10(high);
      const double margin = std::max(0.04 * (high_ - low_), 0.06);
      low_ -= margin;
      high_ += margin;
      LogTicks();
    } else {
      low_ = low;
      high_ = high > low ? high + 0.03 * (high - low) : low + 1;
      LinearTicks();
    }
  }
  double At(double value) const {
    return from_ + ((log_ ? std::log10(value) : value) - low_) / (high_ - low_) * (to_ - from_);
  }
  struct Tick {
    double value;
    bool labelled;
  };
  const std::vector<Tick>& ticks() const { return ticks_; }

 private:
  /// Every decade, 2 and 5 in between where there is room, the rest as small ticks.
  void LogTicks() {
    const double decades = high_ - low_;
    for (int e = int(std::floor(low_)); e <= int(std::ceil(high_)); ++e) {
      for (int m = 1; m < 10; ++m) {
        const double value = m * std::pow(10, e), place = std::log10(value);
        if (place < low_ || place > high_) continue;
        const bool some = m == 1 || (decades < 2.6 && (m == 2 || m == 5)) || (decades < 0.7);
        ticks_.push_back({value, some});
      }
    }
  }
  void LinearTicks() {
    const double raw = (high_ - low_) / 5, power = std::pow(10, std::floor(std::log10(raw)));
    double step = 10 * power;
    for (const double m : {5.0, 2.0, 1.0}) {
      if (raw <= m * power) step = m * power;
    }
    for (double v = std::ceil(low_ / step) * step; v <= high_ + 1e-9 * step; v += step) {
      ticks_.push_back({std::abs(v) < 1e-9 * step ? 0 : v, true});
    }
  }

  bool log_;
  double from_, to_, low_ = 0, high_ = 1;
  std::vector<Tick> ticks_;
};

bool Stands(const Plot& plot, const PlotPoint& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && (!plot.x.log || p.x > 0) && (!plot.y.log || p.y > 0);
}

struct Range {
  double low = INFINITY, high = -INFINITY;
  void Add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

struct Ranges {
  Range x, y;
};

Ranges RangesOf(const Plot& plot) {
  Ranges r;
  const auto add = [&](const PlotPoint& p) {
    if (!Stands(plot, p)) return;
    r.x.Add(p.x);
    r.y.Add(p.y);
  };
  for (const PlotSeries& series : plot.series) {
    for (const PlotPoint& p : series.points) add(p);
    for (const PlotPoint& p : series.line) add(p);
    if (series.star) add(*series.star);
  }
  for (const PlotRule& rule : plot.rules) {
    if (!plot.y.log || rule.y > 0) r.y.Add(rule.y);
  }
  for (const auto& [range, axis] : {std::pair(&r.x, &plot.x), std::pair(&r.y, &plot.y)}) {
    if (!axis->log) range->Add(0);
    if (range->low > range->high) *range = {axis->log ? 0.1 : 0.0, 1};
  }
  return r;
}

std::string StarPath(double x, double y) {
  std::string path;
  for (int i = 0; i < 10; ++i) {
    const double angle = M_PI * i / 5, radius = i % 2 == 0 ? 8 : 3.6;
    absl::StrAppend(&path, i == 0 ? "M" : "L", Number(x + radius * std::sin(angle)), ",",
                    Number(y - radius * std::cos(angle)));
  }
  return path + "Z";
}

std::string Text(double x, double y, const char* anchor, int size, const std::string& markup,
                 const char* extra = "") {
  return absl::StrCat("<text x=\"", Number(x), "\" y=\"", Number(y), "\" text-anchor=\"", anchor,
                      "\" font-size=\"", size, "\" ", extra, ">", markup, "</text>\n");
}

std::string Open(int width, int height, const std::string& title) {
  return absl::StrCat("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 ", width, " ", height,
                      "\" width=\"", width, "\" height=\"", height, "\" ", kFont,
                      " fill=\"#222\" role=\"img\">\n<title>", XmlEscape(title), "</title>\n<rect width=\"",
                      width, "\" height=\"", height, "\" fill=\"#ffffff\"/>\n");
}

}  // namespace

std::string XmlEscape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 32 || c == '\n' || c == '\t') out += c;
    }
  }
  return out;
}

const std::vector<std::string>& PlotColors() {
  static const std::vector<std::string> colors = {"#d55e00", "#0072b2", "#009e73", "#cc79a7",
                                                  "#e69f00", "#56b4e9", "#555555"};
  return colors;
}

std::string RenderPlot(const Plot& plot) {
  const int legend_rows = plot.legend ? int(plot.series.size() + 1) / 2 : 0;
  const double left = 58, right = plot.width - 16.0, top = plot.title.empty() ? 14 : 32,
               bottom = plot.height - 44.0 - 16 * legend_rows;
  const Ranges ranges = RangesOf(plot);
  const Scale x(plot.x.log, ranges.x.low, ranges.x.high, left, right);
  const Scale y(plot.y.log, ranges.y.low, ranges.y.high, bottom, top);

  std::string svg = Open(plot.width, plot.height, plot.title);
  if (!plot.title.empty()) svg += Text(left, 19, "start", 13, XmlEscape(plot.title), "font-weight=\"600\"");
  // Grid, ticks and their labels.
  for (const Scale::Tick& tick : x.ticks()) {
    const std::string at = Number(x.At(tick.value));
    absl::StrAppend(&svg, "<path d=\"M", at, ",", Number(top), "V", Number(bottom), "\" stroke=\"",
                    tick.labelled ? "#dddddd" : "#f1f1f1", "\"/>\n");
    if (tick.labelled) svg += Text(x.At(tick.value), bottom + 14, "middle", 10, TickLabel(tick.value));
  }
  for (const Scale::Tick& tick : y.ticks()) {
    const std::string at = Number(y.At(tick.value));
    absl::StrAppend(&svg, "<path d=\"M", Number(left), ",", at, "H", Number(right), "\" stroke=\"",
                    tick.labelled ? "#dddddd" : "#f1f1f1", "\"/>\n");
    if (tick.labelled) svg += Text(left - 5, y.At(tick.value) + 3.5, "end", 10, TickLabel(tick.value));
  }
  absl::StrAppend(&svg, "<path d=\"M", Number(left), ",", Number(top), "V", Number(bottom), "H",
                  Number(right), "\" fill=\"none\" stroke=\"#444444\"/>\n");
  svg += Text((left + right) / 2, bottom + 31, "middle", 11, XmlEscape(plot.x.label));
  svg +=
      Text(0, 0, "middle", 11, XmlEscape(plot.y.label),
           absl::StrCat("transform=\"translate(13,", Number((top + bottom) / 2), ") rotate(-90)\"").c_str());
  for (const PlotRule& rule : plot.rules) {
    if (plot.y.log && rule.y <= 0) continue;
    const std::string at = Number(y.At(rule.y));
    absl::StrAppend(&svg, "<path d=\"M", Number(left), ",", at, "H", Number(right),
                    "\" stroke=\"#999999\" stroke-dasharray=\"4 3\"/>\n");
    svg += Text(right - 3, y.At(rule.y) - 3, "end", 9, XmlEscape(rule.label), "fill=\"#777777\"");
  }
  // Series, the first on top.
  for (size_t i = plot.series.size(); i-- > 0;) {
    const PlotSeries& series = plot.series[i];
    std::string path;
    for (const PlotPoint& p : series.line) {
      if (!Stands(plot, p)) continue;
      absl::StrAppend(&path, path.empty() ? "M" : "L", Number(x.At(p.x)), ",", Number(y.At(p.y)));
    }
    if (!path.empty()) {
      absl::StrAppend(&svg, "<path d=\"", path, "\" fill=\"none\" stroke=\"", series.color,
                      "\" stroke-width=\"1.8\" stroke-linejoin=\"round\"/>\n");
    }
    for (const PlotPoint& p : series.points) {
      if (!Stands(plot, p)) continue;
      absl::StrAppend(&svg, "<circle cx=\"", Number(x.At(p.x)), "\" cy=\"", Number(y.At(p.y)),
                      "\" r=\"3\" stroke=\"", series.color, "\" stroke-width=\"1.3\" fill=\"",
                      series.hollow ? "#ffffff" : series.color, "\"/>\n");
    }
    if (series.star && Stands(plot, *series.star)) {
      absl::StrAppend(&svg, "<path d=\"", StarPath(x.At(series.star->x), y.At(series.star->y)), "\" fill=\"",
                      series.color, "\" stroke=\"#ffffff\"/>\n");
    }
  }
  for (size_t i = 0; plot.legend && i < plot.series.size(); ++i) {
    const double at_x = left + double(i % 2) * (right - left) / 2, at_y = bottom + 48 + 16 * double(i / 2);
    absl::StrAppend(&svg, "<path d=\"M", Number(at_x), ",", Number(at_y - 4), "h18\" stroke=\"",
                    plot.series[i].color, "\" stroke-width=\"2.4\"/>\n");
    svg += Text(at_x + 24, at_y, "start", 11, XmlEscape(plot.series[i].label));
  }
  return svg + "</svg>\n";
}

std::string RenderBars(const BarChart& chart) {
  const double left = 190, right = chart.width - 150.0, row = 24, top = 60;
  const int height = int(top + row * double(chart.bars.size()) + 16);
  double most = 0;
  for (const auto& bar : chart.bars) {
    double sum = 0;
    for (const double part : bar.parts) sum += part;
    most = std::max(most, sum);
  }
  if (!(most > 0)) most = 1;
  std::string svg = Open(chart.width, height, chart.title);
  svg += Text(14, 19, "start", 13, XmlEscape(chart.title), "font-weight=\"600\"");
  double at = 14;
  for (size_t i = 0; i < chart.part_labels.size(); ++i) {
    absl::StrAppend(&svg, "<rect x=\"", Number(at), "\" y=\"31\" width=\"12\" height=\"12\" fill=\"",
                    PlotColors()[i % PlotColors().size()], "\"/>\n");
    svg += Text(at + 17, 41, "start", 11, XmlEscape(chart.part_labels[i]));
    at += 34 + 6.4 * double(chart.part_labels[i].size());
  }
  for (size_t i = 0; i < chart.bars.size(); ++i) {
    const auto& bar = chart.bars[i];
    const double y = top + row * double(i);
    svg += Text(left - 8, y + 13, "end", 11, XmlEscape(bar.label));
    double from = left, sum = 0;
    for (size_t k = 0; k < bar.parts.size(); ++k) {
      const double width = bar.parts[k] / most * (right - left);
      absl::StrAppend(&svg, "<rect x=\"", Number(from), "\" y=\"", Number(y), "\" width=\"", Number(width),
                      "\" height=\"17\" fill=\"", PlotColors()[k % PlotColors().size()], "\"/>\n");
      from += width;
      sum += bar.parts[k];
    }
    const std::string note = bar.note.empty() ? absl::StrFormat("%.3g %s", sum, chart.unit) : bar.note;
    svg += Text(from + 6, y + 13, "start", 11, XmlEscape(note), "fill=\"#555555\"");
  }
  return svg + "</svg>\n";
}

}  // namespace shutterline::bench
