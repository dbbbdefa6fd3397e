#include "actor/metaworld/engine/looks.h"

#include <malloc.h>
#include <mujoco/mjxmacro.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace metronome::metaworld::engine {
namespace {

/// Calls visit(array, bytes) for each array of a model, in their order. `array` is the pointer in
/// `model` itself, as char*.
template <class Visit>
void ForEachArray(mjModel& model, const Visit& visit) {
  [[maybe_unused]] const mjModel* m = &model;
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-variable"
  MJMODEL_POINTERS_PREAMBLE(m)
#pragma GCC diagnostic pop
#undef MJ_M
#define MJ_M(n) model.n
#define X(type, name, rows, columns)          \
  visit(reinterpret_cast<char*&>(model.name), \
        sizeof(type) * static_cast<std::size_t>(model.rows) * static_cast<std::size_t>(columns));
  MJMODEL_POINTERS
#undef X
}

/// Bytes up to the next address where MuJoCo lets an array begin.
std::size_t Padding(std::size_t offset) {
  constexpr std::size_t kAlignment = 64;
  return (kAlignment - offset % kAlignment) % kAlignment;
}

std::size_t BufferSize(mjModel& model) {
  std::size_t size = 0;
  ForEachArray(model, [&size](char*&, std::size_t bytes) { size += Padding(size) + bytes; });
  return size;
}

#if mjVERSION_HEADER >= 300
/// Trees of boxes: a body's is searched by the engine's own mj_collision, a mesh's by rays alone.
/// @return how many nodes bodies have, if they come first; else all.
int NodesOfBodies(const mjModel& m) {
  int bodies = 0;
  for (int i = 0; i < m.nbody; ++i) {
    if (m.body_bvhadr[i] >= 0) bodies = std::max(bodies, m.body_bvhadr[i] + m.body_bvhnum[i]);
  }
  const bool first = std::all_of(m.mesh_bvhadr, m.mesh_bvhadr + m.nmesh, [bodies](int address) {
    return address < 0 || address >= bodies;
  });
  return first && m.nbvhdynamic == 0 ? bodies : m.nbvh;
}

void Strip(mjModel& m) {
  m.ntexdata = 0;
  m.nmeshnormal = m.nmeshtexcoord = m.nmeshface = 0;
  m.nmeshpoly = m.nmeshpolyvert = m.nmeshpolymap = 0;
  m.nbvh = m.nbvhstatic = NodesOfBodies(m);
}
#else
void Strip(mjModel& m) { m.ntexdata = m.nmeshtexvert = m.nmeshface = 0; }
#endif

}  // namespace

ModelPtr WithoutLooks(ModelPtr model) {
  if (BufferSize(*model) != static_cast<std::size_t>(model->nbuffer)) return model;
  mjModel slim = *model;
  Strip(slim);
  const std::size_t size = BufferSize(slim);
  slim.nbuffer = static_cast<decltype(slim.nbuffer)>(size);
  slim.buffer = mju_malloc(size);
  std::memset(slim.buffer, 0, size);
  char* next = static_cast<char*>(slim.buffer);
  ForEachArray(slim, [&next](char*& array, std::size_t bytes) {
    next += Padding(reinterpret_cast<std::uintptr_t>(next));
    std::memcpy(next, array, bytes);
    array = next;
    next += bytes;
  });
  auto* own = static_cast<mjModel*>(mju_malloc(sizeof(mjModel)));
  *own = slim;
  model.reset();
  malloc_trim(0);  // compiling the scene took as much again
  return ModelPtr(own);
}

}  // namespace metronome::metaworld::engine
