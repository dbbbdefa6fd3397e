#include "actor/render/episode_pictures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

#include "actor/metaworld/sawyer.h"
#include "actor/metaworld/tasks/task_table.h"
#include "actor/render/camera.h"
#include "actor/render/head_colors.h"

namespace metronome::render {
namespace {

constexpr ImageSize kSize = {640, 480};
constexpr int kHeads = 5;
constexpr int kStepsAHead = 10;

Pose PoseOf(const mjModel& model, const mjData& data) {
  return {{data.qpos, data.qpos + model.nq},
          {data.mocap_pos, data.mocap_pos + 3 * model.nmocap},
          {data.mocap_quat, data.mocap_quat + 4 * model.nmocap}};
}

/// Each head draws a line of its own height above the table, in the camera's plain view.
EpisodePath Stripes(const Pose& pose) {
  EpisodePath path;
  path.heads = kHeads;
  for (int t = 0; t <= kHeads * kStepsAHead; ++t) {
    PathPoint point;
    point.pose = pose;
    point.head = std::max(t - 1, 0) / kStepsAHead;
    const int across = t % (2 * kStepsAHead);
    point.hand = {-0.2 + 0.04 * (across <= kStepsAHead ? across : 2 * kStepsAHead - across), 0.5,
                  0.05 + 0.06 * point.head};
    path.points.push_back(point);
  }
  return path;
}

/// Counts pixels near `color` in rows [top, bottom) of an image.
int Count(const Image& image, const Color& color, int top, int bottom, int tolerance) {
  int count = 0;
  for (int pixel = top * image.size.width; pixel < bottom * image.size.width; ++pixel) {
    const std::uint8_t* rgb = image.rgb.data() + std::size_t(pixel) * 3;
    bool near = true;
    for (int i = 0; i < 3; ++i) near = near && std::abs(rgb[i] - color.at(i)) <= tolerance;
    count += near ? 1 : 0;
  }
  return count;
}

class EpisodePicturesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    environment_->Reset({0, 0.65, 0.02, 0.05, 0.85, 0.02});
    path_ = Stripes(PoseOf(environment_->model(), environment_->data()));
  }
  EpisodePictures Pictures(bool show_path = true) {
    return {
        environment_->model(),
        FindCamera(environment_->model(), metaworld::tasks::FindTask("push").view, "90,-20,1.2"),
        path_,
        {"push", kSize, show_path, 0.0}};
  }

  std::unique_ptr<metaworld::SawyerEnvironment> environment_ =
      metaworld::tasks::MakeSawyerEnvironment("push", {});
  EpisodePath path_;
};

TEST_F(EpisodePicturesTest, EveryHeadsPathAndLegendHaveItsColour) {
  EpisodePictures with = Pictures();
  const Image image = with.Whole(50);
  EpisodePictures without = Pictures(false);
  const Image bare = without.Whole(50);
  ASSERT_EQ(image.rgb.size(), std::size_t(kSize.width) * kSize.height * 3);
  const int foot = kSize.height - 80;  // above it there is no legend
  for (int head = 0; head < kHeads; ++head) {
    const Color color = HeadColor(head, kHeads);
    EXPECT_GT(Count(image, color, foot, kSize.height, 0), 1000) << "legend, head " << head;
    EXPECT_GT(Count(image, color, 0, foot, 40), 300 + Count(bare, color, 0, foot, 40))
        << "path, head " << head;
  }
}

TEST_F(EpisodePicturesTest, AMomentShowsThePathSoFarAndWhoActs) {
  EpisodePictures pictures = Pictures();
  const Image image = pictures.Moment(25);
  EXPECT_GT(Count(image, HeadColor(2, kHeads), 0, 30, 0), 500);  // the headline
  EXPECT_EQ(Count(image, HeadColor(3, kHeads), 0, 30, 0), 0);
  EXPECT_GT(Count(image, HeadColor(1, kHeads), 40, 400, 40), 300);  // the path
  EXPECT_LT(Count(image, HeadColor(4, kHeads), 40, 400, 25), 50);
}

TEST_F(EpisodePicturesTest, DrawingTwiceGivesTheSameAndLeavesTheEnvironmentAlone) {
  const Pose before = PoseOf(environment_->model(), environment_->data());
  EpisodePictures pictures = Pictures();
  const Image first = pictures.Whole(50);
  static_cast<void>(pictures.Moment(7));
  EXPECT_EQ(first.rgb, pictures.Whole(50).rgb);
  EXPECT_EQ(before.qpos, PoseOf(environment_->model(), environment_->data()).qpos);
}

TEST(FindCameraTest, ListsTheCamerasWhereThereIsNone) {
  const auto environment = metaworld::tasks::MakeSawyerEnvironment("push", {});
  EXPECT_EQ(
      FindCamera(environment->model(), metaworld::tasks::FindTask("push").view, "corner2").type,
      mjCAMERA_FIXED);
  EXPECT_EQ(FindCamera(environment->model(), metaworld::tasks::FindTask("push").view, "free").type,
            mjCAMERA_FREE);
  EXPECT_EQ(
      FindCamera(environment->model(), metaworld::tasks::FindTask("push").view, "90,-20,2,0,1,0.5")
          .lookat[1],
      1);
  try {
    FindCamera(environment->model(), metaworld::tasks::FindTask("push").view, "cornr2");
    FAIL();
  } catch (const std::invalid_argument& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("did you mean \"corner2\""), std::string::npos) << what;
    EXPECT_NE(what.find("free, topview"), std::string::npos) << what;
  }
  EXPECT_THROW(FindCamera(environment->model(), metaworld::tasks::FindTask("push").view, "90,-20"),
               std::invalid_argument);
  EXPECT_THROW(
      FindCamera(environment->model(), metaworld::tasks::FindTask("push").view, "90,-20,0"),
      std::invalid_argument);
}

}  // namespace
}  // namespace metronome::render
