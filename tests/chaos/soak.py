"""A long run under faults whose memory, descriptors and shared memory stay flat.

    tests/soak [--minutes N] [--csv FILE] [--logs DIR]

Actors are killed, stopped and replaced, links fail, the disk fills, actors lie, one fault every ten
seconds, while the learner and actor1 live on and are measured every ten seconds: resident memory, open
descriptors, threads, files in shared memory. Flat means: the median of the last third exceeds that of the
second by no more than 2 % and 1 MB. Needs root.
"""

import argparse
import csv
import os
import random
import statistics
import sys
import tempfile
import time
from pathlib import Path

import faults
from conductor import Conductor
from team import EPISODES, HORIZON, RUN, Team, namespaces, small_disk

FAULT_EVERY, SAMPLE_EVERY = 10.0, 10.0  # seconds
TRAINING = (
    *("--task", "push", "--seed", "7", "--steps", str(10**9)),
    *("--set", f"environment.horizon={HORIZON}", "--set", f"collection.episodes_per_update={EPISODES}"),
    *("--set", "ppo.minibatch=200", "--transport", "shm"),
)
COLUMNS = ("minutes", "process", "resident_kb", "descriptors", "threads", "shared_memory_files")


def draw_fault(draw, actor_hosts):
    kind = draw.choice([*faults.OF_ACTORS, faults.LearnerStopped, faults.DiskFull, faults.Hostile])
    if kind is faults.LearnerStopped:
        return kind(draw, "learner")
    if kind is faults.DiskFull:
        return kind(draw, "disk")
    lives_on = (faults.ActorKilled, faults.ActorTerminated)
    return kind(draw, draw.choice(actor_hosts[1:] if kind in lives_on else actor_hosts))


def say(text):
    print(f"{time.strftime('%H:%M:%S')} {text}", flush=True)


def measure(process):
    """@return resident memory (kB), open descriptors, threads."""
    folder = Path(f"/proc/{process.child.pid}")
    status = dict(
        line.split(":", 1) for line in (folder / "status").read_text().splitlines() if ":" in line
    )
    resident = int(status["VmRSS"].split()[0])
    return resident, len(os.listdir(folder / "fd")), int(status["Threads"])


def soak(team, options, writer):
    draw = random.Random(1)
    conductor = Conductor(team, [], say if options.verbose else lambda text: None, 10**9)
    start = time.monotonic()
    next_fault, next_sample = start + FAULT_EVERY, start + SAMPLE_EVERY
    rows = []
    while time.monotonic() < start + 60 * options.minutes:
        conductor.step()
        now = time.monotonic()
        if now >= next_fault:
            next_fault = now + FAULT_EVERY
            fault = draw_fault(draw, team.actor_hosts)
            if not conductor.busy(fault.target):
                conductor.begin(fault)
        if now >= next_sample:
            next_sample = now + SAMPLE_EVERY
            shared = shared_memory_files(team)
            for name, process in (("learner", team.learner), ("actor", team.actors["actor1"])):
                row = (round((now - start) / 60, 2), name, *measure(process), shared)
                rows.append(row)
                writer.writerow(row)
    conductor.end_all()
    return conductor, rows


def shared_memory_files(team):
    """Of this run alone, by its notes: other runs of the machine come and go."""
    notes = list(Path("/dev/shm").glob(f"metronome-{team.domain}-{RUN}-*"))
    return len(notes) + sum(len(note.read_text().split()) for note in notes if note.exists())


def flatness(rows):
    """@return [(process, column, median of the second third, of the last, whether that is flat)]."""
    found = []
    for process in ("learner", "actor"):
        mine = [row for row in rows if row[1] == process]
        third = len(mine) // 3
        for i in range(2, len(COLUMNS)):
            before = statistics.median(row[i] for row in mine[third : 2 * third])
            after = statistics.median(row[i] for row in mine[2 * third :])
            slack = 1024 if COLUMNS[i] == "resident_kb" else 1
            found.append((process, COLUMNS[i], before, after, after <= 1.02 * before + slack))
    return found


def main():
    parser = argparse.ArgumentParser(
        prog="tests/soak", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=60, help="[60]")
    parser.add_argument("--csv", type=argparse.FileType("w", bufsize=1), default=os.devnull)
    parser.add_argument("--logs", type=Path, help="where the logs of all processes go")
    parser.add_argument("--verbose", action="store_true", help="tell each fault as it begins")
    options = parser.parse_args()
    if reason := namespaces.unavailable():
        sys.exit(f"tests/soak: {reason}")
    writer = csv.writer(options.csv)
    writer.writerow(COLUMNS)
    with tempfile.TemporaryDirectory(prefix="metronome-soak-") as folder:
        with small_disk(Path(folder) / "disk", "256m") as disk, Team(
            disk / "runs", training=TRAINING
        ) as team:
            team.start_learner()
            for name in team.actor_hosts:
                team.start_actor(name)
            try:
                conductor, rows = soak(team, options, writer)
            finally:
                if options.logs:
                    team.write_logs(options.logs)
    options.csv.flush()
    bad = 0
    for process, column, before, after, flat in flatness(rows):
        bad += not flat
        print(f"{process:8} {column:20} {before:10.0f} {after:10.0f}  {'flat' if flat else 'GROWS'}")
    print(
        f"{len(conductor.struck)} faults struck in {options.minutes:g} minutes; "
        f"longest silence {conductor.longest_silence:.1f} s"
    )
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
