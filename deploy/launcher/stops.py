"""Signals that ask a program to stop."""

import signal
import sys


def handle(number, handler):
    """As signal.signal, but what was ignored when we were started stays ignored."""
    if signal.getsignal(number) != signal.SIG_IGN:
        signal.signal(number, handler)


def exit_on_stop():
    """SIGTERM and SIGHUP raise SystemExit, as SIGINT raises KeyboardInterrupt: what was begun is tidied up on the
    way out, and children.said_by ends its child."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        handle(number, lambda got, _: sys.exit(128 + got))
