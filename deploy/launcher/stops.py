"""Signals that ask a program to stop, as exceptions: what was begun is tidied up on the way out."""

import signal
import sys


def exit_on_stop():
    """SIGTERM and SIGHUP raise SystemExit, as SIGINT raises KeyboardInterrupt; ignored ones stay ignored.
    subprocess.run then ends its child."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, lambda got, _: sys.exit(128 + got))
