"""deploy/train: sets up if needed, then runs a learner and its actors with progress to look at."""

import sys

import children
import options as command_line
from session import Session


def main():
    options = command_line.parse(sys.argv[1:])
    if options.build is None:
        setup = [str(command_line.ROOT / "deploy" / "setup"), "--quiet", "--mujoco", options.mujoco]
        code = children.run_in_foreground(setup)
        if code != 0:
            return code
        folder = "build" if options.mujoco == "2.2.2" else f"build-{options.mujoco}"
        options.build = command_line.ROOT / folder
    options.build = options.build.absolute()
    return Session(options).run()


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:  # during set-up: no learner runs yet
        sys.exit(130)
