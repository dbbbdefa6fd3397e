"""The official Meta-World package as Stable-Baselines3 steps it: many environments at once."""

import ctypes
import functools
import signal

from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv

import official_tasks


def make(task, envs, vectorisation):
    """vectorisation: dummy (in this process) or subproc (a process each)."""
    makers = official_tasks.makers(task, range(envs))
    if vectorisation == "dummy":
        return DummyVecEnv(makers)
    # Forked, for no thread has started yet: the default would import everything 16 times.
    return SubprocVecEnv([functools.partial(make_in_worker, maker) for maker in makers], start_method="fork")


def make_in_worker(maker):
    """A forked worker holds the others' pipes open and would outlive a main process that is killed."""
    set_parent_death_signal = 1  # prctl(2)
    ctypes.CDLL(None).prctl(set_parent_death_signal, signal.SIGKILL)
    return maker()
