"""The identities of a secured run's processes on this machine."""

import os
import sys

import children
import place
from options import given


def make_missing(options):
    """Makes those of our learner and actors that are not there or have expired. Ends this process
    with the exit code of deploy/security if that fails."""
    folder = options.security
    if os.path.exists(folder / "learner") and not os.path.exists(folder / "authority"):
        return  # copied here without what could make more; the processes name what they lack
    command = [place.command("security"), folder, "--run", options.run]
    command += ["--actors", options.actors]
    domain = given(options, "--domain")
    command += [] if domain is None else ["--domain", domain]
    code = children.run_in_foreground([str(word) for word in command])
    if code != 0:
        sys.exit(code)
