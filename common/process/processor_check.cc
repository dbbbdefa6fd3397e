// Ends a program on a processor that cannot run it, with the reason and the way out, before any
// other code of ours runs: even a constructor of a static object may use what is missing. Compiled
// for every x86-64, and therefore without the C++ library, whose inline functions are shared with
// other sources.
#include <cpuid.h>
#include <string.h>
#include <unistd.h>

#include "common/process/processor_needs.h"

namespace {

struct Feature {
  const char* name;
  int level;  // of the x86-64 psABI; 5: in none
  int there;
};

/// Those that not every compiler's __builtin_cpu_supports knows.
struct CpuidBits {
  unsigned basic = 0;     // leaf 1, ecx
  unsigned extended = 0;  // leaf 0x80000001, ecx

  CpuidBits() {
    unsigned a = 0;
    unsigned b = 0;
    unsigned d = 0;
    __get_cpuid(1, &a, &b, &basic, &d);
    __get_cpuid(0x80000001, &a, &b, &extended, &d);
  }
};

void Say(const char* words) {
  if (write(STDERR_FILENO, words, strlen(words)) < 0) return;  // then there is nobody to tell
}

bool Needed(const char* name) {
  for (const char* const* need = metronome::process::kProcessorNeeds; *need != nullptr; ++need) {
    if (strcmp(*need, name) == 0) return true;
  }
  return false;
}

[[noreturn]] void Refuse(const char* program, const Feature* begin, const Feature* end) {
  const char* slash = strrchr(program, '/');
  Say(slash == nullptr ? program : slash + 1);
  Say(": this processor lacks");
  int level = 4;
  for (const Feature* feature = begin; feature != end; ++feature) {
    if (feature->there != 0) continue;
    if (feature->level <= level) level = feature->level - 1;
    if (!Needed(feature->name)) continue;
    Say(" ");
    Say(feature->name);
  }
  Say(", which this build uses (");
  Say(metronome::process::kProcessorNeedsReason);
  Say(").\nBuild for it by deploy/setup --march ");
  Say(level >= 4 ? "x86-64-v4" : level == 3 ? "x86-64-v3" : level == 2 ? "x86-64-v2" : "x86-64");
  Say(".\n");
  _exit(2);
}

void RequireProcessor(int argc, char** argv, char** /*environment*/) {
  __builtin_cpu_init();
  const CpuidBits bits;
  const Feature features[] = {
      {"sse3", 2, __builtin_cpu_supports("sse3")},
      {"ssse3", 2, __builtin_cpu_supports("ssse3")},
      {"sse4.1", 2, __builtin_cpu_supports("sse4.1")},
      {"sse4.2", 2, __builtin_cpu_supports("sse4.2")},
      {"popcnt", 2, __builtin_cpu_supports("popcnt")},
      {"avx", 3, __builtin_cpu_supports("avx")},
      {"avx2", 3, __builtin_cpu_supports("avx2")},
      {"bmi", 3, __builtin_cpu_supports("bmi")},
      {"bmi2", 3, __builtin_cpu_supports("bmi2")},
      {"f16c", 3, static_cast<int>(bits.basic >> 29 & 1)},
      {"fma", 3, __builtin_cpu_supports("fma")},
      {"lzcnt", 3, static_cast<int>(bits.extended >> 5 & 1)},
      {"movbe", 3, static_cast<int>(bits.basic >> 22 & 1)},
      {"avx512f", 4, __builtin_cpu_supports("avx512f")},
      {"avx512bw", 4, __builtin_cpu_supports("avx512bw")},
      {"avx512cd", 4, __builtin_cpu_supports("avx512cd")},
      {"avx512dq", 4, __builtin_cpu_supports("avx512dq")},
      {"avx512vl", 4, __builtin_cpu_supports("avx512vl")},
      {"avx512ifma", 5, __builtin_cpu_supports("avx512ifma")},
      {"avx512vbmi", 5, __builtin_cpu_supports("avx512vbmi")},
      {"avx512vbmi2", 5, __builtin_cpu_supports("avx512vbmi2")},
      {"avx512vnni", 5, __builtin_cpu_supports("avx512vnni")},
      {"avx512bitalg", 5, __builtin_cpu_supports("avx512bitalg")},
      {"avx512vpopcntdq", 5, __builtin_cpu_supports("avx512vpopcntdq")},
      {"gfni", 5, __builtin_cpu_supports("gfni")},
      {"fma4", 5, __builtin_cpu_supports("fma4")},
      {"xop", 5, __builtin_cpu_supports("xop")},
  };
  const Feature* end = features + sizeof features / sizeof *features;
  for (const Feature* feature = features; feature != end; ++feature) {
    if (feature->there == 0 && Needed(feature->name)) {
      Refuse(argc > 0 ? argv[0] : "metronome", features, end);
    }
  }
}

using Initialiser = void (*)(int, char**, char**);

// The loader calls these of an executable before the constructors of its libraries and its own.
__attribute__((section(".preinit_array"), used)) Initialiser first = RequireProcessor;

}  // namespace
