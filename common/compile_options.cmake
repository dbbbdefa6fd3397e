# How every source is compiled and every program linked; tests/fresh/program is, too.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

set(METRONOME_MARCH "x86-64-v3" CACHE STRING "-march of every source: which processors can run it, not what it computes")
set(METRONOME_SANITIZE "" CACHE STRING "With Clang: address (and undefined behaviour, and fuzzers), or thread")

# No contraction into FMA beyond what is written, so that inlining cannot change a bit.
add_compile_options(-march=${METRONOME_MARCH} -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  add_compile_options(-Wthread-safety)  # common/process/mutex.h
endif()
if(METRONOME_SANITIZE STREQUAL "address")
  add_compile_options(-fsanitize=address,undefined,fuzzer-no-link -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
elseif(METRONOME_SANITIZE STREQUAL "thread")
  add_compile_options(-fsanitize=thread -fno-omit-frame-pointer)
  add_link_options(-fsanitize=thread)
elseif(METRONOME_SANITIZE)
  message(FATAL_ERROR "METRONOME_SANITIZE is address or thread, not '${METRONOME_SANITIZE}'")
endif()

# link_fuzzer(TARGET): its main() is libFuzzer's. Where METRONOME_SANITIZE is address.
function(link_fuzzer target)
  target_link_options(${target} PRIVATE -fsanitize=fuzzer)
endfunction()
