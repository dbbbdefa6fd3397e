#include "common/kernels/isa.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace metronome::kernels {
namespace {

constexpr Isa kAll[] = {Isa::kScalar, Isa::kAvx2, Isa::kAvx512};

TEST(IsaTest, NamesAreReadBack) {
  for (const Isa isa : kAll) EXPECT_EQ(IsaNamed(NameOf(isa)), isa);
  EXPECT_EQ(IsaNamed("avx"), std::nullopt);
}

TEST(IsaTest, TheFastestThatTheProcessorHasIsTheFirstChoice) {
  EXPECT_EQ(SupportedIsas().front(), Isa::kScalar);
  EXPECT_EQ(CurrentIsa(), SupportedIsas().back());
}

TEST(IsaTest, EverySupportedOneCanBeChosenAndNoOther) {
  const Isa before = CurrentIsa();
  for (const Isa isa : kAll) {
    if (testing::Value(SupportedIsas(), testing::Contains(isa))) {
      ChooseIsa(isa);
      EXPECT_EQ(CurrentIsa(), isa);
      continue;
    }
    try {
      ChooseIsa(isa);
      FAIL() << NameOf(isa);
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::StartsWith("this processor has no " +
                                                    std::string(NameOf(isa)) + "; it has: scalar"));
    }
  }
  ChooseIsa(before);
}

}  // namespace
}  // namespace metronome::kernels
