#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stack>

#include "tests/bench/csv.h"
#include "tests/bench/html_page.h"
#include "tests/bench/svg_plot.h"

namespace shutterline::bench {
namespace {

/// Whether every tag is closed in order, attributes are quoted and & and < stand for nothing else: enough of
/// XML for what these pages hold. Tells where not.
std::string WellFormed(const std::string& text) {
  std::stack<std::string> open;
  for (size_t i = 0; i < text.size();) {
    if (text[i] == '&') {
      const size_t end = text.find(';', i);
      const std::string name = text.substr(i, end == std::string::npos ? 0 : end - i + 1);
      if (name != "&amp;" && name != "&lt;" && name != "&gt;" && name != "&quot;") {
        return "a bare & at " + std::to_string(i);
      }
    }
    if (text[i] != '<') {
      ++i;
      continue;
    }
    size_t end = i + 1;
    bool quoted = false;
    for (; end < text.size() && (quoted || text[end] != '>'); ++end) {
      if (text[end] == '"') quoted = !quoted;
      if (text[end] == '<') return "< in a tag at " + std::to_string(end);
    }
    if (end == text.size()) return "a tag without an end at " + std::to_string(i);
    const std::string tag = text.substr(i + 1, end - i - 1);
    i = end + 1;
    if (tag[0] == '!') continue;
    if (tag[0] == '/') {
      if (open.empty() || open.top() != tag.substr(1)) return "unexpected <" + tag + ">";
      open.pop();
      continue;
    }
    if (tag.back() != '/') {
      const std::string name = tag.substr(0, tag.find(' '));
      if (name != "meta") open.push(name);
    }
  }
  return open.empty() ? "" : "<" + open.top() + "> is not closed";
}

Plot SomePlot() {
  Plot plot{.title = "a < b & \"c\"", .x = {"seconds", true}, .y = {"error", true}};
  plot.series.push_back({.label = "one <two>",
                         .color = "#123456",
                         .points = {{1, 0.1}, {10, 0.001}},
                         .line = {{1, 0.1}, {10, 0.001}},
                         .hollow = true,
                         .star = PlotPoint{1, 0.1}});
  plot.rules.push_back({0.005, "0.005"});
  return plot;
}

TEST(Svg, IsWellFormed) {
  EXPECT_EQ(WellFormed(RenderPlot(SomePlot())), "");
  Plot linear = SomePlot();
  linear.x.log = linear.y.log = false;
  EXPECT_EQ(WellFormed(RenderPlot(linear)), "");
  EXPECT_EQ(WellFormed(RenderPlot({.title = "", .x = {"x"}, .y = {"y"}})), "");
}

TEST(Svg, LeavesOutWhatCannotStand) {
  Plot plot = SomePlot();
  const double inf = std::numeric_limits<double>::infinity();
  plot.series[0].points = {{0, 1}, {1, 0}, {-1, 1}, {std::nan(""), 1}, {1, inf}, {2, 0.5}};
  plot.series[0].line = plot.series[0].points;
  plot.series[0].star.reset();
  const std::string svg = RenderPlot(plot);
  EXPECT_EQ(WellFormed(svg), "");
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  size_t circles = 0;
  for (size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1)) ++circles;
  EXPECT_EQ(circles, 1u);
}

TEST(Svg, BarsAreWellFormed) {
  BarChart chart{.title = "stages & more", .unit = "s", .part_labels = {"a", "b"}, .bars = {}};
  chart.bars.push_back({.label = "<scene>", .parts = {1, 2}, .note = ""});
  chart.bars.push_back({.label = "none", .parts = {0, 0}, .note = "nothing"});
  EXPECT_EQ(WellFormed(RenderBars(chart)), "");
}

TEST(Html, IsWellFormedAndNeedsNothingFromElsewhere) {
  HtmlPage page("Speed & error");
  page.Heading("<b>");
  page.Paragraph("1 < 2");
  page.Figures({RenderPlot(SomePlot())}, "caption & more");
  page.Table({"scene", "S(0.01)"}, {{"a&b", "> 3"}, {"=mean", "2"}}, "\"quoted\"");
  page.Pictures({{"png bytes", "label", 4, 4}}, 3, "pictures");
  const std::string html = page.ToString();
  EXPECT_EQ(WellFormed(html), "");
  for (const char* word : {"<script", "http://", "https://", "@import", "url("}) {
    size_t at = html.find(word);
    // The name of SVG's namespace is no address that anybody fetches.
    while (at != std::string::npos && html.compare(at, 26, "http://www.w3.org/2000/svg") == 0) {
      at = html.find(word, at + 1);
    }
    EXPECT_EQ(at, std::string::npos) << word;
  }
}

TEST(Html, Base64OfKnownBytes) {
  EXPECT_EQ(Base64("Man"), "TWFu");
  EXPECT_EQ(Base64("Ma"), "TWE=");
}

TEST(Csv, QuotesWhatNeedsIt) {
  CsvTable table({"a", "b"});
  table.AddRow({"1", "x,y"});
  table.AddRow({"say \"hi\"", "two\nlines"});
  EXPECT_EQ(table.ToString(), "a,b\n1,\"x,y\"\n\"say \"\"hi\"\"\",\"two\nlines\"\n");
  EXPECT_EQ(Cell(std::nan("")), "");
  EXPECT_EQ(Cell(int64_t{1} << 40), "1099511627776");
}

}  // namespace
}  // namespace shutterline::bench
