"""The official Meta-World package under the names and conditions of the benchmark."""

import metaworld

TASKS = ("assembly", "bin-picking", "box-close", "push")


def make(task, seed):
    """MT1's environment: goal visible, episodes of 500 steps. It carries no Gymnasium wrapper, and
    resets draw a new placement by themselves, which is faster than a set_task before each one."""
    name = f"{task}-v3"
    benchmark = metaworld.MT1(name, seed=seed)
    environment = benchmark.train_classes[name]()
    environment.set_task(benchmark.train_tasks[0])
    environment.seed(seed)
    environment._freeze_rand_vec = False
    return environment
