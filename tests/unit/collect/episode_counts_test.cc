#include "learner/collect/episode_counts.h"

#include <gtest/gtest.h>

namespace metronome::collect {
namespace {

TEST(EpisodeCountsTest, RejectionsAreCountedByActorAndByKindOfReason) {
  EpisodeCounts counts;
  counts.CountRejected("a", "step 17 names head 3");
  counts.CountRejected("a", "step 4 names head 12");
  counts.CountRejected("b", "a reward is not finite");
  EXPECT_EQ(counts.rejected, 3U);
  EXPECT_EQ(counts.rejected_by_reason.at("step # names head #"), 2U);
  EXPECT_EQ(counts.by_actor.at("a").rejected, 2U);
}

}  // namespace
}  // namespace metronome::collect
