"""Every relative link of every page leads somewhere: the file is there, tracked, and has the heading."""

import posixpath
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r'\]\(([^)\s]+)\)|\b(?:src|href)="([^"]+)"')


def tracked(*patterns):
    names = subprocess.run(["git", "ls-files", "-z", *patterns], cwd=ROOT, capture_output=True, text=True, check=True)
    return names.stdout.split("\0")[:-1]


def prose_of(text):
    """Without blocks of code and code within lines, where nothing is a link or a heading."""
    text = re.sub(r"^( *)(```+).*?^ *\2\n", "", text, flags=re.DOTALL | re.MULTILINE)
    return text, re.sub(r"`[^`\n]*`", "", text)


def anchors_of(text):
    """The names that GitHub gives to the headings of a page."""
    found = {}
    for heading in re.findall(r"^#{1,6} +(.*?) *#*$", prose_of(text)[0], re.MULTILINE):
        shown = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", shown.lower()).replace(" ", "-")
        found[name] = found.get(name, -1) + 1
    return {name if copy == 0 else f"{name}-{copy}" for name, copies in found.items() for copy in range(copies + 1)}


def broken(page, text, pages, files):
    """Links of `text`, which stands at the path `page`, that lead nowhere.
    @param pages  {path: text} of all pages. @param files  paths of all files and folders."""
    for match in LINK.finditer(prose_of(text)[1]):
        target = match[1] or match[2]
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        at = posixpath.normpath(posixpath.join(posixpath.dirname(page), path)) if path else page
        if at not in files:
            yield f"{page}: {target}: there is no {at}"
        elif anchor and anchor not in anchors_of(pages.get(at, "")):
            yield f"{page}: {target}: {at} has no such heading"


@pytest.fixture(scope="module")
def pages():
    return {name: (ROOT / name).read_text() for name in tracked("*.md")}


def test_every_link_of_every_page_leads_somewhere(pages):
    files = set(tracked())
    for name in tuple(files):
        files.update(map(str, Path(name).parents))
    assert [fault for name, text in pages.items() for fault in broken(name, text, pages, files)] == []


def test_links_that_lead_nowhere_are_found():
    pages = {"a/README.md": "# Two `words`\n[x](b.md#no) [y](#two-words) [z](../gone) [w](https://x.org)\n"
                            '```sh\n[not](a-link)\n# not a heading\n```\n<img src="c.png">',
             "a/b.md": "## Yes\n"}
    assert [fault.partition(": ")[2] for fault in broken("a/README.md", pages["a/README.md"], pages, {*pages, "a"})] == [
        "b.md#no: a/b.md has no such heading", "../gone: there is no gone", "c.png: there is no a/c.png"]
