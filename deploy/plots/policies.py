"""The skill figure and a video of each committed policy, drawn by `metronome-actor render`."""

from pathlib import Path

import children

# Placements that no training run draws; the same ones as the experiments' evaluations.
SEED, EPISODE = 1000, 1
NAMES = tuple(f"skill-{path.stem}" for path in sorted(
    (Path(__file__).resolve().parents[2] / "results" / "policies").glob("*.ckpt")))


class RenderError(Exception):
    """A policy cannot be drawn; the message is the program's own."""


def found(results):
    """Task to checkpoint of the committed policies."""
    there = {path.stem: path for path in (results / "policies").glob("*.ckpt")}
    return {task: there[task] for task in sorted(there)}


def renderer(root):
    """The program that draws, None where it is not built. That of the default engine alone: on another
    one the same policy moves otherwise, and the page quotes the policies on this one."""
    program = root / "build" / "bin" / "metronome-actor"
    return program if program.exists() else None


def render(program, checkpoint, target):
    """Makes the picture or video `target`. @return what the program said of the episode, its first line."""
    done = children.said_by([str(program), "render", "--checkpoint", str(checkpoint), "--seed", str(SEED),
                             "--episode", str(EPISODE), "--out", str(target)])
    if done.returncode != 0:
        raise RenderError(f"{Path(checkpoint).name}: {done.stderr.strip()}")
    return done.stdout.splitlines()[0]


def caption(said):
    return ("One episode of the committed policy under its mean action: the hand's path, coloured by the head that "
            f"acts; a ball where each begins. {said[0].upper()}{said[1:]}.")
