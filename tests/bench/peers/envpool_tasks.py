"""EnvPool's Meta-World under the names and conditions of the benchmark."""

import envpool

TASK_IDS = {
    "assembly": "MetaWorld/Assembly-v3",
    "bin-picking": "MetaWorld/BinPicking-v3",
    "box-close": "MetaWorld/BoxClose-v3",
    "push": "MetaWorld/Push-v3",
}
HORIZON = 500


def make(task, **options):
    """Goal visible, episodes of 500 steps, a new random placement at every reset."""
    return envpool.make_gymnasium(
        TASK_IDS[task], max_episode_steps=HORIZON, partially_observable=False, **options)
