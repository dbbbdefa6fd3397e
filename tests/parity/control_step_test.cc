#include "actor/metaworld/engine/control_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string>

#include "actor/metaworld/assets.h"
#include "actor/metaworld/engine/engine.h"
#include "actor/metaworld/engine/looks.h"
#include "actor/metaworld/tasks/task_table.h"
#include "common/numbers/random.h"
#include "tests/parity/tasks.h"

/// The shortcuts of a control step against the plain loop on the bare engine, bit by bit.
namespace metronome::metaworld {
namespace {

bool SameBits(const mjtNum* a, const mjtNum* b, int count) {
  return std::memcmp(a, b, count * sizeof(mjtNum)) == 0;
}

void ExpectSameContact(const mjContact& a, const mjContact& b) {
  ASSERT_EQ(a.geom1, b.geom1);
  ASSERT_EQ(a.geom2, b.geom2);
  ASSERT_EQ(a.dim, b.dim);
  ASSERT_EQ(a.dist, b.dist);
  ASSERT_EQ(a.includemargin, b.includemargin);
  ASSERT_TRUE(SameBits(a.pos, b.pos, 3)) << "contact position";
  ASSERT_TRUE(SameBits(a.frame, b.frame, 9)) << "contact frame";
  ASSERT_TRUE(SameBits(a.friction, b.friction, 5)) << "friction";
  ASSERT_TRUE(SameBits(a.solref, b.solref, mjNREF)) << "solref";
  ASSERT_TRUE(SameBits(a.solimp, b.solimp, mjNIMP)) << "solimp";
}

/// All that the next step, an observation or a reward can depend on.
void ExpectSameState(const mjModel& m, const mjData& a, const mjData& b) {
  ASSERT_TRUE(SameBits(a.qpos, b.qpos, m.nq)) << "qpos";
  ASSERT_TRUE(SameBits(a.qvel, b.qvel, m.nv)) << "qvel";
  ASSERT_TRUE(SameBits(a.qacc_warmstart, b.qacc_warmstart, m.nv)) << "warm start";
  ASSERT_TRUE(SameBits(a.xpos, b.xpos, 3 * m.nbody)) << "body positions";
  ASSERT_TRUE(SameBits(a.xquat, b.xquat, 4 * m.nbody)) << "body orientations";
  for (int geom = 0; geom < m.ngeom; ++geom) {
    if (m.geom_contype[geom] == 0 && m.geom_conaffinity[geom] == 0) continue;  // only seen
    ASSERT_TRUE(SameBits(a.geom_xpos + 3 * geom, b.geom_xpos + 3 * geom, 3)) << "geom " << geom;
    ASSERT_TRUE(SameBits(a.geom_xmat + 9 * geom, b.geom_xmat + 9 * geom, 9)) << "geom " << geom;
  }
  ASSERT_TRUE(SameBits(a.site_xpos, b.site_xpos, 3 * m.nsite)) << "site positions";
  ASSERT_EQ(a.ncon, b.ncon);
  for (int i = 0; i < a.ncon; ++i) ExpectSameContact(a.contact[i], b.contact[i]);
  ASSERT_EQ(a.nefc, b.nefc);
  ASSERT_TRUE(SameBits(a.efc_force, b.efc_force, a.nefc)) << "constraint forces";
  ASSERT_EQ(a.time, b.time);
}

class ControlStepTest : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const auto scene = metaworld::engine::Scene::Load(DefaultAssetsPath(),
                                                      metaworld::tasks::FindTask(GetParam()).scene);
    model_.emplace(scene->model());
    stepper_ = std::make_unique<metaworld::engine::ControlStepper>(**model_);
    whole_ = metaworld::engine::CopyToDraw(**model_);
    plain_.reset(mj_makeData(whole_.get()));
    fast_ = scene->MakeData();
    mj_forward(whole_.get(), plain_.get());
    mj_forward(model_->get(), fast_.get());
  }

  /// Walks the hand about the table, low and among the objects for most of the time.
  void Drive(mjData& data, int t) const {
    numbers::RandomStream stream(numbers::RandomPurpose::kEvaluate, 21, 0,
                                 static_cast<std::uint64_t>(t / 12));
    const std::array<double, 3> low = {-0.25, 0.45, 0.05}, high = {0.25, 0.9, 0.25};
    for (int i = 0; i < 3; ++i) {
      const double pull = i == 2 && t % 200 < 150 ? -0.006 : 0.0;
      data.mocap_pos[i] =
          std::clamp(data.mocap_pos[i] + 0.008 * stream.Normal() + pull, low[i], high[i]);
    }
    const std::array<double, 4> down = {1, 0, 1, 0};
    std::copy(down.begin(), down.end(), data.mocap_quat);
    data.ctrl[0] = 2 * stream.Uniform() - 1;
    data.ctrl[1] = -data.ctrl[0];
  }

  /// As the official environment makes it, with all that the scene has to show.
  void PlainControlStep(mjData& data) const {
    for (int i = 0; i < metaworld::engine::kPhysicsSteps; ++i) mj_step(whole_.get(), &data);
    mj_forward(whole_.get(), &data);
  }

  std::optional<metaworld::engine::PlacedModel> model_;
  metaworld::engine::ModelPtr whole_;
  std::unique_ptr<metaworld::engine::ControlStepper> stepper_;
  metaworld::engine::DataPtr plain_, fast_;
};

TEST_P(ControlStepTest, ShortcutsGiveTheBitsOfThePlainLoopThroughHundredsOfContacts) {
  int contacts = 0;
  for (int t = 0; t < 600; ++t) {
    SCOPED_TRACE("control step " + std::to_string(t));
    Drive(*plain_, t);
    Drive(*fast_, t);
    PlainControlStep(*plain_);
    stepper_->ControlStepAfterForward(*fast_);
    ExpectSameState(**model_, *plain_, *fast_);
    if (HasFatalFailure()) return;
    contacts += plain_->ncon;
  }
  EXPECT_GT(contacts, 200);
}

TEST_P(ControlStepTest, ABadStateIsResetAsByThePlainLoop) {
  for (mjData* data : {plain_.get(), fast_.get()}) {
    Drive(*data, 0);
    data->qvel[3] = 1e30;
  }
  PlainControlStep(*plain_);
  stepper_->ControlStepAfterForward(*fast_);
  EXPECT_EQ(fast_->warning[mjWARN_BADQVEL].number, plain_->warning[mjWARN_BADQVEL].number);
  ExpectSameState(**model_, *plain_, *fast_);
}

TEST_P(ControlStepTest, TheModelThatIsPlayedHasThoseNumbersOfTheWholeThatPhysicsReads) {
  const mjModel &slim = **model_, &whole = *whole_;
  EXPECT_LT(slim.nbuffer, 1500000);
  EXPECT_GT(whole.nbuffer, 4 * slim.nbuffer);
  ASSERT_EQ(slim.ngeom, whole.ngeom);
  EXPECT_TRUE(SameBits(slim.geom_pos, whole.geom_pos, 3 * slim.ngeom));
  EXPECT_TRUE(SameBits(slim.body_inertia, whole.body_inertia, 3 * slim.nbody));
  ASSERT_EQ(slim.nmeshvert, whole.nmeshvert);
  EXPECT_EQ(std::memcmp(slim.mesh_vert, whole.mesh_vert, 12U * unsigned(slim.nmeshvert)), 0);
  ASSERT_EQ(slim.nmeshgraph, whole.nmeshgraph);
  EXPECT_EQ(std::memcmp(slim.mesh_graph, whole.mesh_graph, 4U * unsigned(slim.nmeshgraph)), 0);
}

TEST_P(ControlStepTest, AModelToDrawHasThePlacesOfThePlacedOne) {
  (*model_)->body_pos[4] += 0.125;
  const metaworld::engine::ModelPtr drawn = metaworld::engine::CopyToDraw(**model_);
  EXPECT_GT(drawn->ntexdata, 0);
  EXPECT_TRUE(SameBits(drawn->body_pos, (*model_)->body_pos, 3 * drawn->nbody));
  const metaworld::engine::ModelPtr copy = metaworld::engine::CopyToDraw(*drawn);
  EXPECT_EQ(copy->nbuffer, drawn->nbuffer);  // of no scene: as it is
}

INSTANTIATE_TEST_SUITE_P(Tasks, ControlStepTest, EachTask(), TestName);

}  // namespace
}  // namespace metronome::metaworld
