"""deploy/experiment: makes the runs that an experiment file asks for and puts them into results/."""

import argparse
import errno
import fnmatch
import os
import random
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "deploy" / "launcher"))

import builds  # noqa: E402
import children  # noqa: E402
import cores as machine  # noqa: E402
import folders  # noqa: E402
import matrix  # noqa: E402
import terminal  # noqa: E402
import view  # noqa: E402
from cell_files import CellFiles  # noqa: E402
from folders import shown  # noqa: E402
from result_files import ResultFiles, ResultsError  # noqa: E402
from settings import SettingsError, make_settings  # noqa: E402
from slot import CellFailed, Slot, stop_all  # noqa: E402

# Troubles that somebody, or time, may end.
PASSING = (errno.ENOSPC, errno.EDQUOT, errno.EAGAIN, errno.ENOMEM, errno.EMFILE, errno.ENFILE)
MOST_DOMAIN = 232  # DDSI-RTPS 2.2, 9.6.1.1: ports stay below 65536
TICK = 5.0  # seconds between looks for new milestones; children that end are noticed at once


def _parse(arguments):
    parser = argparse.ArgumentParser(
        prog="deploy/experiment", allow_abbrev=False,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Makes the runs of an experiment file, several at once, and evaluates their "
        "milestones. What is\ndone is skipped, what was interrupted goes on: stop it whenever you "
        "like (Ctrl-C) and start it again.",
        epilog="Done cells are in results/NAME/: runs.jsonl, evaluations.csv, progress/TASK.csv. Stopped ones leave\n"
        "results/NAME/CELL/unfinished/, from which another checkout goes on.\n\n" + matrix.__doc__)
    parser.add_argument("file", metavar="FILE", type=Path, help="deploy/experiments/main.toml, say")
    parser.add_argument("--list", action="store_true", help="say what is done and what is not, and end")
    parser.add_argument("--cells", metavar="GLOB", action="append",
                        help="only these, e.g. 'push-*-s1'; may be repeated")
    parser.add_argument("--jobs", type=int, metavar="N",
                        help="runs at once; each gets an equal share of the cores (default: one a core)")
    parser.add_argument("--domain", type=int, default=40, metavar="N",
                        help="DDS domain of the first run, the others use the next (default %(default)s)")
    parser.add_argument("--runs", type=Path, default=ROOT / "runs", metavar="DIR",
                        help="folder of runs being made (default runs/)")
    parser.add_argument("--results", type=Path, default=ROOT / "results", metavar="DIR",
                        help="folder of what is done (default results/)")
    parser.add_argument("--build", type=Path, metavar="DIR",
                        help="use the programs in DIR/bin as they are, without set-up")
    options = parser.parse_args(arguments)
    kept = (lambda path, _: folders.usable(path)) if options.list else folders.writable
    for name, find in (("runs", kept), ("results", kept), ("build", lambda path, _: folders.absolute(path))):
        try:
            path = getattr(options, name)
            setattr(options, name, path and find(path, f"--{name}"))
        except OSError as error:
            parser.error(f"--{name}: {error}")
    if options.jobs is not None and options.jobs < 1:
        parser.error("--jobs must be at least 1")
    if not 0 <= options.domain <= MOST_DOMAIN:
        parser.error(f"--domain must be from 0 to {MOST_DOMAIN}")
    jobs = options.jobs or machine.usable()
    if options.domain + jobs - 1 > MOST_DOMAIN:
        parser.error(f"{jobs} runs at once from --domain {options.domain} on need domain {options.domain + jobs - 1}, and "
                     f"{MOST_DOMAIN} is the last: choose a lower --domain or fewer --jobs")
    return options


def _chosen(experiment, globs):
    cells = [c for c in experiment.cells
             if not globs or any(fnmatch.fnmatchcase(c.name, g) for g in globs)]
    if not cells:
        raise matrix.MatrixError(f"no cell matches {' '.join(globs)}")
    return cells


def _require_same(cell, settings, made, remedy):
    """A cell that is done, or under way, must be what the file asks for now."""
    for key, wanted in {"command": settings.command_of(cell), **settings.evaluation_facts(cell)}.items():
        if made.get(key, wanted) != wanted:
            raise matrix.MatrixError(
                f"{cell.name} was made by other settings ({key}: {made[key]}) than the file asks for now ({wanted}): "
                f"{remedy}, or give the arm another name")


def _require_same_settings(files, runs, settings):
    for cell, of in files.items():
        if cell.name in runs:
            _require_same(cell, settings, runs[cell.name], f"remove its line from {shown(of.results.runs_path)}")
        else:
            made, folder = of.made_by()
            _require_same(cell, settings, made, f"move {shown(folder)} away")


def _list(files, done):
    for cell, of in files.items():
        if cell in done:
            state = "done"
        else:
            carried = " (carried)" if not of.started() and (of.result / "unfinished").is_dir() else ""
            state = f"{of.steps_done() / 1e6:.2f} of {cell.steps / 1e6:.2f} M steps{carried}"
        print(f"{cell.name:40} {state}")


class Runner:
    def __init__(self, files, done, places, settings, outlets):
        """@param files  cell to CellFiles, of those that are wanted.
        @param done  those of them that are done; what gets done is added.
        @param places  (cores, DDS domain) of each run that is made at once.
        @param outlets  terminal.Outlets to write to while there is nothing else to do."""
        self._todo = [cell for cell in files if cell not in done]
        self._files, self._done, self._events = files, done, children.Events()
        self._events.relieve(outlets)
        self._view = view.View(files, done)
        self._slots = [Slot(*place, settings, self._events, self._view.note) for place in places]
        self._failed = []
        self._troubles = {}  # slot to what it waits for the end of

    def run(self):
        """@return exit code."""
        try:
            while True:
                for slot in self._slots:
                    self._advance(slot)
                if not self._todo and all(slot.free for slot in self._slots):
                    return self._end()
                self._view.show([slot.cell for slot in self._slots if not slot.free])
                stops = self._events.wait(TICK)
                if stops:
                    self._view.note("stopping: each run writes a checkpoint")
                    return 128 + stops[0]
        finally:
            self._stop()
            self._view.close()

    def _advance(self, slot):
        try:
            self._go_on(slot)
            self._troubles.pop(slot, None)
        except OSError as error:
            if error.errno not in PASSING:
                raise
            if self._troubles.get(slot) != str(error):
                self._view.note(f"waiting until this is over: {error}")
            self._troubles[slot] = str(error)

    def _go_on(self, slot):
        """Whatever raises an OSError here can be tried again."""
        try:
            done = slot.advance()
            if done is not None:
                self._done.add(done)
                self._view.done()
        except CellFailed as failure:
            self._failed.append(str(failure))
            self._view.note(f"failed: {failure}")
        if slot.free and self._todo:
            slot.start(self._todo[0], self._files[self._todo[0]])
            del self._todo[0]

    def _stop(self):
        under_way = [slot for slot in self._slots if not slot.free]
        stop_all(under_way, self._events)
        for slot in under_way:
            kept = f"{shown(slot.files.result)}/unfinished/"
            try:
                problem = slot.carry()
            except OSError as error:
                problem = f"{slot.files.name}: not kept in {kept}: {error}"
            self._view.note(problem or f"{slot.files.name} goes on from where it stands; kept in {kept}")

    def _end(self):
        if self._failed:
            print(f"{len(self._failed)} of the runs failed:", *self._failed, sep="\n  ", file=sys.stderr)
        return 1 if self._failed else 0


def _places(options):
    cores, count = sorted(os.sched_getaffinity(0)), machine.usable()
    if count < len(cores):  # of a CPU quota; others who share the machine choose as we do
        cores = sorted(random.sample(cores, count))
    jobs = options.jobs or count
    if jobs > count:
        print(f"deploy/experiment: {jobs} runs at once share {count} cores: none has one to itself", file=sys.stderr)
    share = max(1, count // jobs)
    return [([cores[(i * share + k) % count] for k in range(share)], options.domain + i)
            for i in range(jobs)]


def main():
    terminal.prepare()
    outlets = terminal.never_block()
    options = _parse(sys.argv[1:])
    if options.list:  # it has no other work than to be read
        sys.stdout = sys.__stdout__
    try:
        experiment = matrix.load(options.file)
        cells = _chosen(experiment, options.cells)
        results = ResultFiles(options.results / experiment.name)
        files = {cell: CellFiles(cell, options.runs, results) for cell in cells}
        runs = results.runs()
        done = {cell for cell in cells if cell.name in runs}
        if options.list:
            _list(files, done)
            sys.stdout.flush()
            return 0
        build = options.build or builds.set_up(experiment.mujoco)
        settings = make_settings(ROOT, build, experiment, cells)
        _require_same_settings(files, runs, settings)
        results.define(options.file)
        for cell in done:
            files[cell].drop_carried()
    except BrokenPipeError:  # whoever reads --list has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (matrix.MatrixError, ResultsError, SettingsError, OSError) as error:
        print(f"deploy/experiment: {options.file}: {error}", file=sys.stderr)
        return 2
    begin = time.monotonic()
    code = Runner(files, done, _places(options), settings, outlets).run()
    print(f"{experiment.name}: {len(done)} of {len(cells)} runs done, this time in "
          f"{(time.monotonic() - begin) / 60:.0f} minutes; {shown(results.folder)}/")
    return code


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:  # during set-up: no run has begun
        sys.exit(130)
