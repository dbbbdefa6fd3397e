#include "actor/render/scene_renderer.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "actor/metaworld/engine/looks.h"

namespace metronome::render {
namespace {

constexpr int kShadowMap = 2048;  // pixels a side; half a frame's time goes into it even so
constexpr int kSamples = 4;       // a pixel, against jagged edges
constexpr int kSlices = 16;       // of a round thing; a path has hundreds of them
constexpr int kStacks = 8;

/// MuJoCo's fonts come in steps of 50 %; 100 % suits images 480 pixels high.
int FontScale(const ImageSize& size) {
  return std::clamp(static_cast<int>(std::lround(size.height / 240.0)) * 50,
                    static_cast<int>(mjFONTSCALE_50), static_cast<int>(mjFONTSCALE_300));
}

/// The scenes' sites mark places for the code; only a goal is there to be seen.
void HideSites(mjModel& model) {
  for (int site = 0; site < model.nsite; ++site) {
    const char* name = mj_id2name(&model, mjOBJ_SITE, site);
    if (name == nullptr || std::string_view(name) != "goal") model.site_rgba[4 * site + 3] = 0;
  }
}

/// Fades the parts that hang on the robot's base and move.
void FadeArm(mjModel& model, double opacity) {
  const int hand = mj_name2id(&model, mjOBJ_BODY, "hand");
  for (int geom = 0; hand >= 0 && geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    const bool of_arm =
        model.body_rootid[body] == model.body_rootid[hand] && model.body_weldid[body] != 0;
    if (of_arm) model.geom_rgba[4 * geom + 3] *= static_cast<float>(opacity);
  }
}

metaworld::engine::ModelPtr ModelToDraw(const mjModel& model, const ImageSize& size,
                                        double arm_opacity) {
  metaworld::engine::ModelPtr copy = metaworld::engine::CopyToDraw(model);
  copy->vis.global.offwidth = size.width;
  copy->vis.global.offheight = size.height;
  copy->vis.quality.shadowsize = kShadowMap;
  copy->vis.quality.offsamples = kSamples;
  copy->vis.quality.numslices = kSlices;
  copy->vis.quality.numstacks = kStacks;
  HideSites(*copy);
  FadeArm(*copy, arm_opacity);
  return copy;
}

}  // namespace

SceneRenderer::SceneRenderer(const mjModel& model, const mjvCamera& camera, ImageSize size,
                             std::size_t extra, double arm_opacity)
    : size_(size),
      model_(ModelToDraw(model, size, arm_opacity)),
      data_(mj_makeData(model_.get())),
      camera_(camera) {
  mjv_defaultOption(&option_);
  mjv_defaultScene(&scene_);
  mjr_defaultContext(&context_);
  mjv_makeScene(model_.get(), &scene_,
                2 * (model_->ngeom + model_->nsite) + static_cast<int>(extra));
  mjr_makeContext(model_.get(), &context_, FontScale(size));
  mjr_setBuffer(mjFB_OFFSCREEN, &context_);
}

SceneRenderer::~SceneRenderer() {
  mjr_freeContext(&context_);
  mjv_freeScene(&scene_);
}

// The episode's own mjData lacks the poses of what is only seen (ControlStepper leaves them out).
void SceneRenderer::Place(const Pose& pose) {
  std::copy(pose.qpos.begin(), pose.qpos.end(), data_->qpos);
  std::copy(pose.mocap_pos.begin(), pose.mocap_pos.end(), data_->mocap_pos);
  std::copy(pose.mocap_quat.begin(), pose.mocap_quat.end(), data_->mocap_quat);
  mj_kinematics(model_.get(), data_.get());
  mj_comPos(model_.get(), data_.get());
  mj_camlight(model_.get(), data_.get());
}

void SceneRenderer::Draw(const Pose& pose, const std::vector<mjvGeom>& geoms, const mjrRect& part) {
  Place(pose);
  mjv_updateScene(model_.get(), data_.get(), &option_, nullptr, &camera_, mjCAT_ALL, &scene_);
  for (const mjvGeom& geom : geoms) {
    if (scene_.ngeom < scene_.maxgeom) scene_.geoms[scene_.ngeom++] = geom;
  }
  mjr_render(part, &scene_, &context_);
}

Image SceneRenderer::Read() const {
  const auto row = static_cast<std::size_t>(size_.width) * 3;
  const auto rows = static_cast<std::size_t>(size_.height);
  std::vector<std::uint8_t> upside_down(row * rows);
  mjr_readPixels(upside_down.data(), nullptr, {0, 0, size_.width, size_.height}, &context_);
  Image image{size_, std::vector<std::uint8_t>(row * rows)};
  for (std::size_t y = 0; y < rows; ++y) {
    std::copy_n(upside_down.begin() + static_cast<std::ptrdiff_t>(row * (rows - 1 - y)), row,
                image.rgb.begin() + static_cast<std::ptrdiff_t>(row * y));
  }
  return image;
}

}  // namespace metronome::render
