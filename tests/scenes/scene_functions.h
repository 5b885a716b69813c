#pragma once

#include "tests/scenes/glb_scene.h"
#include "tests/scenes/scene_generators.h"

/// One function a scene, each in its own file; for scene_generators.cpp. Options have been checked.
namespace shutterline::scenes {

GlbScene MakePlane(const SceneOptions& options);
GlbScene MakeFan(const SceneOptions& options);
GlbScene MakeDebris(const SceneOptions& options);
GlbScene MakeTrees(const SceneOptions& options);
GlbScene MakeStatic(const SceneOptions& options);
GlbScene MakeChess(const SceneOptions& options);
GlbScene MakeArmadillo(const SceneOptions& options);
GlbScene MakeClothBall(const SceneOptions& options);
GlbScene MakeHall(const SceneOptions& options);
GlbScene MakeDemo(const SceneOptions& options);

}  // namespace shutterline::scenes
