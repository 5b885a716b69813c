#include <absl/strings/str_format.h>

#include <cmath>
#include <optional>

#include "client/commands.h"
#include "client/difference_picture.h"
#include "client/human.h"
#include "client/json_output.h"
#include "client/options.h"
#include "common/base/status_macros.h"
#include "common/image/exr.h"
#include "common/image/metrics.h"
#include "common/image/png.h"

namespace shutterline::client {
namespace {

absl::Status StorePath(const std::string& text, std::string& path) {
  if (text.empty() || text.find('\0') != std::string::npos) {
    return absl::InvalidArgumentError("must be the path of a file");
  }
  path = text;
  return absl::OkStatus();
}

class CompareCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddValue(app, "A", "", "", "The picture under test, an EXR", [this](const std::string& text) {
      return StorePath(text, test_path_);
    })->required();
    AddValue(app, "B", "", "", "The reference, an EXR", [this](const std::string& text) {
      return StorePath(text, reference_path_);
    })->required();
    AddValue(app, "--reference-b", "B2.exr", "",
             "A second reference, independent of B: prints the mean\nsquared error without the references' "
             "noise",
             [this](const std::string& text) { return StorePath(text, second_path_); });
    AddValue(app, "--diff", "OUT.png", "",
             "Write a picture of |A - B| per channel, brightened so\nthat the largest difference is white",
             [this](const std::string& text) {
               if (!text.ends_with(".png") || text.front() == '-') {
                 return absl::InvalidArgumentError("must name a file that ends in .png");
               }
               return StorePath(text, diff_path_);
             });
    AddJsonOption(app, json_);
    AddExamples(
        app,
        {"shutterline compare test.exr reference.exr",
         "shutterline compare test.exr half_a.exr --reference-b half_b.exr --json"},
        "Values are linear, before any tone mapping, over R, G and B; the largest difference is over\n"
        "A too. PSNR has peak 1. Pictures of different size or with a NaN are refused (exit code 1).\n"
        "In JSON, psnr_db is null for equal pictures, whose PSNR is infinite.");
  }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    SL_ASSIGN_OR_RETURN(const Image test, Load(test_path_));
    SL_ASSIGN_OR_RETURN(const Image reference, Load(reference_path_));
    SL_RETURN_IF_ERROR(SameSize(test, test_path_, reference, reference_path_));
    const auto comparison = Compare(test, reference);
    if (!comparison.ok()) return Name(comparison.status());
    std::optional<UnbiasedError> unbiased;
    if (!second_path_.empty()) {
      SL_ASSIGN_OR_RETURN(const Image second, Load(second_path_));
      SL_RETURN_IF_ERROR(SameSize(test, test_path_, second, second_path_));
      const auto error = MeasureUnbiasedError(test, reference, second);
      if (!error.ok()) return Name(error.status());
      unbiased = *error;
    }
    if (!diff_path_.empty()) {
      SL_RETURN_IF_ERROR(WritePng(diff_path_, DifferencePicture(test, reference)));
    }
    if (json_) {
      PrintJson(*comparison, unbiased, test, console.out);
    } else {
      PrintText(*comparison, unbiased, console.out);
    }
    return ExitCode::kSuccess;
  }

 private:
  static absl::StatusOr<Image> Load(const std::string& path) {
    auto image = ReadExr(path);
    if (!image.ok()) return Annotate(image.status(), "compare");
    return image;
  }

  absl::Status Name(const absl::Status& status) const {
    return Annotate(status, absl::StrCat("compare ", test_path_, " with ", reference_path_));
  }

  static absl::Status SameSize(const Image& a, const std::string& a_path, const Image& b,
                               const std::string& b_path) {
    if (a.width() == b.width() && a.height() == b.height()) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrFormat("compare: %s is %dx%d pixels, but %s is %dx%d", a_path,
                                                      a.width(), a.height(), b_path, b.width(), b.height()));
  }

  static void PrintText(const Comparison& c, const std::optional<UnbiasedError>& unbiased,
                        std::ostream& out) {
    out << absl::StreamFormat("RMSE                %.9g\n", c.rmse);
    if (std::isfinite(c.psnr)) {
      out << absl::StreamFormat("PSNR                %.4f dB\n", c.psnr);
    } else {
      out << "PSNR                infinite (equal pictures)\n";
    }
    out << absl::StreamFormat("relative MSE        %.9g\n", c.relative_mse);
    out << absl::StreamFormat("largest difference  %.9g", c.largest_difference);
    if (c.largest_difference > 0) {
      out << absl::StreamFormat(" at pixel (%d, %d), channel %s", c.largest_x, c.largest_y,
                                Printable(c.largest_channel));
    }
    out << "\n";
    if (unbiased) out << "unbiased error      " << unbiased->ToString() << "\n";
  }

  static void PrintJson(const Comparison& c, const std::optional<UnbiasedError>& unbiased, const Image& image,
                        std::ostream& out) {
    Json json;
    json["width"] = image.width();
    json["height"] = image.height();
    json["rmse"] = c.rmse;
    json["psnr_db"] = std::isfinite(c.psnr) ? Json(c.psnr) : Json(nullptr);
    json["relative_mse"] = c.relative_mse;
    json["largest_difference"] = {{"value", c.largest_difference},
                                  {"x", c.largest_x},
                                  {"y", c.largest_y},
                                  {"channel", c.largest_channel}};
    if (unbiased) {
      json["unbiased"] = {{"d", unbiased->d},
                          {"standard_error", unbiased->standard_error},
                          {"below_floor", unbiased->BelowFloor()},
                          {"rmse", unbiased->BelowFloor() ? Json(nullptr) : Json(unbiased->Rmse())}};
    }
    Print(json, out);
  }

  std::string test_path_, reference_path_, second_path_, diff_path_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeCompareCommand() {
  return std::make_unique<CompareCommand>();
}

}  // namespace shutterline::client
