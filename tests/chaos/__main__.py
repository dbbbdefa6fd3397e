"""Runs under faults that end with the weights of a calm run.

    tests/chaos/run [--seeds FIRST-LAST] [--faults N]

Each seed draws its faults and when they begin: actors and the learner killed, stopped, terminated and
restarted; links cut, narrow, lossy, delaying, reordering, doubling; a full disk; actors that lie. Every
machine is a network namespace of its own, so this needs root.
"""

import argparse
import collections
import csv
import sys
import tempfile
import time
from pathlib import Path

from conductor import Conductor
from faults import plan
from team import UPDATES, Failed, Team, namespaces, small_disk

LONGEST_SILENCE = 10.0  # seconds between updates of a run that could go on; longer ones are failures
FEWEST_FAULTS = 10  # that must strike in a run, or all of a shorter plan; fewer show too little


def say(text):
    print(f"{time.strftime('%H:%M:%S')} {text}", flush=True)


def curve(team):
    """progress.csv of the run without what is wall-clock time."""
    with open(team.folder / "chaos" / "progress.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    return [{k: v for k, v in row.items() if k != "fps" and "wall_" not in k} for row in rows]


def one_run(folder, faults, options):
    """@return (conductor, weights_sha256, curve, seconds)."""
    started = time.monotonic()
    with small_disk(folder, "48m") as disk, Team(disk / "runs", options=options.learner) as team:
        team.start_learner()
        for name in team.actor_hosts:
            team.start_actor(name)
        conductor = Conductor(team, faults(team), say if options.verbose else lambda text: None)
        try:
            digest = conductor.conduct()
        finally:
            if options.logs:
                team.write_logs(options.logs / folder.name)
        say(team.done["accounting"])
        return conductor, digest, curve(team), time.monotonic() - started


def parse_seeds(text):
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def parse_arguments():
    parser = argparse.ArgumentParser(
        prog="tests/chaos/run", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=parse_seeds, default=range(1, 21), help="[1-20]")
    parser.add_argument("--faults", type=int, default=16, help="in each run [16]")
    parser.add_argument("--logs", type=Path, help="where the logs of all processes go, by seed")
    parser.add_argument("--verbose", action="store_true", help="tell each fault as it begins")
    parser.add_argument(
        "learner", nargs="*", help="options of the learner, after --: -- --set collection.overlap=1"
    )
    return parser.parse_args()


def main():
    options = parse_arguments()
    if reason := namespaces.unavailable():
        sys.exit(f"tests/chaos/run: {reason}")
    bad, struck, silences = 0, collections.Counter(), []
    with tempfile.TemporaryDirectory(prefix="metronome-chaos-") as folder:
        _, calm, calm_curve, seconds = one_run(Path(folder) / "calm", lambda team: [], options)
        say(f"calm: {calm} in {seconds:.0f} s")
        for seed in options.seeds:
            try:
                conductor, digest, rows, seconds = one_run(
                    Path(folder) / str(seed),
                    lambda team: plan(seed, options.faults, team.actor_hosts, UPDATES),
                    options,
                )
            except Failed as failure:
                bad += 1
                say(f"seed {seed}: FAILED: {failure}")
                continue
            equal = digest == calm and rows == calm_curve
            enough = len(conductor.struck) >= min(FEWEST_FAULTS, options.faults)
            bad += not equal or not enough or conductor.longest_silence > LONGEST_SILENCE
            struck.update(fault.name for fault in conductor.struck)
            silences.append(conductor.longest_silence)
            say(
                f"seed {seed}: {'equal' if equal else f'DIFFERS: {digest}'}, "
                f"{len(conductor.struck)} faults struck{'' if enough else ': TOO FEW'}, "
                f"{len(conductor.missed)} missed "
                f"({', '.join(map(str, conductor.missed)) or 'none'}), "
                f"{len(conductor.plan)} never began, {seconds:.0f} s, "
                f"longest silence {conductor.longest_silence:.1f} s"
            )
    for name, count in sorted(struck.items()):
        print(f"  {count:4} {name}")
    print(f"{sum(struck.values())} faults struck; longest silence {max(silences, default=0):.1f} s")
    print(f"{len(options.seeds) - bad} passed, {bad} failed")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
