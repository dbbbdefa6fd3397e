#include "learner/network/mlp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "common/numbers/random.h"
#include "tests/unit/support/double_network.h"

namespace metronome::network {
namespace {

using policy::HeadRun;

std::vector<float> Normals(std::size_t count, std::uint64_t number, double scale) {
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 1, number, 0);
  std::vector<float> normals(count);
  for (float& normal : normals) normal = float(scale * random.Normal());
  return normals;
}

struct Rows {
  std::size_t count;
  std::vector<std::int32_t> heads;  // of each row, in order of heads

  [[nodiscard]] std::vector<HeadRun> Runs(std::size_t first, std::size_t rows) const {
    std::vector<HeadRun> runs;
    for (std::size_t row = first; row < first + rows; ++row) {
      policy::AddRow(heads[row], row, runs);
    }
    return runs;
  }
};

/// Width, samples, rows of a pass, whether it is normalised.
class MlpTest : public ::testing::TestWithParam<std::tuple<int, int, int, bool>> {
 protected:
  MlpTest() : mlp_(Layout(), std::size_t(std::get<1>(GetParam()))) {
    rows_.count = std::size_t(std::get<1>(GetParam()));
    input_.Resize(rows_.count, 39);
    d_output_ = Normals(rows_.count * 4, 2, 1e-2);
    const std::vector<float> input = Normals(rows_.count * 39, 3, 1);
    for (std::size_t row = 0; row < rows_.count; ++row) {
      rows_.heads.push_back(std::int32_t(row * 3 / rows_.count) + 1);  // head 0 has none
      std::copy_n(input.data() + row * 39, 39, input_.row(row));
      std::copy_n(d_output_.data() + row * 4, 4, mlp_.d_output().row(row));
    }
    for (std::size_t part = 0; part < mlp_.weight_parts(); ++part) {
      mlp_.Pack(part, parameters_.data());
    }
    const auto step = std::size_t(std::get<2>(GetParam()));
    for (std::size_t first = 0; first < rows_.count; first += step) {
      const std::size_t count = std::min(step, rows_.count - first);
      mlp_.Forward(input_, first, count, rows_.Runs(first, count));
      mlp_.Backward(first, count, rows_.Runs(first, count));
    }
    for (std::size_t part = 0; part < mlp_.gradient_parts(); ++part) {
      squares_ +=
          mlp_.Gradient(part, input_, {rows_.count}, rows_.Runs(0, rows_.count), gradient_.data());
    }
  }

  static policy::NetworkShape Shape() {
    policy::NetworkShape shape;
    shape.observation = 39;
    shape.hidden = {std::get<0>(GetParam()), std::get<0>(GetParam()) + 3};
    shape.heads = 4;
    shape.critic_heads = 4;
    shape.action = 4;
    return shape;
  }

  static policy::MlpLayout Layout() {
    policy::MlpLayout layout = policy::ActorLayout(Shape());
    layout.normalised = std::get<3>(GetParam());
    return layout;
  }

  policy::MlpLayout layout_ = Layout();
  std::vector<float> parameters_ = Normals(layout_.size, 1, 0.2);
  Mlp mlp_;
  Rows rows_;
  kernels::Matrix input_;
  std::vector<float> d_output_;
  std::vector<float> gradient_ = std::vector<float>(layout_.size, 0.0F);
  double squares_ = 0;
};

TEST_P(MlpTest, OutputsAreThoseOfEachRowsHead) {
  for (std::size_t row = 0; row < rows_.count; ++row) {
    const std::vector<double> x(input_.row(row), input_.row(row) + 39);
    const auto want = testing::Forward(parameters_, layout_, x, rows_.heads[row]);
    for (std::size_t i = 0; i < 4; ++i) ASSERT_NEAR(mlp_.output().row(row)[i], want[i], 2e-5);
  }
}

// The rule of the first layer's sums, written plainly: groups of samples, a chain each.
TEST_P(MlpTest, AWeightsGradientIsTheSumOfItsGroupsChains) {
  const policy::LayerSlice slice = policy::HeadSlice(layout_, 2);
  const SampleGroups groups{rows_.count};
  // d_output is given, so the head's own gradient needs its activations alone; those of no hidden
  // layer are the input.
  policy::Activations activations(layout_, rows_.count);
  policy::PackedNetwork(layout_, parameters_.data())
      .Forward(input_, activations, 0, rows_.count, rows_.Runs(0, rows_.count));
  for (std::int32_t o = 0; o < 4; ++o) {
    for (std::int32_t i = 0; i < slice.inputs; ++i) {
      float sum = 0;
      for (std::size_t g = 0; g < SampleGroups::kGroups; ++g) {
        float chain = 0;
        for (std::size_t row = groups.begin(g); row < groups.end(g); ++row) {
          if (rows_.heads[row] != 2) continue;
          chain = std::fma(d_output_[row * 4 + std::size_t(o)],
                           activations.hidden.back().row(row)[i], chain);
        }
        sum += chain;
      }
      ASSERT_EQ(gradient_[slice.weight + std::size_t(o * slice.inputs + i)], sum);
    }
  }
}

TEST_P(MlpTest, TheGradientIsThatOfTheWeightedOutputs) {
  const std::vector<double> at(parameters_.begin(), parameters_.end());
  const auto objective = [&](const std::vector<double>& parameters) {
    double sum = 0;
    for (std::size_t row = 0; row < rows_.count; ++row) {
      const std::vector<double> x(input_.row(row), input_.row(row) + 39);
      const auto output = testing::Forward(parameters, layout_, x, rows_.heads[row]);
      for (std::size_t i = 0; i < 4; ++i) sum += output[i] * d_output_[row * 4 + i];
    }
    return sum;
  };
  for (std::size_t i = 0; i < layout_.log_std; i += layout_.log_std / 60 + 1) {
    std::vector<double> up = at;
    std::vector<double> down = at;
    up[i] += 1e-4;
    down[i] -= 1e-4;
    const double want = (objective(up) - objective(down)) / 2e-4;
    ASSERT_NEAR(gradient_[i], want, 1e-5 + 1e-4 * std::abs(want)) << "parameter " << i;
  }
}

TEST_P(MlpTest, SquaresAreThoseOfTheGradientAndAHeadWithoutSamplesHasNone) {
  double want = 0;
  for (const float value : gradient_) want += double{value} * value;
  EXPECT_NEAR(squares_, want, 1e-9 * want);
  const policy::LayerSlice slice = policy::HeadSlice(layout_, 0);
  for (std::int32_t i = 0; i < 4 * slice.inputs; ++i) {
    ASSERT_EQ(gradient_[slice.weight + std::size_t(i)], 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, MlpTest,
                         ::testing::Combine(::testing::Values(13, 64), ::testing::Values(5, 150),
                                            ::testing::Values(1, 24), ::testing::Bool()));

}  // namespace
}  // namespace metronome::network
