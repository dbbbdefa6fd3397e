"""deploy/train: sets up if needed, then runs a learner and its actors with progress to look at."""

import sys

import builds
import identities
import options as command_line
import terminal
from session import Session


def main():
    terminal.prepare()
    outlets = terminal.never_block()
    options = command_line.parse(sys.argv[1:])
    warning = command_line.warning(options)
    if warning:
        print(f"{command_line.NAME}: {warning}", file=sys.stderr)
    if options.build is None:
        options.build = builds.set_up(options.mujoco)
    if options.security is not None:
        identities.make_missing(options)
    return Session(options, outlets).run()


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:  # during set-up: no learner runs yet
        sys.exit(130)
