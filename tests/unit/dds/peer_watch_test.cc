#include "common/dds/peer_watch.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace metronome::dds {
namespace {

constexpr std::uint64_t kPeer = 7;

fdds::InstanceHandle_t Writer(std::uint8_t number) {
  eprosima::fastrtps::rtps::GUID_t guid;
  guid.guidPrefix.value[0] = number;
  guid.entityId.value[3] = 1;
  return {guid};
}

class WriterWatchTest : public ::testing::Test {
 protected:
  void Matched(const fdds::InstanceHandle_t& writer, int change) {
    fdds::SubscriptionMatchedStatus status;
    status.current_count_change = change;
    status.last_publication_handle = writer;
    watch_.on_subscription_matched(nullptr, status);
  }

  Inbox inbox_;
  WriterWatch watch_{&inbox_};
};

TEST_F(WriterWatchTest, APeerThatLeavesIsLostOnce) {
  Matched(Writer(1), 1);
  watch_.Saw(Writer(1), kPeer);
  EXPECT_EQ(watch_.NextLost(), std::nullopt);
  Matched(Writer(1), -1);
  EXPECT_EQ(watch_.NextLost(), kPeer);
  EXPECT_EQ(watch_.NextLost(), std::nullopt);
  EXPECT_TRUE(watch_.Processes().empty());
}

TEST_F(WriterWatchTest, ASampleTakenAfterItsWriterLeftIsItsLastWord) {
  Matched(Writer(1), 1);
  Matched(Writer(1), -1);
  watch_.Saw(Writer(1), kPeer);
  EXPECT_EQ(watch_.NextLost(), kPeer);
  EXPECT_TRUE(watch_.Processes().empty());
}

TEST_F(WriterWatchTest, AWriterThatLeavesWhileTheReaderIsFoundEmptyIsRemembered) {
  Matched(Writer(1), 1);
  const std::uint64_t mark = watch_.Deaths();
  // The reader is empty; now a sample of the writer comes, and the writer leaves.
  Matched(Writer(1), -1);
  watch_.Drained(mark);
  watch_.Saw(Writer(1), kPeer);
  EXPECT_EQ(watch_.NextLost(), kPeer);
  EXPECT_TRUE(watch_.Processes().empty()) << "a dead peer stays for ever";
}

TEST_F(WriterWatchTest, OnceTheReaderIsFoundEmptyAWriterOfBeforeIsForgotten) {
  Matched(Writer(1), 1);
  Matched(Writer(1), -1);
  watch_.Drained(watch_.Deaths());
  watch_.Saw(Writer(1), kPeer);  // as of one that came back before its match was told
  EXPECT_EQ(watch_.NextLost(), std::nullopt);
  EXPECT_EQ(watch_.Processes().size(), 1U);
}

TEST_F(WriterWatchTest, AWriterThatIsMatchedAnewLivesAgain) {
  Matched(Writer(1), 1);
  Matched(Writer(1), -1);
  Matched(Writer(1), 1);
  watch_.Saw(Writer(1), kPeer);
  EXPECT_EQ(watch_.NextLost(), std::nullopt);
}

}  // namespace
}  // namespace metronome::dds
