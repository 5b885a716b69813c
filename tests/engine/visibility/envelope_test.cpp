#include "worker/engine/visibility/envelope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "worker/engine/visibility/front_to_back.h"

namespace shutterline::engine {
namespace {

constexpr int32_t kPixel = kSubpixelsPerPixel;

/// A segment from pixel positions and the depths there.
LineSegment Make(uint32_t id, double from, double to, double d_from, double d_to) {
  LineSegment s;
  s.begin = int32_t(std::lround(from * kPixel));
  s.end = int32_t(std::lround(to * kPixel));
  s.id = id;
  s.index = id;
  s.l0 = from;
  s.l1 = to;
  s.d0 = d_from;
  s.d1 = d_to;
  s.slope = (d_to - d_from) / (to - from);
  return s;
}

std::vector<VisibleSpan> March(const std::vector<LineSegment>& segments, int pixels = 32) {
  EnvelopeMarcher marcher;
  std::vector<VisibleSpan> spans;
  marcher.March(segments, 0, pixels * kPixel, spans);
  return spans;
}

std::vector<LineSegment> RandomSegments(std::mt19937_64& random, int count) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<LineSegment> segments;
  while (int(segments.size()) < count) {
    double a = 32 * unit(random);
    double b = unit(random) < 0.3 ? a + 0.5 * unit(random) : 32 * unit(random);
    if (a > b) std::swap(a, b);
    b = std::min(b, 32.0);
    if (b - a < 1e-3) continue;
    // A third are level and some share depths, so that ties occur.
    const double d0 = std::floor(unit(random) * 8) / 8;
    const double d1 = unit(random) < 0.4 ? d0 : unit(random);
    segments.push_back(Make(uint32_t(segments.size()), a, b, d0, d1));
  }
  return segments;
}

TEST(Envelope, NothingShowsNothing) {
  EXPECT_TRUE(March({}).empty());
}

TEST(Envelope, CrossingSegmentsAreCutWhereTheyCross) {
  const auto spans = March({Make(0, 0, 32, 0.2, 0.8), Make(1, 0, 32, 0.8, 0.2)});
  ASSERT_EQ(spans.size(), 2u);
  EXPECT_EQ(spans[0].segment, 1u);
  EXPECT_NEAR(spans[0].end, 16.0 * kPixel, 1);
  EXPECT_EQ(spans[1].segment, 0u);
  EXPECT_EQ(spans[1].end, 32 * kPixel);
}

TEST(Envelope, ANearerOneInterruptsAFartherOne) {
  const auto spans = March({Make(0, 2, 30, 0.3, 0.3), Make(1, 10, 12, 0.5, 0.5)});
  ASSERT_EQ(spans.size(), 3u);
  EXPECT_EQ(spans[0].begin, 2 * kPixel);
  EXPECT_EQ(spans[0].end, 10 * kPixel);
  EXPECT_EQ(spans[1].segment, 1u);
  EXPECT_EQ(spans[2].begin, 12 * kPixel);
  EXPECT_EQ(spans[2].segment, 0u);
}

TEST(Envelope, EqualDepthsShowTheLowerId) {
  for (const bool swapped : {false, true}) {
    std::vector<LineSegment> segments{Make(4, 1, 31, 0.3, 0.7), Make(9, 1, 31, 0.3, 0.7)};
    if (swapped) std::swap(segments[0], segments[1]);
    const auto spans = March(segments);
    ASSERT_EQ(spans.size(), 1u);
    EXPECT_EQ(segments[spans[0].segment].id, 4u);
  }
}

TEST(Envelope, AFoldShowsTheFasterRisingSide) {
  // Both start at one shared point and depart from it.
  const auto spans = March({Make(0, 5, 20, 0.5, 0.4), Make(1, 5, 20, 0.5, 0.6)});
  ASSERT_EQ(spans.size(), 1u);
  EXPECT_EQ(spans[0].segment, 1u);
}

TEST(Envelope, TwoOvertakesWithinOneSubpixelShowTheNearer) {
  // A falls steeply through B and C, which lie close together: both overtake it at the same subpixel.
  for (const int length : {4, 20, 100, 1000}) {
    const double from = 8 + 3.0 / kPixel;
    const std::vector<LineSegment> segments{Make(7, from, from + double(length) / kPixel, 0.9, 0.1),
                                            Make(2, 0, 32, 0.4997, 0.4997), Make(1, 0, 32, 0.499, 0.499)};
    const auto spans = March(segments);
    ASSERT_FALSE(spans.empty());
    EXPECT_EQ(segments[spans.back().segment].id, 2u) << length;
    EXPECT_EQ(spans.back().end, 32 * kPixel);
    for (const VisibleSpan& span : spans) EXPECT_NE(segments[span.segment].id, 1u) << length;
  }
}

TEST(Envelope, AStartWithinTheSubpixelOfAnOvertakeShowsTheNearer) {
  // A falls steeply through C, then through B, which starts where C has already come in front.
  const double subpixel = 1.0 / kPixel;
  const std::vector<LineSegment> segments{Make(7, 0, 2 * subpixel, 0.958, 0.289),
                                          Make(3, subpixel, 32, 0.5, 0.51), Make(4, 0, 32, 0.5638, 0.5638)};
  const auto spans = March(segments);
  ASSERT_FALSE(spans.empty());
  EXPECT_EQ(segments[spans.back().segment].id, 4u);
  for (const VisibleSpan& span : spans) EXPECT_NE(segments[span.segment].id, 3u);
}

/// The nearest segment at a subpixel, by looking at all of them.
std::optional<uint32_t> NearestByBruteForce(const std::vector<LineSegment>& segments, int32_t at,
                                            double* lead) {
  std::optional<uint32_t> nearest;
  *lead = 1;
  const double l = (at + 0.5) / kPixel;
  for (uint32_t i = 0; i < segments.size(); ++i) {
    if (at < segments[i].begin || at >= segments[i].end) continue;
    if (!nearest || IsNearer(segments[i], segments[*nearest], at)) nearest = i;
  }
  for (uint32_t i = 0; nearest && i < segments.size(); ++i) {
    if (i == *nearest || at < segments[i].begin || at >= segments[i].end) continue;
    *lead = std::min(*lead, segments[*nearest].DepthAt(l) - segments[i].DepthAt(l));
  }
  return nearest;
}

TEST(Envelope, AgreesWithBruteForceAtRandomPlaces) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const auto segments = RandomSegments(random, int(1 + random() % 60));
    const auto spans = March(segments);
    for (int i = 0; i < 500; ++i) {
      const auto at = int32_t(random() % uint64_t(32 * int64_t{kPixel}));
      double lead = 0;
      const auto expected = NearestByBruteForce(segments, at, &lead);
      const auto span = std::find_if(spans.begin(), spans.end(),
                                     [&](const VisibleSpan& s) { return s.begin <= at && at < s.end; });
      ASSERT_EQ(expected.has_value(), span != spans.end()) << "at " << at;
      // Within rounding of a crossing either side is right.
      if (expected && lead > 1e-7) {
        EXPECT_EQ(span->segment, *expected) << "at " << at;
      }
    }
  }
}

TEST(Envelope, SpansAreDisjointAscendingAndWithinTheirSegments) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const auto segments = RandomSegments(random, 50);
    int32_t last = 0;
    for (const VisibleSpan& span : March(segments)) {
      EXPECT_GE(span.begin, last);
      EXPECT_LT(span.begin, span.end);
      EXPECT_GE(span.begin, segments[span.segment].begin);
      EXPECT_LE(span.end, segments[span.segment].end);
      last = span.end;
    }
  }
}

TEST(Envelope, OrderOfSegmentsDoesNotMatter) {
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    auto segments = RandomSegments(random, 60);
    const auto spans = March(segments);
    auto shuffled = segments;
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    const auto again = March(shuffled);
    ASSERT_EQ(spans.size(), again.size());
    for (size_t i = 0; i < spans.size(); ++i) {
      EXPECT_EQ(spans[i].begin, again[i].begin);
      EXPECT_EQ(spans[i].end, again[i].end);
      EXPECT_EQ(segments[spans[i].segment].id, shuffled[again[i].segment].id);
    }
  }
}

TEST(Envelope, NearlyCoplanarSegmentsEndInFewSpans) {
  // Hundreds of segments that differ by rounding errors must not make the march creep.
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> noise(-1e-16, 1e-16);
  std::vector<LineSegment> segments;
  for (uint32_t i = 0; i < 300; ++i)
    segments.push_back(Make(i, 0, 32, 0.4 + noise(random), 0.6 + noise(random)));
  const auto spans = March(segments);
  EXPECT_LE(spans.size(), segments.size());
  EXPECT_EQ(spans.front().begin, 0);
  EXPECT_EQ(spans.back().end, 32 * kPixel);
}

TEST(FrontToBack, IsTheEnvelopeWhateverTheBatches) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    auto segments = RandomSegments(random, 500);
    // A wall of small pieces, none of which covers the line alone.
    for (int i = 0; i < 64; ++i)
      segments.push_back(Make(uint32_t(500 + i), i / 2.0, (i + 1) / 2.0, 0.9, 0.95));
    std::sort(segments.begin(), segments.end(), [](const LineSegment& a, const LineSegment& b) {
      return std::max(a.d0, a.d1) > std::max(b.d0, b.d1);
    });
    const auto expected = March(segments);
    FrontToBack envelope;
    envelope.Begin(0, 32 * kPixel);
    int offered = 0;
    for (const LineSegment& segment : segments) {
      if (!envelope.Wants(std::max(segment.d0, segment.d1))) break;
      envelope.Offer(segment, {});
      ++offered;
    }
    envelope.Finish();
    ASSERT_EQ(envelope.spans().size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(envelope.spans()[i].begin, expected[i].begin);
      EXPECT_EQ(envelope.spans()[i].end, expected[i].end);
      EXPECT_EQ(envelope.segments()[envelope.spans()[i].segment].id, segments[expected[i].segment].id);
    }
    EXPECT_LT(offered, 500) << "the wall in front was not noticed";
  }
}

}  // namespace
}  // namespace shutterline::engine
