"""The programs of an engine."""

import sys

import children
from options import ROOT


def set_up(mujoco):
    """Sets up what is missing for engine `mujoco`. @return its build folder. Ends this process with
    set-up's exit code if that fails."""
    setup = [str(ROOT / "deploy" / "setup"), "--quiet", "--mujoco", mujoco]
    code = children.run_in_foreground(setup)
    if code != 0:
        sys.exit(code)
    return ROOT / ("build" if mujoco == "2.2.2" else f"build-{mujoco}")
