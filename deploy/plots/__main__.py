"""deploy/figures: statistics and figures of the experiments, made from the CSV files under results/.

Writes results/figures/: one image a figure, a picture of each committed policy's skills, and README.md
with every figure's caption and all tables. The same results give the same files, byte for byte.
"""

import argparse
import os
import re
import sys
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[2]
sys.path[1:1] = [str(ROOT / "deploy" / folder) for folder in ("launcher", "experimenter")]

import cells  # noqa: E402
import exchange  # noqa: E402
import experts  # noqa: E402
import fifty  # noqa: E402
import markdown  # noqa: E402
import policies  # noqa: E402
import scores  # noqa: E402
import stops  # noqa: E402
import style  # noqa: E402
import tables  # noqa: E402
import terminal  # noqa: E402
import whole_files  # noqa: E402
from draw import blocks, controls, efficiency, every_task, final, heads, learning  # noqa: E402
from folders import shown, writable  # noqa: E402
from names import arms_of, tasks_of  # noqa: E402

FIGURES = {
    "main": learning.main, "main-success": learning.main_success, "ablation": learning.ablation,
    "final": final.final, "heads": heads.heads, "controls": controls.controls,
    "efficiency": efficiency.efficiency, "wallclock": learning.wallclock, "solve": learning.solve,
    "fifty": every_task.fifty, "fifty-difference": every_task.fifty_difference,
}
# Both a figure and a table, of policies instead of runs.
EXCHANGE = "exchange"
NAMES = (*FIGURES, EXCHANGE, *policies.NAMES)
TABLES = (*tables.TABLES, *fifty.NAMES, EXCHANGE)
# Experiments whose curves have figures of their own; all others get NAME-curves.
_OWN_CURVES = ("main", "solve", every_task.EXPERIMENT)


def parse_arguments():
    parser = argparse.ArgumentParser(prog="deploy/figures", description=__doc__, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, default=ROOT / "results", metavar="DIR",
                        help="folder of the experiments (default results/)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write (default RESULTS/figures)")
    parser.add_argument("--only", action="append", metavar="NAME",
                        help="only this figure, without tables; may be repeated: "
                             + ", ".join(NAMES) + ", EXPERIMENT-curves")
    parser.add_argument("--videos", action="store_true",
                        help="a video of each committed policy too (a minute each)")
    parser.add_argument("--format", choices=("png", "svg", "pdf"), default="png", help="of the images (default png)")
    parser.add_argument("--page", type=Path, metavar="FILE",
                        help="put tables and figures into this Markdown file too, between its "
                             "'<!-- table NAME -->' or '<!-- figure NAME -->' and '<!-- end -->'")
    options = parser.parse_args()
    options.out = options.out or options.results / "figures"
    return parser, options


def drawings(experiments, exchanges):
    """Name to drawing function of every figure that there may be."""
    others = [name for name in experiments if name not in _OWN_CURVES]
    own = FIGURES | {EXCHANGE: lambda _: blocks.exchange(exchanges)}
    return own | {f"{name}-curves": lambda found, name=name: learning.every_curve(found, name)
                      for name in others}


def draw_all(experiments, wanted, options):
    """@return name to caption of the figures made."""
    captions = {}
    for name, draw in wanted.items():
        style.use()
        made = draw(experiments)
        if made is None:
            print(f"  {name}: nothing to draw it from yet", flush=True)
            continue
        figure, captions[name] = made
        path = options.out / f"{name}.{options.format}"
        style.save(figure, path)
        print(f"  {shown(path)}  {path.stat().st_size / 1000:.0f} kB", flush=True)
    return captions


def draw_policies(wanted, options):
    """@return name to caption of the skill figures made."""
    captions, program = {}, policies.renderer(ROOT)
    for task, checkpoint in policies.found(options.results).items():
        name = f"skill-{task}"
        if wanted and name not in wanted:
            continue
        if program is None:
            print(f"  {name}: left out, it is drawn on the default engine, by build/bin/metronome-actor (deploy/setup "
                  "builds it)", flush=True)
            continue
        targets = [options.out / f"{name}.png"] + [options.out / f"{task}.mp4"] * options.videos
        for target in targets:
            said = policies.render(program, checkpoint, target)
            print(f"  {shown(target)}  {target.stat().st_size / 1000:.0f} kB", flush=True)
        captions[name] = policies.caption(said)
    return captions


def summary(name, found):
    counts = scores.seeds_text(seed_counts(found).values())
    return f"{name}: {len(found)} runs, {len(tasks_of(found))} tasks, {len(arms_of(found))} arms, {counts} seeds each"


def seed_counts(found):
    """(task, arm) to seeds, of those that have any."""
    counts = {}
    for cell in found:
        counts[cell.task, cell.arm] = counts.get((cell.task, cell.arm), 0) + 1
    return counts


def contents(experiments):
    """The data of the page: seeds of each task and arm, the longer list of the two downwards."""
    parts = []
    for name, found in experiments.items():
        counts = seed_counts(found)
        across, down = sorted((tasks_of(found), arms_of(found)), key=len)
        rows = [[row, *(str(counts.get((row, column), counts.get((column, row), 0))) for column in across)]
                for row in down]
        parts.append(markdown.table((f" {name}", *across), rows))
    return "\n\n".join(parts)


def image_of(name, suffix):
    return f"{name}.png" if name in policies.NAMES else f"{name}.{suffix}"


def write_page(path, experiments, captions, made, suffix):
    parts = ["# Figures and tables", "Made by `deploy/figures` from the finished runs of the experiments beside this "
             "folder; not written by hand. Seeds of each task and arm:", contents(experiments)]
    for name, caption in captions.items():
        parts += [f"## {name}", f"![{name}]({image_of(name, suffix)})", caption]
    for name, table in made.items():
        parts += [f"## Table: {name}", table]
    whole_files.write(path, "\n\n".join(parts) + "\n")
    print(f"  {shown(path)}", flush=True)


def unknown_mark(page):
    """@return a mark of the page that nothing would ever fill, or None."""
    for kind, name in re.findall(r"<!-- (table|figure) (.*?) -->", page.read_text(encoding="utf-8")):
        known = TABLES if kind == "table" else NAMES
        if name not in known and not (kind == "figure" and name.endswith("-curves")):
            return f"<!-- {kind} {name} -->"
    return None


def fill_page(page, blocks):
    """Replaces what stands between the marks of `blocks`, (kind, name) to Markdown."""
    text = page.read_text(encoding="utf-8")
    for (kind, name), block in blocks.items():
        # Up to the next mark of an end, but never over that of a beginning.
        pattern = re.compile(rf"(<!-- {kind} {re.escape(name)} -->\n)(?:(?!<!-- ).)*(<!-- end -->)", re.DOTALL)
        text = pattern.sub(lambda match: f"{match[1]}\n{block}\n\n{match[2]}", text)
    whole_files.write(page.resolve(), text)  # a link stays one
    print(f"  {shown(page)}", flush=True)


def page_blocks(options, captions, made):
    folder = os.path.relpath(options.out, options.page.resolve().parent)
    blocks = {("figure", name): f"![{name}]({folder}/{image_of(name, options.format)})\n\n{caption}"
              for name, caption in captions.items()}
    return blocks | {("table", name): table for name, table in made.items()}


def main():
    terminal.prepare()
    terminal.never_block()  # its work is the files
    parser, options = parse_arguments()
    stops.exit_on_stop()
    try:
        writable(options.out, "--out")
    except OSError as error:
        parser.error(f"--out: {error}")
    if options.page and not options.page.is_file():
        parser.error(f"--page: there is no file {options.page}")
    if options.page and unknown_mark(options.page):
        parser.error(f"--page: {options.page} has {unknown_mark(options.page)}; there are figures "
                     f"{', '.join(NAMES)}, EXPERIMENT-curves, and tables {', '.join(TABLES)}")
    try:
        experiments, unfinished = cells.read_results(options.results)
        exchanges = exchange.found(options.results)
        scripted = experts.found(policies.renderer(ROOT)) if every_task.EXPERIMENT in experiments else {}
    except cells.ResultsError as error:
        print(f"deploy/figures: {error}", file=sys.stderr)
        return 2
    wanted = drawings(experiments, exchanges)
    unknown = [name for name in options.only or [] if name not in (*wanted, *policies.NAMES)]
    if unknown:
        parser.error(f"--only: no figure '{unknown[0]}'; there are: {', '.join((*wanted, *policies.NAMES))}")
    for name, found in experiments.items():
        print(summary(name, found))
    for run in unfinished:
        print(f"  left out: {run} is not finished (runs.jsonl has no line of it)")
    options.out.mkdir(parents=True, exist_ok=True)
    captions = draw_all(experiments, {name: draw for name, draw in wanted.items()
                                      if name in (options.only or wanted)}, options)
    try:
        captions |= draw_policies(options.only, options)
    except policies.RenderError as error:
        print(f"deploy/figures: {error}", file=sys.stderr)
        return 1
    made = {}
    if not options.only:
        made = {name: table(experiments) for name, table in tables.TABLES.items()}
        made |= fifty.tables(experiments, scripted)
        made[EXCHANGE] = tables.exchanges(exchanges)
        made = {name: table for name, table in made.items() if table is not None}
        write_page(options.out / "README.md", experiments, captions, made, options.format)
    if options.page:
        fill_page(options.page, page_blocks(options, captions, made))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
