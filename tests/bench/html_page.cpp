#include "tests/bench/html_page.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

#include "common/base/atomic_file.h"
#include "tests/bench/svg_plot.h"

namespace shutterline::bench {
namespace {

constexpr const char* kStyle = R"(
  :root { color-scheme: light; }
  body { font: 16px/1.55 Georgia, 'Times New Roman', serif; color: #1d1d1f; background: #fff;
         max-width: 1080px; margin: 3rem auto 5rem; padding: 0 1.5rem; }
  h1 { font-size: 2rem; line-height: 1.2; margin: 0 0 1rem; }
  h2 { font-size: 1.3rem; margin: 2.6rem 0 .6rem; padding-bottom: .2rem; border-bottom: 1px solid #ddd; }
  p { max-width: 46rem; }
  figure { margin: 1.4rem 0 2rem; }
  .row { display: flex; flex-wrap: wrap; gap: 12px 20px; }
  .row svg { max-width: 100%; height: auto; }
  figcaption, caption { font-size: .87rem; color: #555; text-align: left; padding: .5rem 0 0; max-width: 52rem; }
  caption { caption-side: bottom; }
  table { border-collapse: collapse; font: 13.5px/1.45 'Helvetica Neue', Helvetica, Arial, sans-serif;
          margin: 1rem 0 2rem; font-variant-numeric: tabular-nums; }
  th, td { padding: .28rem .6rem; text-align: right; white-space: nowrap; }
  th:first-child, td:first-child { text-align: left; padding-left: 0; }
  thead th { border-top: 2px solid #222; border-bottom: 1px solid #222; font-weight: 600; }
  tbody tr:last-child td { border-bottom: 2px solid #222; }
  tr.sum td { border-top: 1px solid #222; font-weight: 600; }
  .scroll { overflow-x: auto; }
  .pictures { display: flex; flex-wrap: wrap; gap: 16px; }
  .pictures img { image-rendering: pixelated; display: block; }
  .pictures div { font: 13px/1.4 'Helvetica Neue', Helvetica, Arial, sans-serif; color: #444; }
)";

}  // namespace

std::string Base64(const std::string& bytes) {
  return absl::Base64Escape(bytes);
}

void HtmlPage::Heading(const std::string& text) {
  absl::StrAppend(&body_, "<h2>", XmlEscape(text), "</h2>\n");
}

void HtmlPage::Paragraph(const std::string& text) {
  absl::StrAppend(&body_, "<p>", XmlEscape(text), "</p>\n");
}

void HtmlPage::Figures(const std::vector<std::string>& svgs, const std::string& caption) {
  body_ += "<figure><div class=\"row\">\n";
  for (const std::string& svg : svgs) body_ += svg;
  absl::StrAppend(&body_, "</div><figcaption>", XmlEscape(caption), "</figcaption></figure>\n");
}

void HtmlPage::Table(const std::vector<std::string>& columns,
                     const std::vector<std::vector<std::string>>& rows, const std::string& caption) {
  absl::StrAppend(&body_, "<div class=\"scroll\"><table><caption>", XmlEscape(caption),
                  "</caption><thead><tr>");
  for (const std::string& column : columns) absl::StrAppend(&body_, "<th>", XmlEscape(column), "</th>");
  body_ += "</tr></thead><tbody>\n";
  for (const auto& row : rows) {
    const bool sum = !row.empty() && !row[0].empty() && row[0][0] == '=';
    body_ += sum ? "<tr class=\"sum\">" : "<tr>";
    for (size_t i = 0; i < row.size(); ++i) {
      absl::StrAppend(&body_, "<td>", XmlEscape(sum && i == 0 ? row[i].substr(1) : row[i]), "</td>");
    }
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
}

void HtmlPage::Pictures(const std::vector<Picture>& pictures, int zoom, const std::string& caption) {
  body_ += "<figure><div class=\"pictures\">\n";
  for (const Picture& picture : pictures) {
    absl::StrAppend(&body_, "<div><img alt=\"", XmlEscape(picture.label), "\" width=\"", zoom * picture.width,
                    "\" height=\"", zoom * picture.height, "\" src=\"data:image/png;base64,",
                    Base64(picture.png), "\"/>", XmlEscape(picture.label), "</div>\n");
  }
  absl::StrAppend(&body_, "</div><figcaption>", XmlEscape(caption), "</figcaption></figure>\n");
}

std::string HtmlPage::ToString() const {
  return absl::StrCat("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>",
                      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/><title>",
                      XmlEscape(title_), "</title><style>", kStyle, "</style></head><body>\n<h1>",
                      XmlEscape(title_), "</h1>\n", body_, "</body></html>\n");
}

absl::Status HtmlPage::Write(const std::string& path) const {
  return WriteFileAtomically(path, ToString());
}

}  // namespace shutterline::bench
