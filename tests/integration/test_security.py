"""Runs with --security: who may take part, what each may do, and what others get to see."""

import shutil
import signal
import stat
import struct
import subprocess
import sys

import pytest

import capture
import namespaces
from harness import ACTOR, BUILD, ENDLESS, LEARNER, LONG, LONG_UPDATES, ROOT, SMALL, parse_json
from test_clocks import LIBRARY, Clock

sys.path.insert(0, str(ROOT / "deploy" / "credentials"))
import authority  # noqa: E402
import roles  # noqa: E402

USAGE, NO_LEARNER = 2, 3  # exit codes
TURNED_AWAY = "turned away"


def security(folder, *options):
    """deploy/security. @return its finished process."""
    return subprocess.run(
        [str(ROOT / "deploy" / "security"), str(folder), *map(str, options)],
        capture_output=True,
        text=True,
    )


def make(folder, run, domain, *options):
    made = security(folder, "--run", run, "--domain", domain, "--actors", 1, *options)
    assert made.returncode == 0, made.stderr
    return folder


@pytest.fixture
def identities(stage, tmp_path):
    """Of run "run": folders learner, observer and actor-0."""
    return make(tmp_path / "identities", "run", stage.domain)


@pytest.fixture(scope="module")
def expected(module_stage):
    """The weights of the same run without security, and nobody else near."""
    return module_stage.train("calm")


def secured(folder):
    return ("--security", folder)


class Stopped(Exception):
    """In place of a signal."""


def whole_identities(folder):
    """Names of the identities that are whole; their keys and certificates must fit."""
    found = set()
    for path in folder.glob(f"*/{authority.CERTIFICATE}"):
        certificate = authority.x509.load_pem_x509_certificate(path.read_bytes())
        key = authority.load_pem_private_key((path.parent / authority.KEY).read_bytes(), None)
        public = certificate.public_key().public_numbers()
        assert key.public_key().public_numbers() == public, path.parent.name
        assert {file.name for file in path.parent.iterdir()} >= {authority.GOVERNANCE, authority.PERMISSIONS}
        found.add(path.parent.name)
    return found


@pytest.mark.parametrize("writes", [0, 2, 4, 6, 10, 13, 17])
@pytest.mark.slow
def test_credentials_whose_making_was_stopped_are_gone_on_with(tmp_path, monkeypatch, writes):
    folder, done = tmp_path / "identities", []

    def write(path, data, secret=False, whole=authority._write):
        if len(done) == writes:
            raise Stopped
        done.append(path)
        whole(path, data, secret)

    with monkeypatch.context() as patch:
        patch.setattr(authority, "_write", write)
        with pytest.raises(Stopped):
            made = authority.Authority.make(folder, "run", 0)
            made.save()
            made.issue("learner", authority.datetime.timedelta(days=1))
            made.issue("learner", authority.datetime.timedelta(days=1))  # renewed
    whole_identities(folder)
    make(folder, "run", 0)
    assert whole_identities(folder) == {"learner", "observer", "actor-0"}


@pytest.mark.parametrize("transport", ["udp", "shm"])
@pytest.mark.slow
def test_a_secured_run_ends_with_the_weights_of_an_unsecured_one(
    stage, identities, expected, transport
):
    learner = stage.learner("run", *secured(identities / "learner"), "--transport", transport)
    actor = stage.actor("run", *secured(identities / "actor-0"), "--transport", transport)
    assert stage.finish("run", learner, [actor]) == expected


@pytest.mark.slow
def test_an_observer_sees_a_secured_run_by_its_identity_alone(stage, tmp_path):
    identities = make(tmp_path / "identities", "seen", stage.domain)
    learner = stage.learner("seen", *secured(identities / "learner"))
    learner.expect_event("started")
    status = (LEARNER, "status", "seen", "--domain", stage.domain, "--json")
    blind = stage.start(*status, "--wait", 1.5)
    seeing = stage.start(*status, *secured(identities / "observer"))
    assert seeing.wait() == 0, seeing
    assert parse_json(seeing.output[-1])["run_name"] == "seen"
    assert blind.wait() == NO_LEARNER, blind


@pytest.mark.slow
def test_resuming_needs_no_word_of_security_to_be_secured(stage, identities):
    expected = stage.train("calm", small=LONG)
    learner = stage.learner("run", *secured(identities / "learner"), small=LONG)
    actor = stage.actor("run", *secured(identities / "actor-0"))
    learner.expect_update(2)
    learner.signal(signal.SIGINT)
    assert learner.wait() == 130, learner
    stranger = stage.actor("run", "--wait", 2)
    again = stage.learner("run", "--resume", small=())
    assert stage.finish("run", again, [actor], LONG_UPDATES) == expected
    assert stranger.wait() == NO_LEARNER, stranger


@pytest.mark.slow
def test_outsiders_get_nothing_and_change_nothing(stage, identities, tmp_path, expected):
    foreign, strange = (
        make(tmp_path / name, "run", stage.domain) for name in ("foreign", "strange")
    )
    # The name of an authority is no proof: a certificate by another key.
    posing = shutil.copytree(identities / "actor-0", tmp_path / "posing")
    for file in (authority.KEY, authority.CERTIFICATE, authority.IDENTITY_CA):
        shutil.copy(foreign / "actor-0" / file, posing)
    learner = stage.learner("run", *secured(identities / "learner"))
    learner.expect_event("started")
    outsiders = [
        stage.actor("run", "--wait", 2, *options)
        for options in ((), secured(foreign / "actor-0"), secured(posing))
    ]
    learner.expect_text(TURNED_AWAY)
    stranger = stage.learner("run", *secured(strange / "learner"), runs=tmp_path / "elsewhere")
    stranger.expect_event("started")  # as a second learner it would be refused
    for outsider in outsiders:
        assert outsider.wait() == NO_LEARNER, outsider
    actor = stage.actor("run", *secured(identities / "actor-0"))
    assert stage.finish("run", learner, [actor]) == expected
    joined = [line for line in learner.lines if "joins" in line]
    assert len(joined) == 1 and f":{actor.child.pid} " in joined[0], learner
    assert "joins" not in stranger.text, stranger
    for process in (learner, *outsiders):
        assert len(process.lines) < 60, process  # no endless complaints


@pytest.mark.slow
def test_an_actors_host_is_its_certificate_whatever_its_process_or_address(stage, tmp_path):
    folder = make(tmp_path / "two", "run", stage.domain, "--actors", 2)
    learner = stage.learner("run", *secured(folder / "learner"), small=ENDLESS)

    def host_of(identity):
        actor = stage.actor("run", *secured(folder / identity))
        line = learner.expect_text(f":{actor.child.pid} joins with")
        actor.kill()
        return line.split(", from ")[1]

    first, again, other = (host_of(identity) for identity in ("actor-0", "actor-0", "actor-1"))
    assert first.startswith("certificate ") and first == again != other, (first, again, other)
    learner.kill()


@pytest.mark.skipif(LIBRARY is None, reason="needs Debian's package libfaketime")
@pytest.mark.slow
def test_an_expired_identity_is_turned_away_though_its_owner_sets_back_the_clock(
    stage, identities, tmp_path, expected
):
    today = authority.datetime.datetime
    owner = authority.Authority.load(identities)
    owner.issue("late", -authority.DAY / 2)  # began a day ago, ended half a day ago
    assert owner.expires("late") < today.utcnow()
    honest = stage.actor("run", *secured(identities / "late"))
    assert honest.wait() == USAGE, honest
    assert str(identities / "late" / authority.CERTIFICATE) in honest.text
    assert "expired on" in honest.text
    clock = Clock(tmp_path / "clock")
    clock.jump("-18h")
    learner = stage.learner("run", *secured(identities / "learner"))
    learner.expect_event("started")
    cheat = stage.actor("run", "--wait", 2, *secured(identities / "late"), host=clock)
    learner.expect_text(TURNED_AWAY)
    assert cheat.wait() == NO_LEARNER, cheat
    actor = stage.actor("run", *secured(identities / "actor-0"))
    assert stage.finish("run", learner, [actor]) == expected


@pytest.mark.slow
def test_a_revoked_identity_is_turned_away_and_a_new_one_taken(
    stage, identities, tmp_path, expected
):
    leaked = shutil.copytree(identities / "actor-0", tmp_path / "leaked")
    done = security(identities, "--revoke", "actor-0")
    assert done.returncode == 0, done.stderr
    assert security(identities, "--actor", "another").returncode == 0
    owner = stage.actor("run", *secured(identities / "actor-0"))
    assert owner.wait() == USAGE and "is revoked" in owner.text, owner
    learner = stage.learner("run", *secured(identities / "learner"))
    learner.expect_event("started")
    thief = stage.actor("run", "--wait", 2, *secured(leaked))
    learner.expect_text(TURNED_AWAY)
    assert thief.wait() == NO_LEARNER, thief
    actor = stage.actor("run", *secured(identities / "another"))
    assert stage.finish("run", learner, [actor]) == expected


@pytest.mark.slow
def test_an_actor_cannot_give_itself_the_permissions_of_a_learner(
    stage, identities, tmp_path, expected
):
    """The strongest forgery that our own programs can carry: an actor's genuine identity, with
    permissions that it signed itself, once by an authority of its own and once by its identity."""
    own = authority.Authority.make(tmp_path / "own", "run", stage.domain)
    actor_key = authority.load_pem_private_key(
        (identities / "actor-0" / authority.KEY).read_bytes(), None
    )
    certificate = authority._load(identities / "actor-0" / authority.CERTIFICATE)
    learner = stage.learner("run", *secured(identities / "learner"))
    actor = stage.actor("run", *secured(identities / "actor-0"))
    learner.expect_update(1)
    pretenders = []
    for name, signer in (
        ("own", own._permissions),
        ("identity", authority.Signer(actor_key, certificate)),
    ):
        folder = shutil.copytree(identities / "actor-0", tmp_path / f"pretender-{name}")
        subject = certificate.subject.rfc4514_string()
        wanted = roles.permissions(
            *("learner", subject, "run", stage.domain),
            *(certificate.not_valid_before, certificate.not_valid_after),
        )
        (folder / authority.PERMISSIONS).write_bytes(signer.sign(wanted))
        (folder / authority.GOVERNANCE).write_bytes(signer.sign(roles.governance(stage.domain)))
        (folder / authority.PERMISSIONS_CA).write_bytes(signer.pem())
        pretenders.append(
            stage.learner("run", *secured(folder), runs=tmp_path / f"runs-{name}")
        )
    assert stage.finish("run", learner, [actor]) == expected
    for pretender in pretenders:
        assert pretender.updates() == 0, pretender
        assert "joins" not in pretender.text, pretender


def intrude(stage, folder, topic):
    """@return what becomes of a writer of the topic that has the identity in `folder`."""
    process = stage.start(BUILD / "bin" / "dds_intruder", "run", stage.domain, folder, topic)
    assert process.wait() == 0, process
    # Fast DDS writes its own lines to standard output too, before this one or after it.
    fates = ("is read", "is not read", "may not be written")
    (fate,) = [line.strip() for line in process.output if line.strip() in fates]
    return fate


@pytest.mark.parametrize("name", ["actor-0", "observer"])
@pytest.mark.slow
def test_an_identity_may_write_the_topics_of_its_role_alone(stage, identities, name):
    learner = stage.learner("run", *secured(identities / "learner"))
    learner.expect_event("started")
    actor_s = "is read" if name == "actor-0" else "may not be written"
    assert intrude(stage, identities / name, "episode") == actor_s
    for topic in ("run_description", "episode_assignment", "policy_snapshot"):
        assert intrude(stage, identities / name, topic) == "may not be written", topic


@pytest.mark.slow
def test_an_actor_that_loosens_its_own_rules_is_heard_by_nobody(stage, identities, tmp_path):
    """Genuine identity and permissions, but rules of its own that let it write anything."""
    # Of another name: OpenSSL looks the signer up by it, and the genuine one is there too.
    own = authority.Authority.make(tmp_path / "own", "own", stage.domain)
    loose = shutil.copytree(identities / "actor-0", tmp_path / "loose")
    with open(loose / authority.PERMISSIONS_CA, "ab") as known:
        known.write(own._permissions.pem())
    rules = roles.governance(stage.domain).replace(
        "<enable_write_access_control>true", "<enable_write_access_control>false"
    )
    (loose / authority.GOVERNANCE).write_bytes(own._permissions.sign(rules))
    learner = stage.learner("run", *secured(identities / "learner"))
    learner.expect_event("started")

    assert intrude(stage, identities / "actor-0", "episode") == "is read"  # so it would be heard
    assert intrude(stage, loose, "episode") == "is not read"
    assert intrude(stage, loose, "run_description") == "is not read"


def test_a_learner_is_not_started_by_the_identity_of_an_actor(stage, identities):
    learner = stage.learner("run", *secured(identities / "actor-0"))
    assert learner.wait() == USAGE, learner
    assert 'role "actor"' in learner.text and str(identities / "actor-0") in learner.text
    assert not (stage.runs / "run").exists()  # the next try finds no half-made run
    actor = stage.actor("run", *secured(identities / "learner"))
    assert actor.wait() == USAGE and 'role "learner"' in actor.text, actor


def _unlink(file):
    return lambda folder, identities: (folder / file).unlink()


def _garble(file):
    return lambda folder, identities: (folder / file).write_text("nonsense\n")


def _swap(file):
    """One of another identity's files."""
    return lambda folder, identities: shutil.copy(identities / "observer" / file, folder)


def _loosen(folder, identities):
    path = folder / authority.GOVERNANCE
    path.write_text(path.read_text().replace(">ENCRYPT<", ">NONE<"))


@pytest.mark.parametrize(
    ("spoil", "file", "words"),
    [
        (lambda folder, identities: shutil.rmtree(folder), "", "is not a folder"),
        (_unlink(authority.KEY), authority.KEY, "is missing"),
        (_unlink(authority.GOVERNANCE), authority.GOVERNANCE, "is missing"),
        (_garble(authority.CERTIFICATE), authority.CERTIFICATE, "is no certificate"),
        (_garble(authority.PERMISSIONS), authority.PERMISSIONS, "is not signed by"),
        (_swap(authority.KEY), authority.KEY, "is not the key of"),
        (_swap(authority.PERMISSIONS), authority.PERMISSIONS, "CN=observer,O=run's, but"),
        (_loosen, authority.GOVERNANCE, "was changed"),
    ],
    ids=["nothing", "no key", "no governance", "no certificate", "no permissions", "other key",
         "other permissions", "loosened"],
)
@pytest.mark.slow
def test_an_identity_that_is_not_whole_is_refused_by_file_and_reason(
    stage, identities, tmp_path, spoil, file, words
):
    folder = shutil.copytree(identities / "actor-0", tmp_path / "spoilt")
    spoil(folder, identities)
    actor = stage.actor("run", *secured(folder))
    assert actor.wait() == USAGE, actor
    assert str(folder / file) in actor.text and words in actor.text, actor


def test_an_identity_is_for_one_run_and_one_domain(stage, identities):
    folder = identities / "actor-0"
    actor = stage.actor("other", *secured(folder))
    assert actor.wait() == USAGE and "is for run run, not other" in actor.text, actor
    actor = stage.start(ACTOR, "run", "--run", "run", "--domain", 0, *secured(folder))
    assert actor.wait() == USAGE and f"for domain {stage.domain}, not 0" in actor.text, actor


@pytest.mark.skipif(capture.unavailable() is not None, reason=str(capture.unavailable()))
@pytest.mark.slow
def test_an_eavesdropper_sees_the_content_of_an_unsecured_run_alone(stage, identities):
    placement = stage.start(
        *(ACTOR, "placements", "--task", "push", "--mode", "random", "--seed", 7, "--count", 1)
    )
    assert placement.wait() == 0, placement
    goal = [float(number) for number in placement.output[-1].split(",")[3:5]]
    patterns = {
        "the goal in each observation of episode 0": struct.pack("<2f", *goal),
        "the engine that the run description names": b"mujoco-2.2.2\0",
    }
    options = {
        "plain": ((), ()),
        "secured": (secured(identities / "learner"), secured(identities / "actor-0")),
    }
    seen = {}
    for name, (for_learner, for_actor) in options.items():
        with capture.Capture(stage.domain) as seen[name]:
            learner = stage.learner("run", *for_learner, runs=stage.runs / name)
            actor = stage.actor("run", *for_actor)
            assert learner.wait() == 0, learner
            assert actor.wait() == 0, actor
    for what, pattern in patterns.items():
        assert seen["plain"].count(pattern) > 0, what
        assert seen["secured"].count(pattern) == 0, what
    assert seen["secured"].count() > 50


@pytest.mark.skipif(
    namespaces.unavailable() is not None, reason=str(namespaces.unavailable())
)
@pytest.mark.slow
def test_secured_machines_find_each_other_across_routed_networks(stage, tmp_path, expected):
    identities = make(tmp_path / "identities", "run", 0)
    with namespaces.Network() as network:
        here, there = network.host("learner"), network.host("actor")
        learner = stage.start(
            *here.process(LEARNER, "run", "--run", "run", "--runs", stage.runs, *SMALL),
            *("--network", "lan", *secured(identities / "learner")),
        )
        actor = stage.start(
            *there.process(ACTOR, "run", "--run", "run", "--network", here.address),
            *secured(identities / "actor-0"),
        )
        assert stage.finish("run", learner, [actor]) == expected


@pytest.mark.slow
def test_train_secures_its_own_children_and_goes_on_secured(stage, tmp_path, expected):
    train = (
        *(ROOT / "deploy" / "train", "--build", authority.Path(LEARNER).parents[1]),
        *("--run", "run", "--runs", stage.runs, "--domain", stage.domain, "--actors", 2),
    )
    learnt = stage.start(*train, *SMALL[1:], "--security", tmp_path / "identities")
    assert learnt.wait() == 0, learnt
    assert stage.inspect(stage.latest("run"))["weights_sha256"] == expected
    assert (tmp_path / "identities" / "actor-1" / authority.KEY).exists()
    # Not each: in a short run one may come too late.
    logs = [log.read_text() for log in (stage.runs / "run" / "logs").glob("actor-*.log")]
    assert len(logs) == 2 and any("joined" in log for log in logs), logs


def test_keys_are_for_their_owner_alone_and_authorities_stay_apart(identities):
    keys = list(identities.glob("**/*key.pem"))
    assert len(keys) == 5  # learner, observer, actor-0, two authorities
    for key in keys:
        assert stat.S_IMODE(key.stat().st_mode) == 0o600, key
    assert stat.S_IMODE((identities / authority.FOLDER).stat().st_mode) == 0o700


@pytest.mark.slow
def test_identities_are_added_and_renewed_and_never_mixed(identities, tmp_path):
    def certificate(name):
        return (identities / name / authority.CERTIFICATE).read_bytes()

    before = certificate("actor-0")
    assert "actor-1" in security(identities, "--actors", 2).stdout
    assert certificate("actor-0") == before
    assert security(identities, "--renew", "--days", 5).returncode == 0
    assert certificate("actor-0") != before
    mixed = security(identities, "--run", "other")
    assert mixed.returncode == 1 and "is for run run, not other" in mixed.stderr
    assert security(tmp_path / "new").returncode == 1
    unknown = security(identities, "--revoke", "nobody")
    assert unknown.returncode == 1 and "nothing was issued to nobody" in unknown.stderr
