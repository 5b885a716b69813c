#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/job/render_settings.h"

namespace shutterline::bench {

/// One setting of a method.
struct Rung {
  std::string label;
  std::function<void(RenderSettings&)> apply;
};

/// A method and its ladder, from cheap to dear.
struct Contender {
  std::string name;   ///< "line/slice"
  std::string color;  ///< Of its curves.
  bool ours = false;
  bool random = false;  ///< Draws random numbers: other seeds give other pictures.
  std::vector<Rung> ladder;
  int default_rung = -1;  ///< What a user who sets nothing gets; -1: none of them is.
};

/// Those that this build can render. `quick`: shorter ladders.
std::vector<Contender> AllContenders(bool quick);

}  // namespace shutterline::bench
