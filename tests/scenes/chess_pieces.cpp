#include "tests/scenes/chess_pieces.h"

#include <cmath>
#include <functional>

#include "common/base/check.h"
#include "tests/scenes/shapes.h"
#include "tests/scenes/texcoords.h"

namespace shutterline::scenes {
namespace {

constexpr int kColumns = 20;
constexpr double kPicture = 1.25;  // Of a picture on a piece, the side: once round a typical girth.

struct Ring {
  double radius, height;
};

/// The body of revolution of an outline from the foot up; `cut` moves its points, by angle.
void AddTurned(Primitive& piece, const std::vector<Ring>& outline,
               const std::function<Ring(size_t ring, double u)>& cut = nullptr) {
  const int rows = int(outline.size()) - 1;
  AddSurface(piece, kColumns, rows, [&](double u, double v) {
    const size_t ring = size_t(std::lround(v * rows));
    const Ring r = cut ? cut(ring, u) : outline[ring];
    const double angle = -2 * M_PI * u;
    return V3f(float(r.radius * std::cos(angle)), float(r.height), float(r.radius * std::sin(angle)));
  });
  // Texture coordinates: once round, and up by the outline's length.
  std::vector<double> length = {0};
  for (size_t i = 1; i < outline.size(); ++i) {
    const double out = outline[i].radius - outline[i - 1].radius;
    const double up = outline[i].height - outline[i - 1].height;
    length.push_back(length.back() + std::sqrt(out * out + up * up));
  }
  MapSurface(piece, kColumns, rows, [&](double u, double v) {
    return V2f(float(u), float(-length[size_t(std::lround(v * rows))] / kPicture));
  });
}

/// The foot that all pieces have, `s` times that of a pawn.
std::vector<Ring> Foot(double s) {
  return {{0, 0},
          {.36 * s, 0},
          {.37 * s, .05 * s},
          {.34 * s, .1 * s},
          {.3 * s, .12 * s},
          {.28 * s, .18 * s},
          {.22 * s, .24 * s}};
}

/// A ball's outline from `neck` (its lower ring's radius) to the top.
void AddBall(std::vector<Ring>& outline, double centre, double radius, double neck, int rows) {
  const double first = -std::acos(neck / radius);
  for (int i = 0; i <= rows; ++i) {
    const double latitude = first + (M_PI / 2 - first) * i / rows;
    outline.push_back({radius * std::cos(latitude), centre + radius * std::sin(latitude)});
  }
}

void AddPawn(Primitive& piece) {
  std::vector<Ring> outline = Foot(0.9);
  for (const Ring& r : {Ring{.13, .36}, {.11, .5}, {.19, .53}, {.19, .56}}) outline.push_back(r);
  AddBall(outline, 0.68, 0.16, 0.1, 6);
  AddTurned(piece, outline);
}

void AddRook(Primitive& piece) {
  std::vector<Ring> outline = Foot(1);
  for (const Ring& r : {Ring{.18, .4},
                        {.17, .62},
                        {.2, .68},
                        {.27, .7},
                        {.27, .76},
                        {.27, .9},
                        {.2, .9},
                        {.2, .78},
                        {0, .78}}) {
    outline.push_back(r);
  }
  const size_t rim = Foot(1).size() + 5;  // Its outer and inner edge are cut down between the merlons.
  AddTurned(piece, outline, [&](size_t ring, double u) {
    Ring r = outline[ring];
    if ((ring == rim || ring == rim + 1) && int(std::floor(u * kColumns / 2 + 1e-6)) % 2 == 1) r.height = .8;
    return r;
  });
}

void AddBishop(Primitive& piece) {
  std::vector<Ring> outline = Foot(1);
  for (const Ring& r : {Ring{.15, .45},
                        {.12, .68},
                        {.22, .72},
                        {.21, .76},
                        {.13, .79},
                        {.19, .88},
                        {.2, .95},
                        {.17, 1.05},
                        {.11, 1.14},
                        {.05, 1.2}}) {
    outline.push_back(r);
  }
  AddBall(outline, 1.24, 0.055, 0.04, 4);
  AddTurned(piece, outline);
}

void AddQueen(Primitive& piece) {
  std::vector<Ring> outline = Foot(1.1);
  for (const Ring& r :
       {Ring{.17, .5}, {.13, .86}, {.24, .9}, {.23, .94}, {.15, .98}, {.18, 1.1}, {.26, 1.26}, {.21, 1.24}}) {
    outline.push_back(r);
  }
  const size_t rim = Foot(1.1).size() + 6;
  AddBall(outline, 1.3, 0.1, 0.08, 5);
  AddTurned(piece, outline, [&](size_t ring, double u) {
    Ring r = outline[ring];
    if (ring == rim) r.height += 0.045 * std::cos(2 * M_PI * 8 * u);
    return r;
  });
}

void AddKing(Primitive& piece) {
  std::vector<Ring> outline = Foot(1.1);
  for (const Ring& r : {Ring{.17, .5},
                        {.14, .9},
                        {.25, .94},
                        {.24, .98},
                        {.16, 1.02},
                        {.19, 1.16},
                        {.25, 1.3},
                        {.24, 1.34},
                        {.1, 1.4},
                        {0, 1.41}}) {
    outline.push_back(r);
  }
  AddTurned(piece, outline);
  AddBox(piece, V3f(-0.03f, 1.38f, -0.03f), V3f(0.03f, 1.62f, 0.03f));
  AddBox(piece, V3f(-0.1f, 1.48f, -0.028f), V3f(0.1f, 1.54f, 0.028f));
  MapByFacing(piece, float(1 / kPicture));
}

/// A neck and head swept along a bent spine, with two ears.
void AddKnight(Primitive& piece) {
  std::vector<Ring> outline = Foot(1);
  outline.push_back({0, .26});
  AddTurned(piece, outline);
  struct Section {
    double z, y, across, along, lean;  // Its half axes; `lean` is its plane's tilt forward, radians.
  };
  const Section sections[] = {
      {-.02, .2, .19, .22, 0},      {-.06, .36, .16, .22, .1},  {-.09, .52, .13, .2, .15},
      {-.08, .68, .12, .18, .25},   {-.03, .84, .12, .18, .55}, {.06, .93, .115, .17, 1.1},
      {.16, .92, .1, .14, 1.7},     {.25, .85, .085, .11, 2.0}, {.32, .78, .075, .09, 2.1},
      {.355, .735, .04, .05, 2.15}, {.36, .73, 0, 0, 2.15}};
  const int rows = int(std::size(sections)) - 1;
  AddSurface(piece, kColumns, 2 * rows, [&](double u, double v) {
    const double place = v * rows;
    const size_t k = std::min(size_t(place), size_t(rows) - 1);
    const double s = place - double(k);
    const auto mix = [&](double Section::*field) {
      return sections[k].*field * (1 - s) + sections[k + 1].*field * s;
    };
    const double angle = -2 * M_PI * u, lean = mix(&Section::lean);
    const double along = mix(&Section::along) * std::sin(angle);
    return V3f(float(mix(&Section::across) * std::cos(angle)),
               float(mix(&Section::y) - along * std::sin(lean)),
               float(mix(&Section::z) + along * std::cos(lean)));
  });
  MapSurface(piece, kColumns, 2 * rows, [&](double u, double v) { return V2f(float(u), float(-v)); });
  for (const float side : {-0.06f, 0.06f}) {
    AddTube(piece, V3f(side, 0.98f, -0.02f), V3f(side * 1.3f, 1.14f, 0.0f), 0.045f, 0.004f, 8);
    MapSurface(piece, 8, 1, [](double u, double v) { return V2f(float(0.2 * u), float(-0.15 * v)); });
  }
}

}  // namespace

Primitive MakeChessPiece(char kind) {
  Primitive piece;
  switch (kind) {
    case 'P':
      AddPawn(piece);
      break;
    case 'R':
      AddRook(piece);
      break;
    case 'N':
      AddKnight(piece);
      break;
    case 'B':
      AddBishop(piece);
      break;
    case 'Q':
      AddQueen(piece);
      break;
    default:
      SL_CHECK(kind == 'K');
      AddKing(piece);
  }
  return piece;
}

}  // namespace shutterline::scenes
