#include <gtest/gtest.h>

#include <string>

#include "common/kernels/isa.h"
#include "common/process/sha256.h"
#include "learner/ppo/trainer.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::ppo {
namespace {

/// Of WeightsAfterThreeUpdates: of every compiler, whatever its flags. A change that is meant to
/// change bits puts in what the failing test prints.
constexpr const char* kWeightsSha256 =
    "72169fe389a8789c59a8fafde9fa113ad9b320b6fd8389d28eb7ec65813665dc";

/// A learner alone: no engine and no C library's functions have a part in it.
std::string WeightsAfterThreeUpdates() {
  const RunConfig config = testing::SmallConfig();
  Trainer trainer(config, Trainer::InitialState(config), 2);
  for (std::uint64_t i = 0; i < 3; ++i) {
    trainer.Update(testing::SyntheticBatch(config, SnapshotOf(trainer.state(), config), i));
  }
  return process::WeightsSha256(trainer.state().parameters);
}

class PinnedUpdateTest : public ::testing::TestWithParam<kernels::Isa> {
 protected:
  void SetUp() override { kernels::ChooseIsa(GetParam()); }
  void TearDown() override { kernels::ChooseIsa(before_); }

 private:
  const kernels::Isa before_ = kernels::CurrentIsa();
};

TEST_P(PinnedUpdateTest, EveryCompilersWeightsAreThePinnedOnes) {
  const std::string weights = WeightsAfterThreeUpdates();
  EXPECT_EQ(weights, kWeightsSha256);
}

INSTANTIATE_TEST_SUITE_P(Isas, PinnedUpdateTest, ::testing::ValuesIn(kernels::SupportedIsas()),
                         [](const auto& isa) { return std::string(NameOf(isa.param)); });

}  // namespace
}  // namespace metronome::ppo
