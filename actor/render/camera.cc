#include "actor/render/camera.h"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

#include "common/near_miss.h"

namespace metronome {
namespace {

constexpr const char* kFree = "free";

/// Where a free camera stands: metres and degrees; azimuth 90 looks away from the robot's base.
struct View {
  std::array<double, 3> look_at;
  double distance, azimuth, elevation;
};

const View& ViewOf(const std::string& task) {
  static const View any = {{0, 0.65, 0.1}, 1.15, 150, -25};
  static const std::map<std::string, View> views = {};
  const auto found = views.find(task);
  return found == views.end() ? any : found->second;
}

mjvCamera FreeCamera(const View& view) {
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  camera.type = mjCAMERA_FREE;
  std::copy(view.look_at.begin(), view.look_at.end(), camera.lookat);
  camera.distance = view.distance;
  camera.azimuth = view.azimuth;
  camera.elevation = view.elevation;
  return camera;
}

}  // namespace

std::vector<std::string> CameraNames(const mjModel& model) {
  std::vector<std::string> names = {kFree};
  for (int i = 0; i < model.ncam; ++i) {
    const char* name = mj_id2name(&model, mjOBJ_CAMERA, i);
    if (name != nullptr) names.emplace_back(name);
  }
  return names;
}

mjvCamera FindCamera(const mjModel& model, const std::string& task, const std::string& name) {
  if (name == kFree) return FreeCamera(ViewOf(task));
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  camera.type = mjCAMERA_FIXED;
  camera.fixedcamid = mj_name2id(&model, mjOBJ_CAMERA, name.c_str());
  if (camera.fixedcamid < 0) {
    throw std::invalid_argument(UnknownName("camera", name, CameraNames(model)));
  }
  return camera;
}

}  // namespace metronome
