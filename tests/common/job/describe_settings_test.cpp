#include "common/job/describe_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace shutterline {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(DescribeSettings, NamesWhatPlacesTheInstantsAndNothingThatIsNotUsed) {
  RenderSettings settings;
  EXPECT_THAT(DescribeSettings(settings), HasSubstr("pattern=auto resolver=slice time_step=2 target_error="));
  settings.pattern = PatternKind::k16h16v;
  settings.target_error.reset();
  EXPECT_THAT(DescribeSettings(settings), HasSubstr("pattern=16h16v resolver=slice time_step=2"));
  EXPECT_THAT(DescribeSettings(settings), Not(HasSubstr("target_error")));

  settings.target_error = 0.004;
  EXPECT_THAT(DescribeSettings(settings), HasSubstr(" time_step=2 target_error=0.004"));
  RenderSettings paper = settings;
  paper.resolver = ResolverKind::kPaper;
  EXPECT_THAT(DescribeSettings(paper), Not(HasSubstr("target_error")));
  RenderSettings reference = settings;
  reference.integrator = IntegratorKind::kReference;
  EXPECT_THAT(DescribeSettings(reference), Not(HasSubstr("target_error")));

  settings.target_error.reset();
  settings.time_samples = 7;
  EXPECT_THAT(DescribeSettings(settings), HasSubstr("time_samples=7"));
}

}  // namespace
}  // namespace shutterline
