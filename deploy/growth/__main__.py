"""See growth.md beside this folder."""

import argparse
import re
import sys
from pathlib import Path

import measured
import tables

PAGE = Path(__file__).resolve().parents[1] / "growth.md"


def parse_arguments():
    parser = argparse.ArgumentParser(
        prog="deploy/growth/run", description="Simulates a learner with 1 to 10000 playing cores from the figures in "
        "results/performance, and prints tables; a minute or two.")
    parser.add_argument("--only", nargs="+", choices=tables.TABLES, default=list(tables.TABLES), metavar="TABLE",
                        help="some of the tables: " + ", ".join(tables.TABLES))
    parser.add_argument("--most-cores", type=int, default=10000, metavar="N",
                        help="leave out what plays on more cores, which takes longest (default 10000)")
    parser.add_argument("--task", default="push", choices=("assembly", "bin-picking", "box-close", "push"))
    parser.add_argument("--page", action="store_true",
                        help="put the tables between their marks in deploy/growth.md too")
    arguments = parser.parse_args()
    if arguments.page and (arguments.most_cores != 10000 or arguments.task != "push"):
        parser.error("--page: the page's tables are those of push and of all sizes")
    return arguments


def put_into_page(made):
    text = PAGE.read_text(encoding="utf-8")
    for name, table in made.items():
        pattern = re.compile(rf"(<!-- table {name} -->\n)(?:(?!<!-- ).)*(<!-- end -->)", re.DOTALL)
        if not pattern.search(text):
            raise SystemExit(f"deploy/growth/run: {PAGE} has no '<!-- table {name} -->' ... '<!-- end -->'")
        text = pattern.sub(lambda match: f"{match[1]}\n{table}\n\n{match[2]}", text)
    PAGE.write_text(text, encoding="utf-8")


def main():
    arguments = parse_arguments()
    try:
        costs = measured.read(arguments.task)
    except measured.MissingFigure as missing:
        print(f"deploy/growth/run: {missing}", file=sys.stderr)
        return 2
    made = {}
    for name in arguments.only:
        made[name] = tables.TABLES[name](costs, arguments.most_cores)
        print(f"{name}\n\n{made[name]}\n", flush=True)
    if arguments.page:
        put_into_page(made)
    return 0


if __name__ == "__main__":
    sys.exit(main())
