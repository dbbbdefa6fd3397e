#!/usr/bin/env -S /usr/bin/python3 -I -B
"""The tables of deploy/options.md, made from what the programs say of their options (--help).

METRONOME_BUILD (default: build/) says which programs. Run as a command, it puts the tables into the page.
"""

import functools
import os
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("METRONOME_BUILD", ROOT / "build"))
PAGE = ROOT / "deploy" / "options.md"
OPTION = re.compile(r" {2,}(-.*?)(?: {2,}(.*))?")


@functools.cache
def help_of(*command):
    """What `command` --help prints; on wide lines, so that it breaks no word."""
    said = subprocess.run([*command, "--help"], capture_output=True, text=True, check=True,
                          env={**os.environ, "COLUMNS": "1000"})
    return said.stdout


def options_of(text):
    """[(option with its value, what it does)] of a help text."""
    found = []
    for line in text.splitlines():
        option = OPTION.fullmatch(line)
        if option and len(line) - len(line.lstrip()) < 8:
            found.append([option[1].strip(), option[2] or ""])
        elif found and line.startswith(" " * 8):
            found[-1][1] = f"{found[-1][1]} {line.strip()}".strip()
    return [tuple(row) for row in found if not row[0].startswith("-h")]


def names_of(option):
    """The names in `--runs-dir,--runs DIR`."""
    return set(re.findall(r"--[a-z][a-z-]*", option))


def table_of(rows):
    """Markdown. How many cores this machine has is not part of the page."""
    lines = ["| option | meaning |", "| --- | --- |"]
    for option, meaning in rows:
        meaning = re.sub(r", here \d+", "", meaning).replace("|", r"\|").replace("<", "&lt;")
        lines.append(f"| `{option}` | {meaning} |")
    return "\n".join(lines)


def tables():
    """{name: Markdown}: options of deploy/train alone, of a learner, of an actor."""
    learner = options_of(help_of(BUILD / "bin" / "metronome-learner", "run"))
    actor = options_of(help_of(BUILD / "bin" / "metronome-actor", "run"))
    train = options_of(help_of(ROOT / "deploy" / "train", "--build", BUILD))
    theirs = set().union(*(names_of(option) for option, _ in learner))
    own = [row for row in train if not names_of(row[0]) & theirs]
    return {"deploy/train": table_of(own), "metronome-learner run": table_of(learner),
            "metronome-actor run": table_of(actor)}


def filled(text):
    """@return `text` with each table between its marks."""
    for name, table in tables().items():
        begin, end = f"<!-- options {name} -->", "<!-- end -->"
        text, places = re.subn(f"({begin}).*?({end})", lambda marks: f"{marks[1]}\n\n{table}\n\n{marks[2]}", text, flags=re.DOTALL)
        assert places == 1, f"{PAGE.name} has {places} places for the options of {name}"
    return text


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text()))
