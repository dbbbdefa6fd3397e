#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstdint>
#include <vector>

#include "actor/metaworld/engine/geom_bounds.h"
#include "actor/metaworld/engine/geom_travel.h"

namespace metronome::metaworld::engine {

/// mj_collision with another search for the pairs that may touch; contacts are the same to the bit.
///
/// The engine sorts all bodies along an axis at every call, then compares bounding spheres (2.2.2)
/// or trees of boxes (3.3.0). These scenes have some fifty candidate pairs, known beforehand, most
/// of them far apart: they are tested here one by one (geom_bounds.h), each again only once its
/// geoms have moved as far as they were apart, or at all (geom_travel.h), and the engine's own
/// collision functions see what is left. Not thread-safe; one per environment.
class CollisionPairs {
 public:
  /// @param model  must outlive this. Body and site positions may change later, geoms may not.
  /// @throws std::logic_error if the model has what is not known here: predefined pairs,
  ///         exclusions, priorities, height fields, flexes.
  explicit CollisionPairs(const mjModel& model);

  /// As mj_collision(model, data), after the same kinematics.
  void Collide(mjData& data);

 private:
  /// Two geoms and the contact parameters that the engine makes of theirs, equal for all their
  /// contacts.
  struct Candidate {
    int geom1 = 0, geom2 = 0;  // that of the lower type first
    mjfCollision function = nullptr;
    bool boxes = false;          // both are boxes
    mjtNum margin = 0, gap = 0;  // metres
    int dim = 0;
    std::array<mjtNum, 5> friction{};
    std::array<mjtNum, mjNREF> solref{};
    std::array<mjtNum, mjNIMP> solimp{};
  };

  /// What is looked at each time of each candidate, apart from the rest for the cache's sake.
  struct Wait {
    int geom1 = 0, geom2 = 0;
    mjtNum travel = 0;        // of both together, metres; they are surely apart before
    std::int64_t moves = -1;  // of both together at which they had no contact
  };

  static Candidate MakeCandidate(const mjModel& model, int geom1, int geom2);
  void AddCandidates(int body1, int body2);
  /// @return whether they touch.
  bool CollidePair(const Candidate& pair, mjData& data);

  const mjModel& model_;
  const GeomBounds bounds_;
  std::vector<Candidate> candidates_;  // in the engine's order
  std::vector<Wait> waits_;            // of the candidates
  GeomTravel travel_;
  std::array<mjContact, mjMAXCONPAIR> contacts_{};  // scratch
};

}  // namespace metronome::metaworld::engine
