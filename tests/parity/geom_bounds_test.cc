#include "actor/metaworld/engine/geom_bounds.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "actor/metaworld/assets.h"
#include "actor/metaworld/engine/collision_pairs.h"
#include "actor/metaworld/engine/engine.h"
#include "actor/metaworld/engine/geom_travel.h"
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

struct Pair {
  int geom1, geom2;
  mjfCollision collide;  // the engine's function for them
};

/// Two geoms, placed at random; none if the engine has no function for those that were drawn.
std::optional<Pair> RandomPair(const mjModel& m, mjData& d, numbers::RandomStream& random) {
  int geom1 = static_cast<int>(random.Below(static_cast<std::uint64_t>(m.ngeom)));
  int geom2 = static_cast<int>(random.Below(static_cast<std::uint64_t>(m.ngeom)));
  if (m.geom_type[geom1] > m.geom_type[geom2]) std::swap(geom1, geom2);
  const mjfCollision collide = mjCOLLISIONFUNC[m.geom_type[geom1]][m.geom_type[geom2]];
  if (geom1 == geom2 || collide == nullptr) return std::nullopt;
  PlaceAtRandom(m, d, geom1, random);
  PlaceAtRandom(m, d, geom2, random);
  return Pair{geom1, geom2, collide};
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
    const auto pair = RandomPair(m, *data, random);
    if (!pair) continue;
    const int geom1 = pair->geom1, geom2 = pair->geom2;
    const mjtNum margin = 0.001 * static_cast<mjtNum>(random.Below(3));
    const bool called_apart = bounds.SurelyApart(*data, geom1, geom2, margin);
    const int count = pair->collide(&m, data.get(), contacts.data(), geom1, geom2, margin);
    apart += called_apart ? 1 : 0;
    touching += count > 0 ? 1 : 0;
    ASSERT_FALSE(called_apart && count > 0) << "geoms " << geom1 << " and " << geom2;
  }
  EXPECT_GT(apart, 1000);
  EXPECT_GT(touching, 1000);
}

// Where the engine would be first to err: moved apart until the test just says so.
TEST_P(GeomBoundsTest, PairsThatAreBarelyCalledApartHaveNoContact) {
  const auto scene = metaworld::engine::Scene::Load(DefaultAssetsPath(),
                                                    metaworld::tasks::FindTask(GetParam()).scene);
  const mjModel& m = scene->model();
  const metaworld::engine::DataPtr data = scene->MakeData();
  const metaworld::engine::GeomBounds bounds(m);
  mj_forward(&m, data.get());
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 32, 0, 0);
  std::array<mjContact, mjMAXCONPAIR> contacts;
  int barely = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const auto pair = RandomPair(m, *data, random);
    if (!pair) continue;
    const int geom1 = pair->geom1, geom2 = pair->geom2;
    mjtNum* moved = data->geom_xpos + 3 * geom2;
    const std::array<mjtNum, 3> start = {moved[0], moved[1], moved[2]};
    const std::array<mjtNum, 3> way = {random.Normal(), random.Normal(), random.Normal()};
    const auto apart_at = [&](mjtNum distance) {
      for (std::size_t i = 0; i < 3; ++i) moved[i] = start[i] + distance * way[i];
      return bounds.SurelyApart(*data, geom1, geom2, 0);
    };
    mjtNum near = 0, far = 4;
    if (apart_at(near) || !apart_at(far)) continue;
    for (int i = 0; i < 24; ++i) {
      const mjtNum middle = (near + far) / 2;
      (apart_at(middle) ? far : near) = middle;
    }
    ASSERT_TRUE(apart_at(far));
    ASSERT_EQ(pair->collide(&m, data.get(), contacts.data(), geom1, geom2, 0), 0)
        << "geoms " << geom1 << " and " << geom2;
    ++barely;
  }
  EXPECT_GT(barely, 1000);
}

TEST_P(GeomBoundsTest, NoPointOfAGeomMovesFartherThanItsTravel) {
  const auto scene = metaworld::engine::Scene::Load(DefaultAssetsPath(),
                                                    metaworld::tasks::FindTask(GetParam()).scene);
  const mjModel& m = scene->model();
  const metaworld::engine::DataPtr data = scene->MakeData();
  mj_forward(&m, data.get());
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 33, 0, 0);
  metaworld::engine::GeomTravel travel(m);
  for (int geom = 0; geom < m.ngeom; ++geom) travel.Follow(geom);
  ASSERT_FALSE(travel.Add(*data));
  for (int geom = 0; geom < m.ngeom; ++geom) {
    if (m.geom_type[geom] != mjGEOM_MESH) continue;
    const int mesh = m.geom_dataid[geom];
    const auto place = [&](int vertex) {
      const float* local = m.mesh_vert + 3 * (m.mesh_vertadr[mesh] + vertex);
      std::array<mjtNum, 3> world;
      for (int i = 0; i < 3; ++i) {
        const mjtNum* row = data->geom_xmat + 9 * geom + 3 * i;
        world[static_cast<std::size_t>(i)] = data->geom_xpos[3 * geom + i] + row[0] * local[0] +
                                             row[1] * local[1] + row[2] * local[2];
      }
      return world;
    };
    const mjtNum before = travel.Of(geom);
    std::vector<std::array<mjtNum, 3>> vertices;
    for (int i = 0; i < m.mesh_vertnum[mesh]; ++i) vertices.push_back(place(i));
    PlaceAtRandom(m, *data, geom, random);
    ASSERT_TRUE(travel.Add(*data));
    for (int i = 0; i < m.mesh_vertnum[mesh]; ++i) {
      const std::array<mjtNum, 3> now = place(i), then = vertices[static_cast<std::size_t>(i)];
      const mjtNum moved = std::hypot(now[0] - then[0], now[1] - then[1], now[2] - then[2]);
      ASSERT_LE(moved, travel.Of(geom) - before + 1e-9) << "geom " << geom;
    }
  }
}

TEST_P(GeomBoundsTest, TravelBeginsAnewAfterAPoseThatIsNotFinite) {
  const auto scene = metaworld::engine::Scene::Load(DefaultAssetsPath(),
                                                    metaworld::tasks::FindTask(GetParam()).scene);
  const metaworld::engine::DataPtr data = scene->MakeData();
  mj_forward(&scene->model(), data.get());
  metaworld::engine::GeomTravel travel(scene->model());
  travel.Follow(0);
  EXPECT_FALSE(travel.Add(*data));
  EXPECT_TRUE(travel.Add(*data));
  const mjtNum at = std::exchange(data->geom_xpos[0], std::numeric_limits<mjtNum>::quiet_NaN());
  EXPECT_FALSE(travel.Add(*data));
  data->geom_xpos[0] = at;
  EXPECT_FALSE(travel.Add(*data));
  EXPECT_TRUE(travel.Add(*data));
  EXPECT_EQ(travel.Of(0), 0);
  EXPECT_EQ(travel.Moves(0), 3);
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
