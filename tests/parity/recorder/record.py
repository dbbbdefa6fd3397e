"""Records an episode of the official Meta-World package, in the format of tests/fixtures/recordings.

A recording is CSV: a line "# " with a JSON object (how the episode began: placement, goal, state, bodies and sites that
were moved, what the environment remembers), a line of column names, and a row a step: the state after it, the action,
observation, reward and info, and qacc_warmstart. Numbers read back as the same bits.
"""

import argparse
import gzip
import importlib.metadata
import json
import os
import platform
import warnings
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
warnings.filterwarnings("ignore")

import metaworld  # noqa: E402
import mujoco  # noqa: E402
import numpy as np  # noqa: E402
from metaworld.policies import ENV_POLICY_MAP  # noqa: E402

RECORDINGS = Path(__file__).resolve().parents[2] / "fixtures" / "recordings"
INFO = ("success", "near_object", "grasp_success", "grasp_reward", "in_place_reward", "obj_to_target", "unscaled_reward")
# Attributes of an environment that say nothing of the episode.
NOT_REMEMBERED = {
    "width", "height", "camera_id", "frame_skip", "init_qpos", "init_qvel", "goal_space", "num_resets", "current_seed",
    "curr_path_length", "goal", "active_discrete_goal", "discrete_goal_space", "seeded_rand_vec", "action_rot_scale",
    "_did_see_sim_exception", "_freeze_rand_vec", "_partially_observable", "_set_task_called", "_prev_obs",
    "_last_stable_obs", "_last_rand_vec", "_obs_obj_max_len", "init_left_pad", "init_right_pad",
}


def numbers(array):
    return [float(x) for x in np.asarray(array, dtype=np.float64).ravel()]


def environment_of(task, seed):
    """An environment on placement `seed` mod 50 of the official MT1 benchmark of that seed, goal visible."""
    benchmark = metaworld.MT1(task, seed=seed)
    environment = benchmark.train_classes[task]()
    environment.set_task(benchmark.train_tasks[seed % 50])
    return environment


def policy_of(name, task, seed, constant):
    """A function from observation to action, which is float32 as policies' actions are."""
    rng = np.random.default_rng(1_000_003 * (seed + 1))
    if name == "random":
        return lambda observation: rng.uniform(-1, 1, 4).astype(np.float32)
    if name == "const":
        return lambda observation: np.array(constant, np.float32)
    scripted = ENV_POLICY_MAP[task]()

    def act(observation):  # with noise, so that each seed moves otherwise; values beyond 1 are for the environment
        action = np.asarray(scripted.get_action(observation), dtype=np.float64)
        action[:3] = action[:3] + rng.normal(0, 0.1, 3)
        action[3] = action[3] + rng.normal(0, 0.02)
        return action.astype(np.float32)

    return act


def remembered(environment):
    """The task's memory of the reset: each number and small array among its attributes."""
    found = {}
    for name, value in sorted(vars(environment).items()):
        if name in NOT_REMEMBERED or isinstance(value, str):
            continue
        if isinstance(value, (bool, int, float, np.number, np.bool_)):
            found[name] = float(value)
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and 0 < value.ndim and value.size <= 16:
            found[name] = numbers(value)
    return found


def moved(kind, model, array, compiled):
    """{name: position} of the bodies or sites that are not where the scene file has them."""
    return {mujoco.mj_id2name(model, kind, i): numbers(array[i])
            for i in range(len(array)) if not np.array_equal(array[i], compiled[i])}


def header_of(environment, observation, arguments):
    model, data = environment.model, environment.data
    compiled = mujoco.MjModel.from_xml_path(environment.fullpath)
    versions = {name: importlib.metadata.version(name) for name in ("metaworld", "mujoco", "gymnasium", "numpy", "scipy")}
    return {
        "task": arguments.task, "seed": arguments.seed, "policy": arguments.policy,
        "const": arguments.const if arguments.policy == "const" else None,
        "goal_index": arguments.seed % 50, "steps": arguments.steps, "action_dtype": "float32",
        "rand_vec": numbers(environment._last_rand_vec), "goal": numbers(environment._target_pos),
        "partially_observable": bool(environment._partially_observable), "init_obs": numbers(observation),
        "init_qpos": numbers(data.qpos), "init_qvel": numbers(data.qvel), "init_mocap_pos": numbers(data.mocap_pos),
        "init_mocap_quat": numbers(data.mocap_quat), "init_ctrl": numbers(data.ctrl),
        "init_qacc_warmstart": numbers(data.qacc_warmstart), "init_time": float(data.time),
        "xml": os.path.relpath(environment.fullpath, os.path.dirname(metaworld.__file__)),
        "nq": model.nq, "nv": model.nv, "nu": model.nu, "frame_skip": environment.frame_skip,
        "timestep": model.opt.timestep, "eq_data": numbers(model.eq_data),
        "model_body_pos_changed": moved(mujoco.mjtObj.mjOBJ_BODY, model, model.body_pos, compiled.body_pos),
        "model_site_pos_changed": moved(mujoco.mjtObj.mjOBJ_SITE, model, model.site_pos, compiled.site_pos),
        "internals_after_reset": remembered(environment),
        "versions": versions | {"python": platform.python_version(), "machine": platform.machine()},
    }


def row_of(step, environment, action, observation, reward, truncated, info):
    data = environment.data
    row = [*numbers(data.qpos), *numbers(data.qvel), *numbers(data.mocap_pos), *numbers(data.mocap_quat),
           *numbers(data.ctrl), *numbers(action), *numbers(observation), float(reward),
           *(float(info[name]) for name in INFO), float(truncated), *numbers(environment.tcp_center),
           *numbers(data.qacc_warmstart)]
    return f"{step}," + ",".join(map(repr, row))


def action_alone(row, model):
    """The row with nothing but step and action."""
    before = 1 + model.nq + model.nv + 3 + 4 + model.nu
    cells = row.split(",")
    return ",".join(cell if i == 0 or before <= i < before + 4 else "" for i, cell in enumerate(cells))


def columns_of(model):
    counts = (("qpos", model.nq), ("qvel", model.nv), ("mocap_pos", 3), ("mocap_quat", 4), ("ctrl", model.nu),
              ("action", 4), ("obs", 39))
    names = [f"{name}{i}" for name, count in counts for i in range(count)]
    tail = [f"{name}{i}" for name, count in (("tcp", 3), ("warm", model.nv)) for i in range(count)]
    return ",".join(["step", *names, "reward", *INFO, "truncated", *tail])


def recording_of(arguments):
    environment = environment_of(arguments.task, arguments.seed)
    act = policy_of(arguments.policy, arguments.task, arguments.seed, arguments.const)
    observation, _ = environment.reset()
    lines = ["# " + json.dumps(header_of(environment, observation, arguments), allow_nan=False),
             columns_of(environment.model)]
    for step in range(1, arguments.steps + 1):
        action = act(observation)
        observation, reward, _, truncated, info = environment.step(action)
        row = row_of(step, environment, action, observation, reward, truncated, info)
        whole = step % arguments.every == 0 or step in (1, arguments.steps)
        lines.append(row if whole else action_alone(row, environment.model))
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(prog="tests/parity/record", description=__doc__.partition("\n")[0])
    parser.add_argument("--task", required=True, choices=sorted(metaworld.MT1.ENV_NAMES), metavar="NAME-v3")
    parser.add_argument("--seed", type=int, default=0, help="of placement and actions (default 0)")
    parser.add_argument("--policy", choices=("random", "expert", "const"), default="expert",
                        help="expert: the package's scripted policy, with noise (default)")
    parser.add_argument("--const", type=float, nargs=4, default=[0.0] * 4, metavar="X", help="the action of const")
    parser.add_argument("--steps", type=int, default=150, help="1 to 500 (default 150)")
    parser.add_argument("--every", type=int, default=1, metavar="N",
                        help="whole rows of the first, the last and each Nth step, of the others the action alone; for small "
                        "files (default 1: all)")
    parser.add_argument("--out", type=Path, default=RECORDINGS, metavar="DIR", help="default: tests/fixtures/recordings")
    arguments = parser.parse_args()
    if not 1 <= arguments.steps <= 500:
        parser.error(f"--steps {arguments.steps}: must be 1 to 500")
    if arguments.every < 1:
        parser.error(f"--every {arguments.every}: must be at least 1")
    path = arguments.out / f"{arguments.task}_s{arguments.seed}_{arguments.policy}.csv.gz"
    path.write_bytes(gzip.compress(recording_of(arguments).encode(), 9, mtime=0))  # the same bytes each time
    print(path)


if __name__ == "__main__":
    main()
