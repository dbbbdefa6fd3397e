#include "actor/metaworld/tasks/tools/stick.h"

namespace metronome::metaworld::tasks::tools {
namespace {

constexpr double kStickHeight = 0.02;  // metres, of a stick on the table
constexpr int kContainerY = 16;        // in qvel: after 9 of the arm and hand, 6 of the stick and x

}  // namespace

Stick::Stick(const TaskSpec& task, const EnvironmentOptions& options, double slide_y,
             double inserted_y)
    : SawyerEnvironment(task, options),
      slide_y_(slide_y),
      inserted_y_(inserted_y),
      stick_(Body("stick")),
      stick_geom_(Geom("objGeom")),
      container_(Body("object")),
      insertion_(Site("insertion")),
      goal_(Site("goal")),
      slides_(Joint("obj_slidex")) {
  Remember("stick_init_pos", &stick_init_);
}

void Stick::PlaceObject(const RandVec& placement) {
  stick_init_ = {placement[0], placement[1], kStickHeight};
  target_ = {placement[3], placement[4], GoalHeight()};
  MoveSite(goal_, target_);
  SetFreeObject(stick_init_);
  SetQpos(slides_, {0, slide_y_});
  Stop(kContainerY, 1);  // the container's x velocity is kept, as official
  Forward();
  object_init_ = BodyPosition(container_);
}

ObjectPose Stick::Object() const { return {BodyPosition(stick_), BodyMatrixQuaternion(stick_)}; }

ObjectPose Stick::SecondObject() const {
  return {.position = HandlePosition() + Eigen::Vector3d(0, inserted_y_, 0)};
}

bool Stick::Grasped(const Observation& observation, double lift, double height) const {
  return Pinched(stick_geom_) && observation[3] > 0 && observation[6] - lift > height;
}

}  // namespace metronome::metaworld::tasks::tools
