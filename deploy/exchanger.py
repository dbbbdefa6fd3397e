"""deploy/exchange: evaluates policies with one head in another's block of time, and with one head alone."""

import argparse
import csv
import io
import json
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "deploy" / "launcher"))

import children  # noqa: E402
import folders  # noqa: E402
import stops  # noqa: E402
import terminal  # noqa: E402
import whole_files  # noqa: E402

COLUMNS = ("order", "success", "success_end", "return", "time_to_success",
           "episodes", "seed", "engine", "weights_sha256")


class Refused(Exception):
    """A request that cannot be done; the message says why and what to do."""


def parse_arguments():
    parser = argparse.ArgumentParser(
        prog="deploy/exchange", allow_abbrev=False,
        description="Evaluates each policy under its mean action as it is, with every head in every other head's "
                    "block of time (one block at a time), and with every head acting alone, all on the same "
                    "placements. Rows go to OUT/NAME.csv as they come; those that are there are not made again. "
                    "Three minutes a policy of 10 heads, on two cores.")
    parser.add_argument("checkpoints", metavar="CHECKPOINT", nargs="*", type=Path,
                        default=sorted((ROOT / "results" / "policies").glob("*.ckpt")),
                        help="of a policy whose heads act in blocks (default: results/policies/*.ckpt)")
    parser.add_argument("--out", metavar="OUT", type=Path, default=ROOT / "results" / "exchange",
                        help="folder of the CSV files (default results/exchange/)")
    parser.add_argument("--episodes", metavar="N", type=int, default=50, help="of each (default 50)")
    parser.add_argument("--seed", metavar="N", type=int, default=4242, help="of the placements (default 4242)")
    parser.add_argument("--build", metavar="DIR", type=Path, default=ROOT / "build",
                        help="use the programs in DIR/bin (default build/)")
    return parser.parse_args()


def orders(heads):
    """The head in each block: as trained, then each exchange of one block's head, then each head alone. Of two
    heads the exchanges are one head alone already."""
    own = tuple(range(heads))
    exchanged = [(*own[:block], head, *own[block + 1:]) for block in own for head in own]
    return list(dict.fromkeys([own, *exchanged, *((head,) * heads for head in own)]))


def said_by(*command):
    """@return the JSON object that the program prints."""
    done = children.said_by([str(word) for word in command])
    if done.returncode != 0:
        raise Refused(done.stderr.strip() or f"{command[0]} ended with {done.returncode}")
    return json.loads(done.stdout)


def rows_there(path, same):
    """@return orders that `path` has. @throws Refused if it was made of something else than `same`."""
    if not path.exists():
        return set()
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        for column, value in same.items():
            if row.get(column) != str(value):
                raise Refused(f"{path} has rows of {column} {row.get(column)}, not {value}: name another --out, or "
                              "remove it")
    return {row["order"] for row in rows}


def exchange(checkpoint, options):
    learner, actor = (options.build / "bin" / f"metronome-{part}" for part in ("learner", "actor"))
    policy = said_by(learner, "inspect", checkpoint, "--json")
    if policy["schedule"] == "interleaved":
        raise Refused(f"{checkpoint}: interleaved heads have no blocks of time to exchange")
    evaluate = (actor, "evaluate", "--checkpoint", checkpoint, "--seed", options.seed, "--json")
    as_trained = said_by(*evaluate, "--episodes", 1)
    for difference in as_trained["differences"]:
        print(f"deploy/exchange: warning: {checkpoint.stem}: {difference}", file=sys.stderr)
    engine = as_trained["engine_used"]
    plan = [",".join(map(str, order)) for order in orders(policy["heads"])]
    same = {"episodes": options.episodes, "seed": options.seed, "engine": engine,
            "weights_sha256": policy["weights_sha256"]}
    path = options.out / f"{checkpoint.stem}.csv"
    there = rows_there(path, same)
    for number, order in enumerate(plan, 1):
        if order in there:
            continue
        result = said_by(*evaluate, "--episodes", options.episodes, "--head-order", order)
        add_row(path, {"order": order} | {key: result[key] for key in COLUMNS[1:5]} | same)
        print(f"{checkpoint.stem} {number}/{len(plan)}  {order}  success {result['success']:.2f}  "
              f"return {result['return']:.0f}", flush=True)


def add_row(path, row):
    """Whole or not at all."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    if path.exists():
        text.write(path.read_text(encoding="utf-8"))
    else:
        writer.writeheader()
    writer.writerow(row)
    whole_files.write(path, text.getvalue())


def main():
    terminal.prepare()
    terminal.never_block()  # its work is the files
    options = parse_arguments()
    stops.exit_on_stop()
    program = options.build / "bin" / "metronome-actor"
    try:
        if not os.access(program, os.X_OK):
            raise Refused(f"there is no {program}: run deploy/setup, or name another --build")
        folders.writable(options.out, "--out").mkdir(parents=True, exist_ok=True)
        for checkpoint in options.checkpoints:
            exchange(checkpoint, options)
    except (Refused, OSError) as error:
        print(f"deploy/exchange: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
