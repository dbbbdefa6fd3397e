"""Facts that all runs of an experiment share, asked once from the programs, git and the machine."""

import re
import shlex
import subprocess
from dataclasses import dataclass
from pathlib import Path

import matrix


class SettingsError(Exception):
    """A cell's settings are wrong, or something that is needed cannot be asked."""


@dataclass(frozen=True)
class Settings:
    root: Path
    build: Path
    mujoco: str
    milestones: int
    evaluation: matrix.Evaluation
    revision: str  # of the sources; ends in -dirty where they differ from it
    processor: str
    steps_per_update: dict  # cell to E * T

    def command_of(self, cell):
        """The command that makes the same run by hand."""
        return shlex.join(["deploy/train", *cell.train_arguments(), "--mujoco", self.mujoco])

    def evaluation_facts(self, cell):
        """When and how the cell is evaluated, as runs.jsonl says it."""
        return {"evaluation_seed": self.evaluation.seed, "evaluation_episodes": self.evaluation.episodes,
                "evaluation_placements": sorted(self.evaluation.placements),
                "milestone_every": self.milestone_every(cell)}

    def updates_of(self, cell):
        return -(-cell.steps // self.steps_per_update[cell])

    def milestone_every(self, cell):
        return max(1, self.updates_of(cell) // self.milestones)

    def milestones_of(self, cell):
        """Updates that are evaluated: the last one takes the place of one that lies close before it."""
        every, last = self.milestone_every(cell), self.updates_of(cell)
        return [*range(every, last - every + 1, every), last]


def _git(root, *words):
    done = subprocess.run(["git", "-C", str(root), *words], capture_output=True, text=True, errors="surrogateescape")
    if done.returncode != 0:
        raise SettingsError(f"git {words[0]} failed, and results name their revision: "
                            + done.stderr.strip())
    return done.stdout.strip()


def _revision(root):
    changed = _git(root, "status", "--porcelain", "--", ".", ":!results")
    return _git(root, "rev-parse", "HEAD") + ("-dirty" if changed else "")


def _processor():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return "unknown"


def _steps_per_update(build, cell):
    """Also the check that the cell's settings are right, before anything starts."""
    learner = str(build / "bin" / "metronome-learner")
    words = cell.train_arguments()
    done = subprocess.run([learner, "config", "--task", words[0], *words[1:]],
                          capture_output=True, text=True, errors="surrogateescape")
    if done.returncode != 0:
        raise SettingsError(f"{cell.name}: {done.stderr.strip()}")
    numbers = [re.search(rf"^\s*{name}: (\d+)$", done.stdout, re.M)
               for name in ("horizon", "episodes_per_update")]
    return int(numbers[0].group(1)) * int(numbers[1].group(1))


def make_settings(root, build, experiment, cells):
    """@throws SettingsError."""
    if not (build / "bin" / "metronome-learner").exists():
        raise SettingsError(f"there is no {build}/bin/metronome-learner")
    return Settings(
        root=root, build=build, mujoco=experiment.mujoco, milestones=experiment.milestones,
        evaluation=experiment.evaluation, revision=_revision(root), processor=_processor(),
        steps_per_update={cell: _steps_per_update(build, cell) for cell in cells})
