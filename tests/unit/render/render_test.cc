#include "actor/render/render.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "actor/render/episode_path.h"
#include "actor/render/head_colors.h"
#include "actor/render/path_geoms.h"
#include "actor/render/timeline.h"

namespace metronome::render {
namespace {

/// Two heads of three steps each; the hand goes along x, then along z.
EpisodePath TwoHeads() {
  EpisodePath path;
  path.heads = 2;
  for (int t = 0; t <= 6; ++t) {
    PathPoint point;
    point.hand = {0.1 * std::min(t, 3), 0.5, t > 3 ? 0.1 * (t - 3) : 0.0};
    point.object = {0.25, 0.5, 0.125};
    point.gripper = 1;
    point.head = t <= 3 ? 0 : 1;
    point.reward = t / 8.0;
    point.success = t == 6;
    path.points.push_back(point);
  }
  return path;
}

// matplotlib 3.11.2: colormaps["tab10"](j, bytes=True) for j in 0, 1, 7, 9, and
// colormaps["rainbow"](j / 19, bytes=True) for j in 0, 5, 10, 19.
TEST(HeadColorTest, IsWhatMatplotlibGives) {
  EXPECT_EQ(HeadColor(0, 10), (Color{31, 119, 180}));
  EXPECT_EQ(HeadColor(1, 3), (Color{255, 127, 14}));
  EXPECT_EQ(HeadColor(7, 10), (Color{127, 127, 127}));
  EXPECT_EQ(HeadColor(9, 10), (Color{23, 190, 207}));
  EXPECT_EQ(HeadColor(0, 20), (Color{127, 0, 255}));
  EXPECT_EQ(HeadColor(5, 20), (Color{6, 187, 233}));
  EXPECT_EQ(HeadColor(10, 20), (Color{140, 254, 172}));
  EXPECT_EQ(HeadColor(19, 20), (Color{255, 0, 0}));
  EXPECT_THROW(HeadColor(3, 3), std::out_of_range);
  EXPECT_THROW(HeadColor(-1, 3), std::out_of_range);
}

TEST(PathCsvTest, HasARowForTheResetAndOneForEachStep) {
  std::istringstream lines(Csv(TwoHeads()));
  std::vector<std::string> rows;
  for (std::string line; std::getline(lines, line);) rows.push_back(line);
  ASSERT_EQ(rows.size(), 8U);
  EXPECT_EQ(rows[0],
            "t,head,hand_x,hand_y,hand_z,gripper,object_x,object_y,object_z,reward,success");
  EXPECT_EQ(rows[1], "0,,0,0.5,0,1,0.25,0.5,0.125,,");
  EXPECT_EQ(rows[2], "1,0,0.1,0.5,0,1,0.25,0.5,0.125,0.125,0");
  EXPECT_EQ(rows[7].substr(0, 4), "6,1,");
  EXPECT_EQ(rows[7].substr(rows[7].size() - 7), ",0.75,1");
}

TEST(HeadTurnsTest, SayWhoActsWhen) {
  const std::vector<HeadTurn> runs = HeadTurns(TwoHeads());
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[0].head, 0);
  EXPECT_EQ(runs[0].begin, 0);
  EXPECT_EQ(runs[0].end, 3);
  EXPECT_EQ(runs[1].head, 1);
  EXPECT_EQ(runs[1].begin, 3);
  EXPECT_EQ(runs[1].end, 6);
}

TEST(PathGeomsTest, ATubeAStepAndABallWhereAHeadBegins) {
  const std::vector<mjvGeom> geoms = PathGeoms(TwoHeads(), 6);
  ASSERT_EQ(geoms.size(), 8U);
  EXPECT_EQ(geoms[0].type, mjGEOM_SPHERE);
  EXPECT_EQ(geoms[4].type, mjGEOM_SPHERE);
  EXPECT_NEAR(geoms[4].pos[0], 0.3, 1e-6);
  for (const std::size_t tube : {1U, 2U, 3U, 5U, 6U, 7U}) {
    EXPECT_EQ(geoms[tube].type, mjGEOM_CAPSULE);
    EXPECT_NEAR(geoms[tube].size[2], 0.05, 1e-6);  // half its length
  }
  EXPECT_NEAR(geoms[1].pos[0], 0.05, 1e-6);
  EXPECT_NEAR(std::abs(geoms[1].mat[2]), 1, 1e-6);  // its axis, the third column, is along x
  EXPECT_NEAR(geoms[5].pos[2], 0.05, 1e-6);
  EXPECT_NEAR(std::abs(geoms[5].mat[8]), 1, 1e-6);  // along z
  const auto hue = [](const mjvGeom& geom) { return geom.rgba[0] / geom.rgba[2]; };
  EXPECT_NEAR(hue(geoms[3]), 31.0 / 180, 1e-5);
  EXPECT_NEAR(hue(geoms[5]), 255.0 / 14, 1e-3);
}

TEST(PathGeomsTest, EndWhereTheEpisodeHasCome) {
  EXPECT_TRUE(PathGeoms(TwoHeads(), 0).empty());
  EXPECT_EQ(PathGeoms(TwoHeads(), 2).size(), 3U);
}

TEST(PathGeomsTest, AHandThatStaysIsABallAlone) {
  EpisodePath path = TwoHeads();
  for (PathPoint& point : path.points) point.hand = {0, 0.5, 0.2};
  EXPECT_EQ(PathGeoms(path, 6).size(), 2U);
}

TEST(ParseImageSizeTest, TakesWidthAndHeight) {
  EXPECT_EQ(ParseImageSize("640x480").width, 640);
  EXPECT_EQ(ParseImageSize("640x480").height, 480);
  for (const char* bad : {"", "640", "640x", "x480", "640*480", "640x480x3", "0x480", "640x-480",
                          "100x100", "5000x480", "6.4e2x480"}) {
    EXPECT_THROW(ParseImageSize(bad), std::invalid_argument) << bad;
  }
}

TEST(RunRenderTest, NamesWhatIsWrongWithItsOptions) {
  const auto fail = [](const RenderOptions& options, int want) {
    std::ostringstream out;
    std::ostringstream err;
    EXPECT_EQ(RunRender(options, environment::EnvironmentRegistry({}), out, err), want)
        << err.str();
    EXPECT_EQ(out.str(), "");
    return err.str();
  };
  RenderOptions options;
  options.checkpoint = "no-such-file.ckpt";
  EXPECT_NE(fail(options, 2).find("--out"), std::string::npos);
  options.out = "picture.jpg";
  EXPECT_NE(fail(options, 2).find(".png"), std::string::npos);
  options.out = "no-such-folder/picture.png";
  EXPECT_NE(fail(options, 1).find("no folder no-such-folder"), std::string::npos);
  options.out = "picture.png";
  EXPECT_NE(fail(options, 1).find("no-such-file.ckpt"), std::string::npos);
  const std::string device = "no-regular-file.png";
  ASSERT_EQ(mkfifo(device.c_str(), 0600), 0);
  options.out = device;
  EXPECT_NE(fail(options, 1).find("cannot write " + device), std::string::npos);
  options.out = "picture.png";
  options.csv = device;
  EXPECT_NE(fail(options, 1).find("cannot write " + device), std::string::npos);
  std::filesystem::remove(device);
  options.csv = "";
  options.size = "big";
  EXPECT_NE(fail(options, 2).find("--size big"), std::string::npos);
  options.out = "video.mp4";
  options.size = "641x480";
  EXPECT_NE(fail(options, 2).find("even"), std::string::npos);
}

}  // namespace
}  // namespace metronome::render
