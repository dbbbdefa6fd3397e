#include "actor/metaworld/tasks/task_table.h"

#include <stdexcept>

#include "actor/metaworld/tasks/buttons/buttons.h"
#include "actor/metaworld/tasks/coffee/coffee.h"
#include "actor/metaworld/tasks/doors/doors.h"
#include "actor/metaworld/tasks/drawers/drawers.h"
#include "actor/metaworld/tasks/handles/handles.h"
#include "actor/metaworld/tasks/knobs/knobs.h"
#include "actor/metaworld/tasks/nuts/nuts.h"
#include "actor/metaworld/tasks/pick_place/pick_place.h"
#include "actor/metaworld/tasks/plates/plates.h"
#include "actor/metaworld/tasks/pushing/pushing.h"
#include "actor/metaworld/tasks/tools/tools.h"
#include "actor/metaworld/tasks/windows/windows.h"
#include "common/text/near_miss.h"

namespace metronome::metaworld::tasks {

const std::vector<TaskSpec>& AllTasks() {
  static const std::vector<TaskSpec> tasks = {
      nuts::AssemblyTask(),
      pick_place::BasketballTask(),
      pick_place::BinPickingTask(),
      pick_place::BoxCloseTask(),
      buttons::ButtonPressTask(),
      buttons::ButtonPressTopdownTask(),
      buttons::ButtonPressTopdownWallTask(),
      buttons::ButtonPressWallTask(),
      coffee::CoffeeButtonTask(),
      coffee::CoffeePullTask(),
      coffee::CoffeePushTask(),
      knobs::DialTurnTask(),
      nuts::DisassembleTask(),
      doors::DoorCloseTask(),
      doors::DoorLockTask(),
      doors::DoorOpenTask(),
      doors::DoorUnlockTask(),
      drawers::DrawerCloseTask(),
      drawers::DrawerOpenTask(),
      knobs::FaucetCloseTask(),
      knobs::FaucetOpenTask(),
      tools::HammerTask(),
      pick_place::HandInsertTask(),
      handles::HandlePressTask(),
      handles::HandlePressSideTask(),
      handles::HandlePullTask(),
      handles::HandlePullSideTask(),
      handles::LeverPullTask(),
      pick_place::PegInsertSideTask(),
      pick_place::PegUnplugSideTask(),
      pick_place::PickOutOfHoleTask(),
      pick_place::PickPlaceTask(),
      pick_place::PickPlaceWallTask(),
      plates::PlateSlideTask(),
      plates::PlateSlideBackTask(),
      plates::PlateSlideBackSideTask(),
      plates::PlateSlideSideTask(),
      pushing::PushTask(),
      pushing::PushBackTask(),
      pushing::PushWallTask(),
      pick_place::ReachTask(),
      pick_place::ReachWallTask(),
      pick_place::ShelfPlaceTask(),
      pushing::SoccerTask(),
      tools::StickPullTask(),
      tools::StickPushTask(),
      pushing::SweepTask(),
      pushing::SweepIntoTask(),
      windows::WindowCloseTask(),
      windows::WindowOpenTask(),
  };
  return tasks;
}

const TaskSpec& FindTask(const std::string& spelling) {
  std::string name = spelling;
  if (name.ends_with("-v2") || name.ends_with("-v3")) name.resize(name.size() - 3);
  std::vector<std::string> names;
  for (const TaskSpec& task : AllTasks()) {
    if (task.name == name) return task;
    names.push_back(task.name);
  }
  throw std::invalid_argument(
      text::UnknownName("task", spelling, names, text::NearMiss(name, names)));
}

std::unique_ptr<SawyerEnvironment> MakeSawyerEnvironment(const std::string& task,
                                                         const EnvironmentOptions& options) {
  const TaskSpec& spec = FindTask(task);
  return spec.make(spec, options);
}

}  // namespace metronome::metaworld::tasks
