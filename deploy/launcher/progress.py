"""Progress for people: a bar on a terminal, now and then a line elsewhere."""

import sys
import time

PLAIN_EVERY = 10.0  # seconds between lines


def _clock(seconds):
    seconds = int(seconds)
    return f"{seconds // 3600}:{seconds // 60 % 60:02}:{seconds % 60:02}"


def _columns(record):
    return (
        f"return {record['return']:8.1f}",
        f"success {record['success']:.2f}",
        f"{record['fps']:7.0f} steps/s",
        f"{_clock(record['eta_seconds'])} left",
    )


class PlainView:
    """Lines for logs and pipes: the first update, then one every PLAIN_EVERY seconds, the last."""

    def __init__(self):
        self._next = 0.0
        self._pending = None

    def update(self, record):
        self._pending = record
        if time.monotonic() >= self._next:
            self._print()

    def note(self, text):
        print(text, flush=True)

    def close(self):
        if self._pending:
            self._print()

    def _print(self):
        record, self._pending = self._pending, None
        self._next = time.monotonic() + PLAIN_EVERY
        print(
            f"update {record['update']:>4}/{record['updates_total']}  "
            f"{record['steps']:>8}/{record['total_steps']} steps",
            *_columns(record),
            sep="  ",
            flush=True,
        )


class BarView:
    """A bar that each update moves. No thread: children must be started from a process without."""

    def __init__(self, title):
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        self._progress = Progress(
            TextColumn("[bold]{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f}%"),
            TextColumn("{task.fields[columns]}"),
            auto_refresh=False,
            console=Console(file=sys.stdout),
        )
        self._task = self._progress.add_task(title, total=None, columns="waiting for actors")
        self._progress.start()
        self._progress.refresh()

    def update(self, record):
        self._progress.update(
            self._task,
            completed=record["steps"],
            total=record["total_steps"],
            columns="  ".join(_columns(record)),
        )
        self._progress.refresh()

    def note(self, text):
        self._progress.console.print(text, markup=False, highlight=False)

    def close(self):
        self._progress.stop()


def make_view(title):
    try:
        return BarView(title) if sys.stdout.isatty() else PlainView()
    except ImportError:  # with --build nothing was set up
        return PlainView()
