"""EnvPool's Meta-World under the names and conditions of the benchmark."""

import envpool

HORIZON = 500


def make(task, **options):
    """Goal visible, episodes of 500 steps, a new random placement at every reset."""
    name = "".join(word.capitalize() for word in task.split("-"))
    return envpool.make_gymnasium(
        f"MetaWorld/{name}-v3", max_episode_steps=HORIZON, partially_observable=False, **options)
