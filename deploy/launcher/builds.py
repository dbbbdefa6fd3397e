"""The programs of an engine."""

import sys

import children
import place


def set_up(mujoco):
    """Sets up what is missing for engine `mujoco`. @return the folder whose bin/ holds its programs. Ends this
    process with set-up's exit code if that fails. An installation is set up."""
    if not place.CHECKOUT:
        return place.BUILD
    setup = [str(place.command("setup")), "--quiet", "--mujoco", mujoco]
    code = children.run_in_foreground(setup)
    if code != 0:
        sys.exit(code)
    return place.ROOT / ("build" if mujoco == "2.2.2" else f"build-{mujoco}")
