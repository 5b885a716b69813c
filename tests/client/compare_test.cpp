#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "common/image/exr.h"
#include "tests/client/temp_folder.h"

namespace shutterline::client::compare_test {
namespace {

struct Outcome {
  int code = -1;
  std::string text;  ///< Standard output and standard error together.
};

/// Runs the program itself, as a user does.
Outcome RunShutterline(const std::string& arguments) {
  const std::string command =
      std::string(SHUTTERLINE_BINARY_DIR) + "/bin/shutterline " + arguments + " 2>&1 </dev/null";
  Outcome outcome;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return outcome;
  std::array<char, 4096> buffer;
  for (size_t got; (got = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    outcome.text.append(buffer.data(), got);
  }
  const int status = pclose(pipe);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

/// A picture of one colour, in 32-bit floats.
void WriteFlat(const TempFolder& folder, const std::string& name, int width, int height, float value,
               float spot = 0) {
  Image image(width, height);
  for (float& v : image.values()) v = value;
  if (spot != 0) image.At(5, 3)[1] += spot;
  OutputSettings output;
  output.pixel_type = PixelType::kFloat;
  const absl::Status status = WriteExr(folder.File(name), image, output, {});
  ASSERT_TRUE(status.ok()) << status;
}

TEST(CompareProgram, ClosedForms) {
  TempFolder folder;
  WriteFlat(folder, "a.exr", 40, 35, 0.75f);
  WriteFlat(folder, "b.exr", 40, 35, 0.5f);
  const Outcome outcome =
      RunShutterline("compare --json " + folder.File("a.exr") + " " + folder.File("b.exr"));
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  const auto json = nlohmann::json::parse(outcome.text);
  EXPECT_DOUBLE_EQ(json["rmse"], 0.25);
  EXPECT_NEAR(json["psnr_db"], 20 * std::log10(4.0), 1e-12);
  EXPECT_NEAR(json["relative_mse"], 0.0625 / (0.51 * 0.51), 1e-8);
  EXPECT_DOUBLE_EQ(json["largest_difference"]["value"], 0.25);
  EXPECT_EQ(json["width"], 40);
  EXPECT_EQ(json["height"], 35);
}

TEST(CompareProgram, FindsTheLargestDifference) {
  TempFolder folder;
  WriteFlat(folder, "a.exr", 40, 35, 0.5f, 0.25f);
  WriteFlat(folder, "b.exr", 40, 35, 0.5f);
  const Outcome json = RunShutterline("compare --json " + folder.File("a.exr") + " " + folder.File("b.exr"));
  ASSERT_EQ(json.code, 0) << json.text;
  const auto facts = nlohmann::json::parse(json.text);
  EXPECT_EQ(facts["largest_difference"]["x"], 5);
  EXPECT_EQ(facts["largest_difference"]["y"], 3);
  EXPECT_EQ(facts["largest_difference"]["channel"], "G");
  EXPECT_NEAR(facts["rmse"], 0.25 / std::sqrt(40 * 35 * 3.0), 1e-12);
  const Outcome text = RunShutterline("compare " + folder.File("a.exr") + " " + folder.File("b.exr"));
  EXPECT_NE(text.text.find("0.25 at pixel (5, 3), channel G"), std::string::npos) << text.text;
}

TEST(CompareProgram, EqualPicturesHaveNoErrorAndInfinitePsnr) {
  TempFolder folder;
  WriteFlat(folder, "a.exr", 8, 8, 0.5f);
  const std::string both = folder.File("a.exr") + " " + folder.File("a.exr");
  const auto json = nlohmann::json::parse(RunShutterline("compare --json " + both).text);
  EXPECT_EQ(json["rmse"], 0.0);
  EXPECT_TRUE(json["psnr_db"].is_null());
  EXPECT_NE(RunShutterline("compare " + both).text.find("infinite"), std::string::npos);
}

TEST(CompareProgram, RefusesDifferentSizesByName) {
  TempFolder folder;
  WriteFlat(folder, "small.exr", 8, 9, 0.5f);
  WriteFlat(folder, "large.exr", 16, 9, 0.5f);
  const Outcome outcome =
      RunShutterline("compare " + folder.File("small.exr") + " " + folder.File("large.exr"));
  EXPECT_EQ(outcome.code, 1);
  for (const char* part : {"shutterline: ", "small.exr is 8x9", "large.exr is 16x9"}) {
    EXPECT_NE(outcome.text.find(part), std::string::npos) << outcome.text;
  }
}

TEST(CompareProgram, RefusesWhatIsNotAPictureOrNotANumber) {
  TempFolder folder;
  WriteFlat(folder, "a.exr", 8, 8, 0.5f);
  WriteFlat(folder, "nan.exr", 8, 8, std::numeric_limits<float>::quiet_NaN());
  folder.Write("text.exr", "this is no picture");
  const std::string a = folder.File("a.exr");
  for (const char* other : {"nan.exr", "text.exr", "missing.exr"}) {
    const Outcome outcome = RunShutterline("compare " + a + " " + folder.File(other));
    EXPECT_EQ(outcome.code, 1) << other << ": " << outcome.text;
    EXPECT_EQ(outcome.text.rfind("shutterline: ", 0), 0u) << outcome.text;
  }
  EXPECT_EQ(RunShutterline("compare " + a).code, 2);
  EXPECT_EQ(RunShutterline("compare " + a + " " + a + " --diff " + folder.File("d.exr")).code, 2);
}

TEST(CompareProgram, UnbiasedErrorCancelsTheReferencesNoise) {
  // T = 0.5; the halves are 0.5 ± 0.25 with opposite signs in a chequer that is independent of one
  // another: their products with the error average to zero.
  TempFolder folder;
  Image half_a(32, 32), half_b(32, 32);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      for (int c = 0; c < 4; ++c) {
        half_a.At(x, y)[c] = 0.5f + (x % 2 == 0 ? 0.25f : -0.25f);
        half_b.At(x, y)[c] = 0.5f + (y % 2 == 0 ? 0.25f : -0.25f);
      }
    }
  }
  OutputSettings output;
  output.pixel_type = PixelType::kFloat;
  ASSERT_TRUE(WriteExr(folder.File("a.exr"), half_a, output, {}).ok());
  ASSERT_TRUE(WriteExr(folder.File("b.exr"), half_b, output, {}).ok());
  WriteFlat(folder, "t.exr", 32, 32, 0.5f);
  WriteFlat(folder, "off.exr", 32, 32, 0.625f);
  const std::string halves = folder.File("a.exr") + " --reference-b " + folder.File("b.exr") + " --json ";
  const auto exact =
      nlohmann::json::parse(RunShutterline("compare " + folder.File("t.exr") + " " + halves).text);
  EXPECT_NEAR(exact["unbiased"]["d"], 0, 1e-12);
  EXPECT_NEAR(exact["rmse"], 0.25, 1e-12) << "the plain error is all noise";
  const auto off =
      nlohmann::json::parse(RunShutterline("compare " + folder.File("off.exr") + " " + halves).text);
  EXPECT_NEAR(off["unbiased"]["d"], 0.125 * 0.125, 1e-9);
  EXPECT_NEAR(off["unbiased"]["rmse"], 0.125, 1e-8);
}

TEST(CompareProgram, WritesADifferencePicture) {
  TempFolder folder;
  WriteFlat(folder, "a.exr", 40, 35, 0.5f, 0.25f);
  WriteFlat(folder, "b.exr", 40, 35, 0.5f);
  const Outcome outcome = RunShutterline("compare " + folder.File("a.exr") + " " + folder.File("b.exr") +
                                         " --diff " + folder.File("d.png"));
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_EQ(folder.Read("d.png").substr(0, 4), "\x89PNG");
}

}  // namespace
}  // namespace shutterline::client::compare_test
