#pragma once

/// What Highway compiles the kernels for: include it before any header of Highway. One target for
/// each Isa; those between would add code, not speed.
#define HWY_COMPILE_ALL_ATTAINABLE
#define HWY_BROKEN_EMU128 1  // "scalar" is the same target by every compiler
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
