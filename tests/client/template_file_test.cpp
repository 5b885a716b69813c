#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "client/command_line.h"
#include "client/options.h"
#include "tests/client/temp_folder.h"

namespace shutterline::client::template_file_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Has a job's options and keeps what they became.
class Keeper : public Command {
 public:
  explicit Keeper(JobOptions& kept) : kept_(kept) {}
  void Declare(CLI::App& app) override {
    AddJobOptions(app, options_);
    AddQuietOption(app, quiet_);
  }
  absl::Status Check() override { return CheckJobOptions(options_); }
  absl::StatusOr<ExitCode> Run(Console&) override {
    kept_ = options_;
    return ExitCode::kSuccess;
  }

 private:
  JobOptions& kept_;
  JobOptions options_;
  bool quiet_ = false;
};

class TemplateFileTest : public testing::Test {
 protected:
  int Tell(const std::string& text, std::vector<std::string> more = {}) {
    folder_.Write("t.conf", text);
    return TellOf(folder_.File("t.conf"), std::move(more));
  }
  int TellOf(const std::string& path, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"keep", "s.glb", "--template", path};
    words.insert(words.end(), more.begin(), more.end());
    std::ostringstream out, err;
    Console console{out, err};
    const int code = RunCommandLine(
        words, {{"keep", "Keeps", "Keep", [this] { return std::make_unique<Keeper>(kept_); }}}, console);
    errors_ = err.str();
    return code;
  }

  TempFolder folder_;
  JobOptions kept_;
  std::string errors_;
};

TEST_F(TemplateFileTest, OptionsOfAFileAreOptionsOfTheJob) {
  ASSERT_EQ(Tell("# dailies\noutput = fox.####.exr\n\n  size = 320x200\nfps=25\ncamera = \"left eye\"\naov = "
                 "depth,normal\n"
                 "cryptomatte=object,material\nfloat = true\npng = false\n"),
            0)
      << errors_;
  EXPECT_EQ(kept_.settings.width, 320);
  EXPECT_EQ(kept_.settings.height, 200);
  EXPECT_EQ(kept_.settings.fps, 25);
  EXPECT_EQ(kept_.settings.camera, "left eye");
  EXPECT_EQ(kept_.settings.aovs.size(), 2u);
  EXPECT_EQ(kept_.settings.mattes.size(), 2u);
  EXPECT_EQ(kept_.output_settings.pixel_type, PixelType::kFloat);
  EXPECT_FALSE(kept_.png);
  EXPECT_EQ(kept_.output->FrameFile(7, 9), "fox.0007.exr");
}

TEST_F(TemplateFileTest, TheCommandLineHasTheLastWord) {
  ASSERT_EQ(
      Tell("size = 320x200\nfps = 25\noutput = a.exr\n", {"--size", "64x32", "-o", "b.exr", "--fps=30"}), 0)
      << errors_;
  EXPECT_EQ(kept_.settings.width, 64);
  EXPECT_EQ(kept_.settings.fps, 30);
  EXPECT_EQ(kept_.output->FrameFile(1, 1), "b.exr");
}

TEST_F(TemplateFileTest, WhatTheCommandLineExcludesGivesWay) {
  // --frame and --frames cannot stand together: the one that was typed counts.
  ASSERT_EQ(Tell("frame = 7\nhalf = true\n", {"--frames", "1-9x2", "--float"}), 0) << errors_;
  EXPECT_EQ(kept_.frames.Count(), 5);
  EXPECT_EQ(kept_.output_settings.pixel_type, PixelType::kFloat);
}

TEST_F(TemplateFileTest, ContradictionsWithinAFileAreErrors) {
  EXPECT_EQ(Tell("frame = 7\nframes = 1-9\n"), 2);
  EXPECT_EQ(Tell("fps = 24\nsize = 8x8\nfps = 25\n"), 2);
  EXPECT_THAT(errors_, AllOf(HasSubstr("t.conf"), HasSubstr("'fps' is there twice")));
}

TEST_F(TemplateFileTest, ErrorsNameFileAndOption) {
  EXPECT_EQ(Tell("sise = 8x8\n"), 2);
  EXPECT_THAT(errors_, AllOf(HasSubstr("t.conf"), HasSubstr("'sise' is no option"), HasSubstr("'keep'")));
  EXPECT_EQ(Tell("size = big\n"), 2);
  EXPECT_THAT(errors_, AllOf(HasSubstr("--size"), HasSubstr("'big'")));
  EXPECT_EQ(Tell("float = 32\n"), 2);
  EXPECT_THAT(errors_, AllOf(HasSubstr("'float' is '32'"), HasSubstr("true or false")));
  EXPECT_EQ(Tell("[keep]\nsize = 8x8\n"), 2);
  EXPECT_THAT(errors_, HasSubstr("line 1: must be NAME = VALUE"));
  EXPECT_EQ(Tell("template = other.conf\n"), 2);
  EXPECT_EQ(Tell("help = true\n"), 2);
  EXPECT_EQ(TellOf(folder_.File("missing.conf")), 2);
  EXPECT_THAT(errors_, AllOf(HasSubstr("missing.conf"), HasSubstr("cannot be read")));
  EXPECT_EQ(TellOf(folder_.File("")), 2);  // A folder.
}

TEST_F(TemplateFileTest, HostileFilesAreRefused) {
  EXPECT_EQ(Tell(std::string("size = 8x8\n\0fps = 1\n", 19)), 2);
  EXPECT_THAT(errors_, HasSubstr("is no text"));
  EXPECT_EQ(Tell(std::string(100'000, 'a')), 2);
  EXPECT_THAT(errors_, HasSubstr("has more than"));
  for (const char* text : {"=\n", "===\n", "[\n", "]\n", "\"\n", "size = [8x8\n", "size = \"8x8\n",
                           "--size = 8x8\n", "'''\n", "a.b = 1\n", "[a.b]\n[]\n", "[[x]]\n"}) {
    EXPECT_EQ(Tell(text), 2) << text;
  }
  EXPECT_EQ(Tell(""), 0) << errors_;
}

}  // namespace
}  // namespace shutterline::client::template_file_test
