#include "common/kernels/isa.h"

#include "common/kernels/targets.h"
// Above the library that it configures.
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <stdexcept>

#include "common/text/near_miss.h"

namespace metronome::kernels {
namespace {

struct Row {
  Isa isa;
  std::string_view name;
  std::int64_t target;  // of Highway
};

constexpr std::array<Row, 3> kRows = {{{Isa::kScalar, "scalar", HWY_SCALAR},
                                       {Isa::kAvx2, "avx2", HWY_AVX2},
                                       {Isa::kAvx512, "avx512", HWY_AVX3}}};

std::atomic<Isa>& Chosen() {
  static std::atomic<Isa> chosen = SupportedIsas().back();
  return chosen;
}

}  // namespace

std::string_view NameOf(Isa isa) { return kRows.at(std::size_t(isa)).name; }

std::optional<Isa> IsaNamed(std::string_view name) {
  for (const Row& row : kRows) {
    if (row.name == name) return row.isa;
  }
  return std::nullopt;
}

std::vector<std::string> NamesOf(std::span<const Isa> isas) {
  std::vector<std::string> names;
  for (const Isa isa : isas) names.emplace_back(NameOf(isa));
  return names;
}

std::vector<Isa> SupportedIsas() {
  std::vector<Isa> supported;
  for (const Row& row : kRows) {
    if (row.isa == Isa::kScalar || (hwy::SupportedTargets() & row.target) != 0) {
      supported.push_back(row.isa);
    }
  }
  return supported;
}

Isa CurrentIsa() { return Chosen(); }

std::string WithCurrentIsa(const std::string& build) {
  return build + ", isa " + std::string(NameOf(CurrentIsa()));
}

void ChooseIsa(Isa isa) {
  const std::vector<Isa> supported = SupportedIsas();
  if (std::find(supported.begin(), supported.end(), isa) == supported.end()) {
    throw std::invalid_argument("this processor has no " + std::string(NameOf(isa)) +
                                "; it has: " + text::JoinNames(NamesOf(supported)));
  }
  Chosen() = isa;
}

}  // namespace metronome::kernels
