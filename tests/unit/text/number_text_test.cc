#include "common/text/number_text.h"

#include <gtest/gtest.h>

namespace metronome::text {
namespace {

TEST(NumberTextTest, CountedThingsAreOneOrMany) {
  EXPECT_EQ(Counted(0, "actor"), "0 actors");
  EXPECT_EQ(Counted(1, "actor"), "1 actor");
  EXPECT_EQ(Counted(2, "actor"), "2 actors");
}

}  // namespace
}  // namespace metronome::text
