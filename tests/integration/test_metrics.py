"""A running run seen by Prometheus: Debian's promtool and a real server."""

import json
import re
import socket
import subprocess
import time
import urllib.parse
import urllib.request

import pytest

from harness import DEADLINE, ENDLESS, ROOT, SMALL

PROMETHEUS = ROOT / "deploy" / "prometheus"
DASHBOARD = ROOT / "deploy" / "grafana" / "metronome.json"
NAME = re.compile(r"\bmetronome_[a-z0-9_]+")


def read(url):
    with urllib.request.urlopen(url, timeout=10) as answer:
        return answer.read().decode()


def poll(get, what, seconds=DEADLINE):
    """Waits, without an event, for the word of a server of others. @return what is true of `get()`."""
    deadline = time.monotonic() + seconds
    while True:
        try:
            found = get()
        except OSError:
            found = None
        if found:
            return found
        assert time.monotonic() < deadline, f"after {seconds} s not: {what}"
        time.sleep(0.1)


def promtool(*words, stdin=None):
    return subprocess.run(
        ["promtool", *words], input=stdin, capture_output=True, text=True, timeout=60
    )


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def series(scrape, name):
    return [line for line in scrape.splitlines() if re.match(name + r"[ {]", line)]


@pytest.fixture
def run(stage):
    """@return a running learner with two actors, and where its metrics are."""
    learner = stage.learner("shown", "--metrics", "0", small=ENDLESS)
    url = learner.expect(
        lambda line: (re.search(r"http://127\.0\.0\.1:\d+/metrics", line) or [None])[0], "a URL"
    )
    actors = [stage.actor("shown") for _ in range(2)]
    learner.expect_update(2)
    return learner, actors, url


@pytest.mark.slow
def test_promtool_finds_nothing_to_say_of_a_scrape_and_who_leaves_is_not_in_it(run):
    _, actors, url = run
    name = f'actor="[^"]*:{actors[0].child.pid}"'

    def both():
        text = read(url)
        return text if len(series(text or "", "metronome_actor_assignments")) == 2 else None

    scrape = poll(both, "both actors")
    verdict = promtool("check", "metrics", stdin=scrape)
    assert verdict.returncode == 0 and verdict.stdout + verdict.stderr == "", verdict
    assert [line for line in series(scrape, "metronome_info") if 'task="push"' in line]

    shown = set(NAME.findall(scrape))
    for file in (DASHBOARD, PROMETHEUS / "alerts.yml"):
        assert set(NAME.findall(file.read_text())) <= shown, file

    actors[0].kill()
    rest = poll(lambda: not re.search(name, text := read(url)) and text, "one actor less")
    assert len(series(rest, "metronome_actor_assignments")) == 1


@pytest.mark.slow
def test_a_prometheus_server_scrapes_a_run_and_knows_the_alerts(stage, run, tmp_path):
    learner, _, url = run
    config = (PROMETHEUS / "prometheus.yml").read_text()
    for old, new in (
        ("localhost:9464", urllib.parse.urlsplit(url).netloc),
        ("scrape_interval: 5s", "scrape_interval: 200ms"),
        ("alerts.yml", str(PROMETHEUS / "alerts.yml")),
    ):
        assert config.count(old) == 1
        config = config.replace(old, new)
    (tmp_path / "prometheus.yml").write_text(config)
    place = f"127.0.0.1:{free_port()}"
    server = stage.start(
        "prometheus",
        f"--config.file={tmp_path}/prometheus.yml",
        f"--storage.tsdb.path={tmp_path}/data",
        f"--web.listen-address={place}",
    )

    def ask(query):
        answer = read(f"http://{place}/api/v1/query?" + urllib.parse.urlencode({"query": query}))
        return json.loads(answer)["data"]["result"]

    (updates,) = poll(lambda: ask('metronome_updates_total{run="shown"} > 2'), server)
    assert updates["metric"]["job"] == "metronome"
    learner.expect_update(int(updates["value"][1]) + 1)
    poll(lambda: ask(f"metronome_updates_total > {updates['value'][1]}"), "later updates")
    assert len(ask("metronome_actor_steps_per_second")) == 2
    (group,) = json.loads(read(f"http://{place}/api/v1/rules"))["data"]["groups"]
    assert {rule["lastError"] for rule in group["rules"] if "lastError" in rule} == set()
    assert len(group["rules"]) == (PROMETHEUS / "alerts.yml").read_text().count("- alert:")


@pytest.mark.slow
def test_alerts_are_raised_for_runs_that_need_somebody_and_for_no_others():
    for words in (
        ("check", "rules", PROMETHEUS / "alerts.yml"),
        ("check", "config", PROMETHEUS / "prometheus.yml"),
        ("test", "rules", ROOT / "tests" / "integration" / "prometheus" / "alerts_test.yml"),
    ):
        verdict = promtool(*words)
        assert verdict.returncode == 0, verdict.stdout + verdict.stderr


@pytest.mark.slow
def test_a_second_learner_of_a_run_is_told_of_the_first_and_not_of_the_port(stage, run):
    second = stage.learner("shown", "--metrics", run[2].split("/")[2], "--resume", small=ENDLESS)
    assert second.wait(30) == 4, second


def test_a_port_in_use_is_named_before_anything_starts(stage):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        place = f"127.0.0.1:{taken.getsockname()[1]}"
        learner = stage.learner("none", "--metrics", place, small=SMALL)
        assert learner.wait(30) == 2, learner
    for word in ("--metrics", place, "in use"):
        assert word in learner.text, learner
    assert not (stage.runs / "none").exists()
