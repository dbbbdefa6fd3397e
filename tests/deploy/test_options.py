"""deploy/options.md has every option of deploy/train, metronome-learner run and metronome-actor run, none that does not
exist, and says of each what --help says."""

import re

import pytest

import options_page
from harness import ACTOR, BUILD, LEARNER, ROOT

SET_BY_THE_LAUNCHER = {"--progress", "--runs-dir", "--log-format"}


def first_columns(heading):
    """Option names of the table below a heading of the page."""
    section = options_page.PAGE.read_text().partition(f"## `{heading}`\n")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| `(.*?)` \|", section, re.MULTILINE)
    return options_page.names_of(" ".join(row.split(" ")[0] for row in rows))


def helped(*command):
    """Option names by which lines of --help begin: read in another way than the page's tables are."""
    text = options_page.help_of(*command)
    return set(re.findall(r"--[a-z-]+", " ".join(re.findall(r"^ {2,6}(-\S+(?:, --\S+)?)", text, re.MULTILINE)))) - {"--help"}


@pytest.mark.parametrize("heading, program", [("metronome-learner run", LEARNER), ("metronome-actor run", ACTOR)])
def test_every_option_of_a_program_is_on_the_page_and_no_other(heading, program):
    assert first_columns(heading) == helped(program, "run")


def test_every_option_of_the_launcher_is_on_the_page_and_no_other():
    said = helped(ROOT / "deploy" / "train", "--build", BUILD)
    theirs = first_columns("metronome-learner run")
    assert first_columns("deploy/train") == said - theirs
    # TASK stands in place of --task.
    assert theirs - said == SET_BY_THE_LAUNCHER | {"--task"}


def test_the_page_says_of_each_option_what_help_says():
    page = options_page.PAGE.read_text()
    assert page == options_page.filled(page), "make its tables anew: tests/deploy/options_page.py"
