#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

namespace shutterline::bench {

/// One HTML page, complete in itself: styles and figures inside, no scripts, nothing from elsewhere.
class HtmlPage {
 public:
  explicit HtmlPage(std::string title) : title_(std::move(title)) {}

  /// Plain text; it is escaped here.
  void Heading(const std::string& text);
  void Paragraph(const std::string& text);
  /// Figures side by side as space allows, under one caption. `svgs` are inserted as they are.
  void Figures(const std::vector<std::string>& svgs, const std::string& caption);
  /// The first column is text, the others are figures. `rows` that begin with "=" are set apart as sums.
  void Table(const std::vector<std::string>& columns, const std::vector<std::vector<std::string>>& rows,
             const std::string& caption);
  /// Pictures (PNG bytes), each enlarged `zoom` times without smoothing, with a label below.
  struct Picture {
    std::string png, label;
    int width = 0, height = 0;
  };
  void Pictures(const std::vector<Picture>& pictures, int zoom, const std::string& caption);

  std::string ToString() const;
  absl::Status Write(const std::string& path) const;

 private:
  std::string title_, body_;
};

std::string Base64(const std::string& bytes);

}  // namespace shutterline::bench
