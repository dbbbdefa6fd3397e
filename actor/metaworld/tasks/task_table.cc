#include "actor/metaworld/tasks/task_table.h"

#include <algorithm>
#include <stdexcept>

#include "common/config/task_names.h"

namespace metronome::metaworld {

// Defined in tasks/NAME.cc.
std::unique_ptr<SawyerEnvironment> MakeAssembly(const TaskSpec&, const EnvironmentOptions&);
std::unique_ptr<SawyerEnvironment> MakeBinPicking(const TaskSpec&, const EnvironmentOptions&);
std::unique_ptr<SawyerEnvironment> MakeBoxClose(const TaskSpec&, const EnvironmentOptions&);
std::unique_ptr<SawyerEnvironment> MakePush(const TaskSpec&, const EnvironmentOptions&);

const std::vector<TaskSpec>& AllTasks() {
  // name, scene, box low (object, goal), box high, least planar distance, factory
  static const std::vector<TaskSpec> tasks = {
      {"assembly",
       "sawyer_xyz/sawyer_assembly_peg.xml",
       {0, 0.6, 0.02, -0.1, 0.75, 0.1},
       {0, 0.6, 0.02, 0.1, 0.85, 0.1},
       0.1,
       MakeAssembly},
      {"bin-picking",
       "sawyer_xyz/sawyer_bin_picking.xml",
       {-0.21, 0.65, 0.02, 0.1199, 0.699, -0.001},
       {-0.03, 0.75, 0.02, 0.1201, 0.701, 0.001},
       0,
       MakeBinPicking},
      {"box-close",
       "sawyer_xyz/sawyer_box.xml",
       {-0.05, 0.5, 0.02, -0.1, 0.7, 0.133},
       {0.05, 0.55, 0.02, 0.1, 0.8, 0.133},
       0.25,
       MakeBoxClose},
      {"push",
       "sawyer_xyz/sawyer_push_v3.xml",
       {-0.1, 0.6, 0.02, -0.1, 0.8, 0.01},
       {0.1, 0.7, 0.02, 0.1, 0.9, 0.02},
       0.15,
       MakePush},
  };
  return tasks;
}

const TaskSpec& FindTask(const std::string& spelling) {
  const std::string name = CanonicalTaskName(spelling);
  const auto& tasks = AllTasks();
  const auto found = std::find_if(tasks.begin(), tasks.end(),
                                  [&name](const TaskSpec& task) { return task.name == name; });
  if (found == tasks.end())
    throw std::logic_error("task " + name + " is named in common/ but has no row in the table");
  return *found;
}

std::unique_ptr<SawyerEnvironment> MakeSawyerEnvironment(const std::string& task,
                                                         const EnvironmentOptions& options) {
  const TaskSpec& spec = FindTask(task);
  return spec.make(spec, options);
}

std::unique_ptr<Environment> MakeEnvironment(const std::string& task,
                                             const EnvironmentOptions& options) {
  return MakeSawyerEnvironment(task, options);
}

}  // namespace metronome::metaworld
