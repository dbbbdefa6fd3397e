#include "actor/metaworld/engine/collision_pairs.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace metronome::metaworld::engine {
namespace {

bool MayCollide(const mjModel& m, int geom1, int geom2) {
  const auto [type1, type2] = std::minmax(m.geom_type[geom1], m.geom_type[geom2]);
  if (mjCOLLISIONFUNC[type1][type2] == nullptr) return false;  // two planes
  return (m.geom_contype[geom1] & m.geom_conaffinity[geom2]) != 0 ||
         (m.geom_contype[geom2] & m.geom_conaffinity[geom1]) != 0;
}

// The engine's filter of bodies: nothing collides with what it is welded to, nor with its parent
// (the world, as a parent, does collide).
bool MayCollideBodies(const mjModel& m, int body1, int body2) {
  const int weld1 = m.body_weldid[body1], weld2 = m.body_weldid[body2];
  if (weld1 == weld2) return false;
  if (weld1 == 0 || weld2 == 0) return true;
  return weld1 != m.body_weldid[m.body_parentid[weld2]] &&
         weld2 != m.body_weldid[m.body_parentid[weld1]];
}

#if mjVERSION_HEADER >= 300
void ClearContacts(mjData& d) {
  d.ncon = 0;
  d.parena = 0;  // contacts are what the arena begins with
}

// 3.x knows more of a contact: contacts of flexes, and references of their own for friction.
void SetGeoms(int geom1, int geom2, mjContact& contact) {
  contact.geom1 = contact.geom[0] = geom1;
  contact.geom2 = contact.geom[1] = geom2;
  for (int i = 0; i < 2; ++i) contact.flex[i] = contact.elem[i] = contact.vert[i] = -1;
  std::fill_n(contact.solreffriction, mjNREF, 0.0);
}

enum class Place { kInside, kNear, kOutside };

/// Where a point lies to a box that `margin` is added to: inside or outside by more than a
/// hundredth of its size, or neither.
Place PlaceOf(const mjModel& m, const mjData& d, int box, mjtNum margin, const mjtNum* point) {
  constexpr mjtNum kRatio = 1.01;
  const mjtNum* axes = d.geom_xmat + 9 * box;
  const mjtNum* centre = d.geom_xpos + 3 * box;
  const mjtNum v[3] = {point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]};
  Place place = Place::kInside;
  for (int i = 0; i < 3; ++i) {
    const mjtNum along = std::abs(axes[i] * v[0] + axes[3 + i] * v[1] + axes[6 + i] * v[2]);
    const mjtNum half = m.geom_size[3 * box + i] + margin;
    if (along > half * kRatio) return Place::kOutside;
    if (along >= half / kRatio) place = Place::kNear;
  }
  return place;
}

/// 3.x drops what two boxes say of a place outside one and not inside the other.
bool Misplaced(const mjModel& m, const mjData& d, int box1, int box2, mjtNum margin,
               const mjContact& contact) {
  const Place place1 = PlaceOf(m, d, box1, margin, contact.pos);
  const Place place2 = PlaceOf(m, d, box2, margin, contact.pos);
  return (place1 == Place::kOutside && place2 != Place::kInside) ||
         (place2 == Place::kOutside && place1 != Place::kInside);
}
#else
void ClearContacts(mjData& d) { d.ncon = 0; }

void SetGeoms(int geom1, int geom2, mjContact& contact) {
  contact.geom1 = geom1;
  contact.geom2 = geom2;
}

// 2.2.2 takes all contacts of boxes, but for repetitions.
bool Misplaced(const mjModel&, const mjData&, int, int, mjtNum, const mjContact&) { return false; }
#endif

/// Two boxes may name a place twice: only the last of equal ones counts. @return how many are left.
int DropRepeated(mjContact* contacts, int count) {
  int kept = 0;
  for (int i = 0; i < count; ++i) {
    bool repeated = false;
    for (int j = i + 1; j < count && !repeated; ++j) {
      repeated = std::equal(contacts[i].pos, contacts[i].pos + 3, contacts[j].pos);
    }
    if (repeated) continue;
    if (kept < i) contacts[kept] = contacts[i];
    ++kept;
  }
  return kept;
}

/// Makes an orthonormal basis of a contact's normal and a tangent, if the collision function gave
/// one; else of a coordinate axis well away from the normal. Rows are the axes.
void CompleteFrame(mjtNum* frame) {
  mjtNum *normal = frame, *tangent = frame + 3;
  if (mju_normalize3(normal) < 0.5) mju_error("normal of a contact is undefined");
  if (mju_norm3(tangent) < 0.5) {
    const bool along_y = std::abs(normal[1]) < 0.5;
    std::fill_n(tangent, 3, 0.0);
    tangent[along_y ? 1 : 2] = 1;
  }
  mjtNum parallel[3];
  mju_scl3(parallel, normal, mju_dot3(normal, tangent));
  mju_subFrom3(tangent, parallel);
  mju_normalize3(tangent);
  mju_cross(frame + 6, normal, tangent);
}

/// Whether the engine sorts the contacts of two bodies by geoms: 3.x does where it searches trees.
bool SortsContacts([[maybe_unused]] const mjModel& m, [[maybe_unused]] int body1,
                   [[maybe_unused]] int body2) {
#if mjVERSION_HEADER < 300
  return false;
#else
  return m.body_geomnum[body1] > 1 || m.body_geomnum[body2] > 1;
#endif
}

void CheckScene(const mjModel& m) {
  bool plain = m.npair == 0 && m.nexclude == 0 && m.nhfield == 0;
  for (int geom = 0; geom < m.ngeom; ++geom) {
    plain = plain && m.geom_priority[geom] == 0 && m.geom_solref[mjNREF * geom] > 0 &&
            m.geom_solmix[geom] >= mjMINVAL;
  }
#if mjVERSION_HEADER >= 300
  plain = plain && m.nflex == 0;
#endif
  if (!plain || (m.opt.enableflags & mjENBL_OVERRIDE) != 0) {
    throw std::logic_error(
        "the scene has collision settings that CollisionPairs does not know: predefined pairs, "
        "exclusions, priorities, direct solver references, overrides, height fields or flexes");
  }
}

}  // namespace

CollisionPairs::CollisionPairs(const mjModel& model)
    : model_(model), bounds_(model), travel_(model) {
  CheckScene(model);
  for (int body1 = 0; body1 < model.nbody; ++body1) {
    for (int body2 = body1 + 1; body2 < model.nbody; ++body2) AddCandidates(body1, body2);
  }
  for (const Candidate& pair : candidates_) {
    waits_.push_back({pair.geom1, pair.geom2});
    travel_.Follow(pair.geom1);
    travel_.Follow(pair.geom2);
  }
}

void CollisionPairs::AddCandidates(int body1, int body2) {
  const mjModel& m = model_;
  if (!MayCollideBodies(m, body1, body2)) return;
  const auto first = static_cast<std::ptrdiff_t>(candidates_.size());
  for (int i = 0; i < m.body_geomnum[body1]; ++i) {
    for (int j = 0; j < m.body_geomnum[body2]; ++j) {
      const int geom1 = m.body_geomadr[body1] + i, geom2 = m.body_geomadr[body2] + j;
      if (MayCollide(m, geom1, geom2)) candidates_.push_back(MakeCandidate(m, geom1, geom2));
    }
  }
  if (!SortsContacts(m, body1, body2)) return;
  std::sort(candidates_.begin() + first, candidates_.end(),
            [](const Candidate& a, const Candidate& b) {
              return std::pair(a.geom1, a.geom2) < std::pair(b.geom1, b.geom2);
            });
}

CollisionPairs::Candidate CollisionPairs::MakeCandidate(const mjModel& m, int geom1, int geom2) {
  if (m.geom_type[geom1] > m.geom_type[geom2]) std::swap(geom1, geom2);
  const int type1 = m.geom_type[geom1], type2 = m.geom_type[geom2];
  Candidate pair;
  pair.geom1 = geom1;
  pair.geom2 = geom2;
  pair.function = mjCOLLISIONFUNC[type1][type2];
  pair.boxes = type1 == mjGEOM_BOX && type2 == mjGEOM_BOX;
  pair.margin = std::max(m.geom_margin[geom1], m.geom_margin[geom2]);
  pair.gap = std::max(m.geom_gap[geom1], m.geom_gap[geom2]);
  pair.dim = std::max(m.geom_condim[geom1], m.geom_condim[geom2]);
  constexpr std::array<int, 5> kKind = {0, 0, 1, 2, 2};  // sliding, torsional, rolling
  for (std::size_t i = 0; i < kKind.size(); ++i) {
    pair.friction[i] = std::max(
        {mjMINMU, m.geom_friction[3 * geom1 + kKind[i]], m.geom_friction[3 * geom2 + kKind[i]]});
  }
  const mjtNum mix1 = m.geom_solmix[geom1], mix2 = m.geom_solmix[geom2];
  const mjtNum mix = mix1 / (mix1 + mix2);
  for (int i = 0; i < mjNREF; ++i) {
    pair.solref[i] =
        mix * m.geom_solref[mjNREF * geom1 + i] + (1 - mix) * m.geom_solref[mjNREF * geom2 + i];
  }
  for (int i = 0; i < mjNIMP; ++i) {
    pair.solimp[i] =
        mix * m.geom_solimp[mjNIMP * geom1 + i] + (1 - mix) * m.geom_solimp[mjNIMP * geom2 + i];
  }
  return pair;
}

void CollisionPairs::Collide(mjData& data) {
  ClearContacts(data);
  if (!travel_.Add(data)) {
    for (Wait& wait : waits_) wait.travel = 0;
  }
  for (std::size_t i = 0; i < waits_.size(); ++i) {
    Wait& wait = waits_[i];
    const mjtNum travel = travel_.Of(wait.geom1) + travel_.Of(wait.geom2);
    const std::int64_t moves = travel_.Moves(wait.geom1) + travel_.Moves(wait.geom2);
    if (travel < wait.travel || moves == wait.moves) continue;
    const Candidate& pair = candidates_[i];
    const mjtNum clearance = bounds_.Clearance(data, pair.geom1, pair.geom2, pair.margin);
    const bool touch = clearance <= 0 && CollidePair(pair, data);
    wait.travel = travel + clearance;
    wait.moves = touch ? -1 : moves;
  }
}

bool CollisionPairs::CollidePair(const Candidate& pair, mjData& data) {
  mjContact* contacts = contacts_.data();
  int count = pair.function(&model_, &data, contacts, pair.geom1, pair.geom2, pair.margin);
  if (pair.boxes) {
    const auto end = std::remove_if(contacts, contacts + count, [&](const mjContact& contact) {
      return Misplaced(model_, data, pair.geom1, pair.geom2, pair.margin, contact);
    });
    count = DropRepeated(contacts, static_cast<int>(end - contacts));
  }
  for (int i = 0; i < count; ++i) {
    mjContact& contact = contacts[i];
    SetGeoms(pair.geom1, pair.geom2, contact);
    contact.dim = pair.dim;
    contact.includemargin = pair.margin - pair.gap;
    contact.exclude = contact.dist < contact.includemargin ? 0 : 1;
    std::copy(pair.friction.begin(), pair.friction.end(), contact.friction);
    std::copy(pair.solref.begin(), pair.solref.end(), contact.solref);
    std::copy(pair.solimp.begin(), pair.solimp.end(), contact.solimp);
    CompleteFrame(contact.frame);
    contact.efc_address = -1;
    contact.mu = 0;
    std::fill(std::begin(contact.H), std::end(contact.H), 0.0);
    if (mj_addContact(&model_, &data, &contact) != 0) break;  // full: the engine has warned
  }
  return count > 0;
}

}  // namespace metronome::metaworld::engine
