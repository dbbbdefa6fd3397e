"""See growth.md beside this folder."""

import argparse
import os
import re
import sys
from pathlib import Path

sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "launcher"))

import measured  # noqa: E402
import tables  # noqa: E402
import terminal  # noqa: E402

PAGE = Path(__file__).resolve().parents[1] / "growth.md"


def parse_arguments():
    parser = argparse.ArgumentParser(
        prog="deploy/growth/run", description="Simulates a learner with 1 to 10000 playing cores from the figures in "
        "results/performance, and prints tables; a minute or two.")
    parser.add_argument("--only", nargs="+", choices=tables.TABLES, default=list(tables.TABLES), metavar="TABLE",
                        help="some of the tables: " + ", ".join(tables.TABLES))
    parser.add_argument("--most-cores", type=int, default=10000, metavar="N",
                        help="leave out what plays on more cores, which takes longest (default 10000)")
    parser.add_argument("--task", default="push", metavar="TASK", help="whose figures to take (default push)")
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
    terminal.prepare()
    arguments = parse_arguments()
    if arguments.page:
        terminal.never_block()  # the page has it all
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
    try:
        sys.exit(main())
    except BrokenPipeError:  # whoever reads the tables has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except OSError as error:
        sys.exit(f"deploy/growth/run: {error}")
