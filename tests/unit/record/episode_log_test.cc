#include "learner/record/episode_log.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "common/process/files.h"
#include "tests/unit/support/temporary_folder.h"

namespace metronome::record {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSteps = 5;

/// Of five steps, two observations, one action.
Episode EpisodeNumber(std::uint64_t number) {
  Episode episode;
  episode.number = number;
  episode.weights_version = number / 2;
  for (std::size_t i = 0; i < 2 * (kSteps + 1); ++i) {
    episode.observation.push_back(float(number) + 0.1F * float(i));
  }
  for (std::size_t t = 0; t < kSteps; ++t) {
    episode.action.push_back(-1.0F / 3 * float(t));
    episode.log_prob.push_back(1e-30F);
    episode.reward.push_back(float(number) * float(t));
    episode.head.push_back(std::uint16_t(300 * t));
    episode.flags.push_back(std::uint8_t(t % 2));
  }
  return episode;
}

std::vector<Episode> Episodes(std::uint64_t first, std::uint64_t next) {
  std::vector<Episode> episodes;
  for (std::uint64_t number = first; number < next; ++number) {
    episodes.push_back(EpisodeNumber(number));
  }
  return episodes;
}

class EpisodeLogTest : public TemporaryFolderTest {
 protected:
  /// The log of a replay of ten episodes, and its position after batches of four up to `next`.
  checkpoint::ReplayPosition Write(const checkpoint::ReplayPosition& from, std::uint64_t next) {
    EpisodeLog log(root_, from, 10 * kSteps, 2);
    for (std::uint64_t first = from.next; first < next; first += 4) {
      log.Append(Episodes(first, first + 4));
    }
    EXPECT_TRUE(log.Sync());
    log.Saved();
    return log.position();
  }

  std::string ErrorOfReading(const checkpoint::ReplayPosition& position) {
    try {
      (void)EpisodeLog::Read(root_, position);
    } catch (const ReplayDamaged& error) {
      return error.what();
    }
    return "none";
  }

  [[nodiscard]] std::string Segment() const { return root_ + "/replay/000000000000.episodes"; }
};

TEST_F(EpisodeLogTest, TheNewestEpisodesThatTheReplayHoldsComeBackToTheBit) {
  const checkpoint::ReplayPosition early = Write({}, 8);
  EXPECT_EQ(early.first, 0U);
  EXPECT_EQ(early.next, 8U);
  const checkpoint::ReplayPosition late = Write(early, 24);
  EXPECT_EQ(late.first, 14U);
  EXPECT_EQ(EpisodeLog::Read(root_, late), Episodes(14, 24));
  EXPECT_EQ(EpisodeLog::Read(root_, early), Episodes(0, 8));
  EXPECT_EQ(EpisodeLog::Read(root_, {}), std::vector<Episode>());
}

TEST_F(EpisodeLogTest, GoesOnBehindTheCheckpointAndCutsOffWhatCameAfterIt) {
  const checkpoint::ReplayPosition early = Write({}, 8);
  const std::string bytes = process::ReadFile(Segment());
  const checkpoint::ReplayPosition late = Write(early, 16);
  EXPECT_EQ(Write(early, 16), late);  // the same again
  EXPECT_EQ(EpisodeLog::Read(root_, late), Episodes(6, 16));
  { const EpisodeLog cut(root_, early, 10 * kSteps, 2); }
  EXPECT_EQ(process::ReadFile(Segment()), bytes);
  EXPECT_NE(ErrorOfReading(late), "none");
}

TEST_F(EpisodeLogTest, ATornEndBehindTheCheckpointIsCutOff) {
  const checkpoint::ReplayPosition position = Write({}, 8);
  const std::string bytes = process::ReadFile(Segment());
  for (const std::string& torn : {std::string("\x20"), bytes.substr(0, 50)}) {
    process::WriteFileAtomically(Segment(), bytes + torn);
    EXPECT_EQ(Write(position, 8), position);
    EXPECT_EQ(process::ReadFile(Segment()), bytes);
  }
}

TEST_F(EpisodeLogTest, WhereverAByteIsLostOrChangedItIsRefusedByName) {
  const checkpoint::ReplayPosition position = Write({}, 4);
  const std::string bytes = process::ReadFile(Segment());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = char(changed[at] ^ 4);
    process::WriteFileAtomically(Segment(), changed);
    ASSERT_NE(ErrorOfReading(position).find(root_ + "/replay"), std::string::npos) << at;
    process::WriteFileAtomically(Segment(), bytes.substr(0, at));
    ASSERT_NE(ErrorOfReading(position).find(root_ + "/replay"), std::string::npos) << at;
  }
  fs::remove(Segment());
  EXPECT_EQ(ErrorOfReading(position), root_ +
                                          "/replay holds 0 of the 4 episodes that the checkpoint's "
                                          "replay has, episodes 0 to 4 (the last one left out)");
}

TEST_F(EpisodeLogTest, EpisodesOfAnotherRunAreRefused) {
  const checkpoint::ReplayPosition position = Write({}, 4);
  fs::remove_all(root_ + "/replay");
  EpisodeLog other(root_, {}, 10 * kSteps, 2);
  std::vector<Episode> episodes = Episodes(0, 4);
  episodes[2].reward[1] += 1;
  other.Append(episodes);
  EXPECT_TRUE(other.Sync());
  EXPECT_NE(ErrorOfReading(position).find("holds other episodes 0 to 4"), std::string::npos);
}

TEST_F(EpisodeLogTest, NoCheckpointFollowsABatchThatFoundNoFile) {
  EpisodeLog log(root_, {}, 10 * kSteps, 2);
  fs::create_directory(Segment());  // in the segment's place
  EXPECT_THROW(log.Append(Episodes(0, 4)), std::system_error);
  EXPECT_FALSE(log.Sync());
  fs::remove(Segment());
  log.Append(Episodes(4, 8));
  EXPECT_FALSE(log.Sync());
}

// A segment has 32 MB; episodes of 8 MB make four a segment.
TEST_F(EpisodeLogTest, SegmentsThatNoKeptCheckpointNeedsAreRemoved) {
  EpisodeLog log(root_, {}, 2 * kSteps, 2);
  const auto segments = [this] {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(root_ + "/replay")) {
      count += entry.is_regular_file() ? 1 : 0;
    }
    return count;
  };
  checkpoint::ReplayPosition before;
  for (std::uint64_t number = 0; number < 10; ++number) {
    Episode episode = EpisodeNumber(number);
    episode.observation.resize((kSteps + 1) * 350000);
    log.Append({episode});
    EXPECT_TRUE(log.Sync());
    log.Saved();
    EXPECT_LE(segments(), 3U) << number;
    EXPECT_EQ(ErrorOfReading(before), "none") << number;  // of the other checkpoint that is kept
    before = log.position();
  }
  const checkpoint::ReplayPosition position = log.position();
  EXPECT_EQ(position.first, 8U);
  EXPECT_EQ(EpisodeLog::Read(root_, position).size(), 2U);
}

}  // namespace
}  // namespace metronome::record
