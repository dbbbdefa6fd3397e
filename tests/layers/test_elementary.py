"""No number that bits follow from comes from the C library's exp, sin and their like, whose last bits differ by processor
and by version: common/numbers/elementary.h has our own."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("actor", "common", "learner")
# What IEEE 754 rounds exactly (sqrt, fma, fmod), and what rounds to integers, is not among them.
NAMES = (r"(?:exp|exp2|expm1|log|log2|log10|log1p|pow|sin|cos|tan|sincos|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh"
         r"|atanh|hypot|cbrt|erf|erfc|tgamma|lgamma)[fl]?")
CALL = re.compile(
    rf"std::{NAMES}\b|\b__builtin_{NAMES}\b|(?<![\w.:>]){NAMES}\s*\(|(?<!\w)::{NAMES}\s*\("
    # of Eigen, which has variants by processor too, or calls the C library
    rf"|[.>]{NAMES}\(\s*\)|[.>]pow\(|\bAngleAxis[fd]?\b|\b(?:slerp|angularDistance|eulerAngles|canonicalEulerAngles)\("
    r"|std::(?:polar|arg|complex)\b|std::(?!uniform_int_)\w+_distribution\b")
MEANT = {
    "actor/play/canonical_episode.cc": "shows whether two hosts' C libraries give an engine the same numbers",
    "actor/render/head_colors.cc": "colours of a picture",
    "actor/render/path_geoms.cc": "lengths in a picture",
}


def sources():
    names = subprocess.run(["git", "ls-files", "*.h", "*.cc"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [name for name in names.stdout.split() if name.split("/")[0] in PARTS]


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


def calls(name, root=ROOT):
    text = re.sub(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', blank, (root / name).read_text(), flags=re.DOTALL)
    return [f"{name}:{text.count(chr(10), 0, match.start()) + 1}: {match[0].rstrip(' (')}" for match in CALL.finditer(text)]


def test_nothing_that_bits_follow_from_calls_the_c_librarys_elementary_functions():
    assert [call for name in sources() if name not in MEANT for call in calls(name)] == []


def test_every_exception_is_needed():
    assert [name for name in sorted(MEANT) if not calls(name)] == []


@pytest.mark.parametrize("line", (
    "y = std::exp(x);", "y = exp(x);", "y = ::sinf(x);", "f(std::tanh);", "y = std::atan2 (a, b);", "y = __builtin_pow(x, 2);",
    "m = m.array().tanh();", "m = m->array().pow(2);", "Eigen::AngleAxisd(a, b)", "std::normal_distribution<double> d;",
    "y = -log(x);", "return hypot(a, b);"))
def test_a_call_is_found(tmp_path, line):
    (tmp_path / "a.cc").write_text(f"#include <cmath>\n\n{line}\n")
    found, = calls("a.cc", tmp_path)
    assert found.startswith("a.cc:3: ")


@pytest.mark.parametrize("line", (
    "y = numbers::Exp(x);", "y = std::sqrt(x);", "log_->log(level, text);", "// y = std::exp(x);", 'throw Error("exp(x)");',
    "const double log_std = 1;", "y = Log(x);", "y = numbers::Pow(a, b);", "log.Add(1);", "y = std::fma(a, b, c);"))
def test_what_is_none_is_not(tmp_path, line):
    (tmp_path / "a.cc").write_text(line)
    assert calls("a.cc", tmp_path) == []
