"""Options alone say how a run is joined: what Fast DDS would take from the environment and from the
current folder by itself is not used."""

import json
import signal
from pathlib import Path

import pytest

from harness import BUILD, EPISODES, HORIZON, parse_json, small

UPDATES = 2
SHORT = small(UPDATES * EPISODES * HORIZON)
# Of a ROS 2 user: Fast DDS would make a client of a server that is not there.
NOBODY = "127.0.0.1:11999"
HARMFUL = """<?xml version="1.0"?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <log>
    <use_default>FALSE</use_default>
    <consumer><class>FileConsumer</class>
      <property><name>filename</name><value>fast_dds.log</value></property></consumer>
  </log>
  <library_settings><intraprocess_delivery>FULL</intraprocess_delivery></library_settings>
  <profiles>
    <participant profile_name="nobody" is_default_profile="true">
      <rtps><builtin><discovery_config>
        <discoveryProtocol>CLIENT</discoveryProtocol>
        <ignoreParticipantFlags>FILTER_DIFFERENT_PROCESS</ignoreParticipantFlags>
      </discovery_config></builtin></rtps>
    </participant>
    <topic profile_name="none" is_default_profile="true">
      <historyQos><kind>KEEP_LAST</kind><depth>1</depth></historyQos>
    </topic>
  </profiles>
</dds>
"""
STATISTICS = "HISTORY_LATENCY_TOPIC;RTPS_SENT_TOPIC;PDP_PACKETS_TOPIC;EDP_PACKETS_TOPIC;DISCOVERY_TOPIC"


class Surroundings:
    """Processes in a folder and with variables of their own."""

    def __init__(self, folder, **variables):
        self.folder = folder
        self._words = [f"{name}={value}" for name, value in variables.items()]

    def process(self, *command):
        program = Path(command[0]).resolve()
        return ("env", "-C", self.folder, *self._words, program, *command[1:])


@pytest.fixture(scope="module")
def expected(module_stage):
    return module_stage.train("calm", small=SHORT)


def discovery_server(folder):
    return {"ROS_DISCOVERY_SERVER": NOBODY}


def discovery_server_from_a_file(folder):
    (folder / "environment.json").write_text(json.dumps(discovery_server(folder)), encoding="utf-8")
    return {"FASTDDS_ENVIRONMENT_FILE": folder / "environment.json"}


def profiles(folder):
    (folder / "profiles.xml").write_text(HARMFUL, encoding="utf-8")
    return {"FASTRTPS_DEFAULT_PROFILES_FILE": folder / "profiles.xml"}


def profiles_that_are_no_xml(folder):
    (folder / "profiles.xml").write_text("<dds><profiles>", encoding="utf-8")
    return {"FASTRTPS_DEFAULT_PROFILES_FILE": folder / "profiles.xml"}


def profiles_of_the_current_folder(folder):
    (folder / "DEFAULT_FASTRTPS_PROFILES.xml").write_text(HARMFUL, encoding="utf-8")
    return {}


def statistics(folder):
    return {"FASTDDS_STATISTICS": STATISTICS}


@pytest.mark.parametrize(
    "harm",
    [
        discovery_server,
        discovery_server_from_a_file,
        profiles,
        profiles_that_are_no_xml,
        profiles_of_the_current_folder,
        statistics,
    ],
    ids=lambda harm: harm.__name__,
)
@pytest.mark.slow
def test_a_run_ends_with_the_same_weights_and_says_what_is_not_used(
    stage, tmp_path, expected, harm
):
    harmed = Surroundings(tmp_path, **harm(tmp_path))
    there = set(tmp_path.iterdir())
    names = [*harm(tmp_path), *(path.name for path in there if path.name.startswith("DEFAULT"))]
    learner = stage.learner("run", small=SHORT, host=harmed)
    actor = stage.actor("run", host=harmed)
    assert stage.finish("run", learner, [actor], UPDATES) == expected
    for process in (learner, actor):
        process.expect_text(f"not used: {names[0]}")
        assert "Fast DDS" not in process.text, process
    assert set(tmp_path.iterdir()) - there == {stage.runs}


@pytest.mark.parametrize("transport", ["shm", "tcp"])
@pytest.mark.slow
def test_other_transports_keep_clear_of_the_environment_too(stage, tmp_path, expected, transport):
    harmed = Surroundings(tmp_path, **discovery_server(tmp_path))
    way = ("--transport", transport)
    learner = stage.learner("run", *way, small=SHORT, host=harmed)
    actor = stage.actor("run", *way, host=harmed)
    assert stage.finish("run", learner, [actor], UPDATES) == expected


def test_a_learner_in_calm_surroundings_is_found_from_harmful_ones(stage, tmp_path):
    harmed = Surroundings(tmp_path, **discovery_server(tmp_path))
    learner = stage.learner("run")
    learner.expect_event("started")
    status = stage.status("run", host=harmed)
    assert status.wait(20) == 0, status
    assert parse_json(status.output[-1])["run_name"] == "run"


def test_fast_dds_is_given_nothing_and_asks_for_no_more_than_is_taken_from_it(stage, tmp_path):
    taken = {
        **discovery_server(tmp_path),
        **discovery_server_from_a_file(tmp_path),
        **profiles(tmp_path),
        **statistics(tmp_path),
    }
    library = BUILD.resolve() / "tests" / "integration" / "libenvironment_asked.so"
    harmed = Surroundings(tmp_path, LD_PRELOAD=library, **taken)
    learner = stage.learner("run", small=SHORT, host=harmed)
    actor = stage.actor("run", host=harmed)
    stage.finish("run", learner, [actor], UPDATES)
    expected = {f"{name}: (nothing)" for name in taken} | {"SKIP_DEFAULT_XML_FILE: 1"}
    for process in (learner, actor):
        asked = {line.split("asks for ")[1] for line in process.lines if "asks for" in line}
        assert asked == expected, process


@pytest.mark.slow
def test_the_servers_of_the_options_are_those_that_count(stage, tmp_path, expected):
    port = 12000 + stage.domain
    server = stage.start("fast-discovery-server", "-i", "0", "-l", "127.0.0.1", "-p", port)
    server.expect_text("server is running")
    harmed = Surroundings(tmp_path, **discovery_server(tmp_path))
    way = ("--network", "lan", "--discovery-server", f"127.0.0.1:{port}")
    learner = stage.learner("run", *way, small=SHORT, host=harmed)
    actor = stage.actor("run", *way, host=harmed)
    assert stage.finish("run", learner, [actor], UPDATES) == expected
    server.signal(signal.SIGINT)  # killed, it would leave shared memory
    server.wait(20)
