"""Progress of an experiment: a bar on a terminal, a line now and then elsewhere."""

import sys
import time

PLAIN_EVERY = 60.0  # seconds between lines


def _bar():
    """None where `rich` is missing: with --build nothing was set up."""
    try:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn
    except ImportError:
        return None
    return Progress(TextColumn("[bold]{task.fields[count]}"), BarColumn(), TextColumn("{task.percentage:3.0f}%"),
                    TextColumn("{task.fields[rest]}"), auto_refresh=False, console=Console(file=sys.stdout))


class View:
    def __init__(self, files, done):
        """@param files  cell to CellFiles.
        @param done  those of the cells that are done, at any time."""
        self._files, self._done = files, done
        self._begin, self._next = time.monotonic(), 0.0
        self._first = None  # steps of all cells when we began
        self._bar = _bar() if sys.stdout.isatty() else None
        if self._bar is not None:
            self._task = self._bar.add_task("", total=None, count="", rest="")
            self._bar.start()

    def show(self, running):
        """@param running  cells under way."""
        if self._bar is None and time.monotonic() < self._next:
            return
        self._next = time.monotonic() + PLAIN_EVERY
        steps, total = self._steps(), sum(cell.steps for cell in self._files)
        if self._first is None:
            self._first = steps
        count = f"{len(self._done)}/{len(self._files)} runs"
        now = ", ".join(f"{cell.name} {100 * self._files[cell].steps_done() // cell.steps} %"
                        for cell in running)
        rest = f"{self._left(steps, total)}  {now}"
        if self._bar is None:
            print(f"{count}  {steps / 1e6:.2f}/{total / 1e6:.2f} M steps  {rest}", flush=True)
        else:
            self._bar.update(self._task, completed=steps, total=total, count=count, rest=rest)
            self._bar.refresh()

    def done(self):
        self._next = 0.0

    def note(self, text):
        if self._bar is None:
            print(text, flush=True)
        else:
            self._bar.console.print(text, markup=False, highlight=False)

    def close(self):
        if self._bar is not None:
            self._bar.stop()

    def _steps(self):
        return sum(cell.steps if cell in self._done else self._files[cell].steps_done() for cell in self._files)

    def _left(self, steps, total):
        rate = (steps - self._first) / max(1e-9, time.monotonic() - self._begin)
        if rate <= 0:
            return "time left unknown"
        minutes = round((total - steps) / rate / 60)
        return f"{rate:.0f} steps/s  {minutes // 60}:{minutes % 60:02} h left"
