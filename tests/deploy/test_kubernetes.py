"""The Kubernetes manifests: held against Kubernetes' own schemas, their command lines carried out."""

import json
import subprocess

import pytest

import environments
from harness import BUILD, ROOT, SMALL

MANIFEST = ROOT / "deploy" / "kubernetes" / "metronome.yaml"
REQUIREMENTS = ROOT / "tests" / "deploy" / "requirements.txt"
VERSIONS = ("1.28", "1.31", "1.34")


@pytest.fixture(scope="module")
def tools():
    """bin/ of a virtual environment with kubernetes-validate and PyYAML."""
    return environments.python("kubernetes", REQUIREMENTS) / "bin"


@pytest.fixture(scope="module")
def documents(tools):
    """@return the manifest's objects by their kind."""
    read = "import json, sys, yaml; print(json.dumps(list(yaml.safe_load_all(open(sys.argv[1])))))"
    text = subprocess.run(
        [tools / "python", "-c", read, MANIFEST], capture_output=True, text=True, check=True
    ).stdout
    return {document["kind"]: document for document in json.loads(text)}


def pod(document):
    return document["spec"]["template"]


def command(document, replaced):
    """The container's words, with options for the test in place of the manifest's."""
    (container,) = pod(document)["spec"]["containers"]
    words = container["command"] + replaced
    return [
        word.replace("/usr/share/metronome", str(ROOT / "deploy")).replace("/usr/bin", str(BUILD / "bin"))
        for word in words
    ]


@pytest.mark.parametrize("version", VERSIONS)
def test_the_manifest_keeps_to_the_schemas_of_kubernetes(tools, version):
    verdict = subprocess.run(
        [tools / "python", tools / "kubernetes-validate", "--strict", "-k", version, MANIFEST],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert verdict.returncode == 0, verdict.stdout + verdict.stderr
    assert (verdict.stdout + verdict.stderr).count(" passed ") == 3


def test_the_service_is_headless_and_finds_the_learner_alone(documents):
    service = documents["Service"]["spec"]
    assert service["clusterIP"] == "None"

    def finds(document):
        return service["selector"].items() <= pod(document)["metadata"]["labels"].items()

    assert finds(documents["StatefulSet"]) and not finds(documents["Deployment"])
    assert documents["StatefulSet"]["spec"]["serviceName"] == documents["Service"]["metadata"]["name"]


def test_actors_look_for_the_learner_by_the_name_of_the_service(documents):
    (container,) = pod(documents["Deployment"])["spec"]["containers"]
    network = container["args"][container["args"].index("--network") + 1]
    assert network == documents["Service"]["metadata"]["name"]


def test_the_containers_commands_train_over_unicast(stage, documents, monkeypatch):
    monkeypatch.setenv("METRONOME_BIN", str(BUILD / "bin"))
    domain = ["--domain", str(stage.domain)]
    words = command(documents["StatefulSet"], [*SMALL, *domain, "--network", "lan"])
    words[words.index("/runs")] = str(stage.runs)
    learner = stage.start(*words)
    actor = stage.start(
        *command(documents["Deployment"], [*domain, "--network", "localhost"])
    )
    assert learner.wait() == 0, learner
    assert actor.child.poll() is None, "an actor with --stay waits for the next run"
    stage.train("calm")
    ends = [stage.inspect(stage.latest(name))["weights_sha256"] for name in ("push", "calm")]
    assert ends[0] == ends[1]
