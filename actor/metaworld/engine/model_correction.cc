#include "actor/metaworld/engine/model_correction.h"

#if mjVERSION_HEADER < 300

#include <algorithm>
#include <array>

namespace metronome::metaworld::engine {
namespace {

/// A body on two slides, as 3.3.0 compiles it. Weights are of translation: it cannot turn.
struct SlidingBody {
  const char* joint;                 // its first slide
  double inverse_weight;             // of the body
  double inverse_weight_of_slide;    // 1 / m: 2.2.2 adds the joint's armature to m
  double mass;                       // kg
  std::array<double, 3> inertia;     // kg m^2
  std::array<double, 3> centre;      // of mass, metres
  std::array<double, 4> quaternion;  // of the inertia's axes
};

const SlidingBody kContainer = {
    "obj_slidex",
    0.20394823014997854,
    0.3059223452249678,
    3.2678033927846117,  // of a mesh, whose volume 2.2.2 reckons 2 % larger
    {0.028694296582596274, 0.027937440081530672, 0.006279562875314232},
    {4.2704476970395624e-11, -0.002005016651098468, 0.14315477820664746},
    {0.9999985765113587, -0.0016872982120468359, 0, 0}};

const SlidingBody kPlate = {"goal_slidex",
                            20,
                            20,
                            0.05,
                            {4.5416666666666675e-05, 4.5416666666666675e-05, 8.333333333333336e-05},
                            {0, 0, 0},
                            {1, 0, 0, 0}};

void Correct(const SlidingBody& as, mjModel& m) {
  const int joint = mj_name2id(&m, mjOBJ_JOINT, as.joint);
  const int body = m.jnt_bodyid[joint];
  const double more_mass = as.mass - m.body_mass[body];
  for (int of = body; of != 0; of = m.body_parentid[of]) m.body_subtreemass[of] += more_mass;
  m.body_subtreemass[0] += more_mass;
  m.body_mass[body] = as.mass;
  std::copy(as.inertia.begin(), as.inertia.end(), m.body_inertia + 3 * body);
  std::copy(as.centre.begin(), as.centre.end(), m.body_ipos + 3 * body);
  std::copy(as.quaternion.begin(), as.quaternion.end(), m.body_iquat + 4 * body);
  m.body_invweight0[2 * body] = as.inverse_weight;
  std::fill_n(m.dof_invweight0 + m.jnt_dofadr[joint], 2, as.inverse_weight_of_slide);
}

/// 2.2.2 turns the frame of the mug, which is only seen, and whose rotation is observed.
void CorrectMug(mjModel& m) {
  constexpr std::array<double, 4> kUpright = {1, 0, 0, 0};
  const int mug = mj_name2id(&m, mjOBJ_GEOM, "mug");
  std::copy(kUpright.begin(), kUpright.end(), m.geom_quat + 4 * mug);
}

}  // namespace

void CorrectModel(const std::string& scene, mjModel& model) {
  if (scene == "sawyer_xyz/sawyer_stick_obj.xml") Correct(kContainer, model);
  if (scene == "sawyer_xyz/sawyer_plate_slide.xml") Correct(kPlate, model);
  if (scene == "sawyer_xyz/sawyer_plate_slide_sideway.xml") Correct(kPlate, model);
  if (scene == "sawyer_xyz/sawyer_coffee.xml") CorrectMug(model);
}

}  // namespace metronome::metaworld::engine

#else

namespace metronome::metaworld::engine {

void CorrectModel(const std::string& /*scene*/, mjModel& /*model*/) {}

}  // namespace metronome::metaworld::engine

#endif
