"""The official Meta-World package under the names and conditions of the benchmark."""

import metaworld


def makers(task, seeds):
    """Functions that each make one of MT1's environments, to be called in any process: goal visible,
    episodes of 500 steps. They carry no Gymnasium wrapper, and resets draw a new placement by
    themselves, which is faster than a set_task before each one."""
    name = f"{task}-v3"
    benchmark = metaworld.MT1(name, seed=1)  # takes seconds, so once for all
    return [Maker(benchmark.train_classes[name], benchmark.train_tasks[0], seed) for seed in seeds]


class Maker:
    def __init__(self, environment_class, first_task, seed):
        self.environment_class, self.first_task, self.seed = environment_class, first_task, seed

    def __call__(self):
        environment = self.environment_class()
        environment.set_task(self.first_task)
        environment.seed(self.seed)
        environment._freeze_rand_vec = False
        return environment
