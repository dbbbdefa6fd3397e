#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The instruction sets that the kernels of this folder are compiled for. All give the same bits;
/// they differ in speed alone.
namespace metronome::kernels {

enum class Isa {
  kScalar,  // one number at a time; a library call for each fused multiply-add where the build's
            // METRONOME_MARCH has no instruction for it
  kAvx2,    // AVX2 and FMA: 8 numbers
  kAvx512   // AVX-512 F, BW, CD, DQ and VL: 16 numbers
};

inline constexpr std::array kEveryIsa = {Isa::kScalar, Isa::kAvx2, Isa::kAvx512};

/// As on the command line: "scalar", "avx2", "avx512".
std::string_view NameOf(Isa isa);
std::optional<Isa> IsaNamed(std::string_view name);
std::vector<std::string> NamesOf(std::span<const Isa> isas);

/// What this processor can run, slowest first; never empty.
std::vector<Isa> SupportedIsas();

/// What the kernels of this process run on: the fastest that the processor has, until ChooseIsa.
Isa CurrentIsa();

/// What of a process may matter to those that look at its results, for people: "BUILD, isa avx2".
/// @param build  its BuildIdentity().
std::string WithCurrentIsa(const std::string& build);

/// For the whole process; call before threads use kernels. @throws std::invalid_argument for one
/// that the processor does not have, which names those that it has.
void ChooseIsa(Isa isa);

}  // namespace metronome::kernels
