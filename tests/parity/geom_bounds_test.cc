#include "actor/metaworld/engine/geom_bounds.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <string>

#include "actor/metaworld/assets.h"
#include "actor/metaworld/engine/collision_pairs.h"
#include "actor/metaworld/engine/engine.h"
#include "actor/metaworld/tasks/task_table.h"
#include "common/numbers/random.h"
#include "tests/parity/tasks.h"

/// The test that rules pairs out, against the engine's own collision functions on every pair of
/// geoms in random poses: far more configurations than episodes reach.
namespace metronome::metaworld {
namespace {

class GeomBoundsTest : public testing::TestWithParam<std::string> {};

void PlaceAtRandom(const mjModel& m, mjData& d, int geom, numbers::RandomStream& random) {
  std::array<mjtNum, 4> quaternion;
  for (mjtNum& x : quaternion) x = random.Normal();
  mju_normalize4(quaternion.data());
  mju_quat2Mat(d.geom_xmat + 9 * geom, quaternion.data());
  const mjtNum spread = std::clamp<mjtNum>(m.geom_rbound[geom], 0.02, 0.3);
  for (int i = 0; i < 3; ++i) d.geom_xpos[3 * geom + i] = spread * random.Normal();
}

TEST_P(GeomBoundsTest, PairsThatAreCalledApartHaveNoContact) {
  const auto scene = metaworld::engine::Scene::Load(DefaultAssetsPath(),
                                                    metaworld::tasks::FindTask(GetParam()).scene);
  const metaworld::engine::PlacedModel model(scene->model());
  const metaworld::engine::DataPtr data = scene->MakeData();
  const mjModel& m = *model;
  const metaworld::engine::GeomBounds bounds(m);
  mj_forward(model.get(), data.get());
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 31, 0, 0);
  std::array<mjContact, mjMAXCONPAIR> contacts;
  int apart = 0, touching = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    int geom1 = static_cast<int>(random.Below(static_cast<std::uint64_t>(m.ngeom)));
    int geom2 = static_cast<int>(random.Below(static_cast<std::uint64_t>(m.ngeom)));
    if (m.geom_type[geom1] > m.geom_type[geom2]) std::swap(geom1, geom2);
    const mjfCollision collide = mjCOLLISIONFUNC[m.geom_type[geom1]][m.geom_type[geom2]];
    if (geom1 == geom2 || collide == nullptr) continue;
    PlaceAtRandom(m, *data, geom1, random);
    PlaceAtRandom(m, *data, geom2, random);
    const mjtNum margin = 0.001 * static_cast<mjtNum>(random.Below(3));
    const bool called_apart = bounds.SurelyApart(*data, geom1, geom2, margin);
    const int count = collide(&m, data.get(), contacts.data(), geom1, geom2, margin);
    apart += called_apart ? 1 : 0;
    touching += count > 0 ? 1 : 0;
    ASSERT_FALSE(called_apart && count > 0) << "geoms " << geom1 << " and " << geom2;
  }
  EXPECT_GT(apart, 1000);
  EXPECT_GT(touching, 1000);
}

TEST_P(GeomBoundsTest, ASceneWithPredefinedPairsIsRefused) {
  const auto scene = metaworld::engine::Scene::Load(DefaultAssetsPath(),
                                                    metaworld::tasks::FindTask(GetParam()).scene);
  metaworld::engine::PlacedModel model(scene->model());
  EXPECT_NO_THROW(metaworld::engine::CollisionPairs{*model});
  model->npair = 1;
  EXPECT_THROW(metaworld::engine::CollisionPairs{*model}, std::logic_error);
  model->npair = 0;
}

INSTANTIATE_TEST_SUITE_P(Tasks, GeomBoundsTest, EachTask(), TestName);

}  // namespace
}  // namespace metronome::metaworld
