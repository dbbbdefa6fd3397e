"""Neither the instructions that compute a run nor the compiler of a program decide a bit of it."""

import os
import re
import subprocess

import pytest

from harness import ACTOR, ENGINE, LEARNER, ROOT, small, updates_of

RUN = [*small(4000), "--set", "policy.hidden=32,32", "--set", "ppo.minibatch=200"]
UPDATES = updates_of(RUN)
ISAS = ("scalar", "avx2", "avx512")
# By Clang with -O1, and with sanitizers; all else here is by GCC with -O3.
OTHER_BUILD = ROOT / "build-sanitize" / "bin" / "metronome-actor"


def said_of(*words):
    """What a program says of a command line that is wrong."""
    done = subprocess.run([*words], capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout) == (2, ""), done
    return done.stderr


def supported():
    """The instruction sets of this processor, as the programs name them."""
    return re.search(r"this processor has: (.*)", said_of(LEARNER, "run", "--run", "run", "--isa", "sse"))[1].split(", ")


def require(*isas):
    missing = [isa for isa in isas if isa not in supported()]
    if missing:
        pytest.skip(f"this processor has no {' and no '.join(missing)}")


@pytest.fixture(scope="module")
def expected(module_stage):
    """weights_sha256 of a run whose processes choose their instructions themselves."""
    return module_stage.train("expected", small=RUN)


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("isa", ISAS)
@pytest.mark.slow
def test_all_instructions_give_the_same_weights_on_any_number_of_threads(stage, expected, isa, threads):
    require(isa)
    chosen = ("--isa", isa)
    assert stage.train("run", *chosen, "--threads", threads, actor_options=chosen, small=RUN) == expected
    assert stage.inspect(stage.latest("run"))["isa"] == isa


@pytest.mark.parametrize("before, after", [("scalar", "avx2"), ("avx2", "scalar"), ("avx2", "avx512"), ("avx512", "scalar")])
@pytest.mark.slow
def test_a_run_that_is_resumed_by_other_instructions_keeps_its_bits(stage, expected, before, after):
    require(before, after)
    learner, actor = stage.learner("run", "--isa", before, small=RUN), stage.actor("run")
    learner.expect_update(UPDATES // 2)
    learner.kill()
    killed = stage.inspect(stage.latest("run"))
    assert killed["version"] < UPDATES and killed["isa"] == before
    resumed = stage.learner("run", "--isa", after, "--resume", small=RUN)
    assert stage.finish("run", resumed, [actor], UPDATES) == expected
    assert stage.inspect(stage.latest("run"))["isa"] == after


@pytest.mark.parametrize("learner_isa, actor_isa", [(one, other) for one in ISAS for other in ISAS if one != other])
@pytest.mark.slow
def test_actors_of_other_instructions_than_the_learners_play_the_same_episodes(stage, expected, learner_isa, actor_isa):
    require(learner_isa, actor_isa)
    learner = stage.learner("run", "--isa", learner_isa, small=RUN)
    actor = stage.actor("run", "--isa", actor_isa)
    learner.expect_text(f"isa {learner_isa}, mujoco")
    assert learner.expect_text("joins with").endswith(f"isa {actor_isa}")
    assert stage.finish("run", learner, [actor], UPDATES) == expected


@pytest.mark.skipif(ENGINE != "2.2.2", reason="the other compiler's build has MuJoCo 2.2.2")
@pytest.mark.skipif(not OTHER_BUILD.exists(), reason="no build by another compiler (deploy/setup --sanitize)")
@pytest.mark.slow
def test_an_actor_by_another_compiler_plays_the_same_episodes(stage, expected):
    learner = stage.learner("run", small=RUN)
    # Debian's Fast DDS deletes a reader's part under another type than it made it.
    actor = stage.start("env", "ASAN_OPTIONS=new_delete_type_mismatch=0", OTHER_BUILD, "run", "--run", "run", "--domain", stage.domain)
    assert "clang" in learner.expect_text("joins with")
    assert stage.finish("run", learner, [actor], UPDATES) == expected


COMMANDS = [
    (LEARNER, "run", "--run", "run", "--task", "push"),
    (ACTOR, "run", "--run", "run"),
    (ACTOR, "evaluate", "--checkpoint", "none.ckpt"),
    (ACTOR, "render", "--checkpoint", "none.ckpt", "--out", "none.png"),
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: f"{os.path.basename(words[0])} {words[1]}")
def test_instructions_that_nobody_knows_or_the_processor_lacks_are_refused_before_anything_starts(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    has = ", ".join(supported())
    said = said_of(*command, "--isa", "avx")
    assert 'unknown instruction set "avx"; did you mean "avx2"? Known: scalar, avx2, avx512' in said, said
    assert f"this processor has: {has}\n" in said, said
    for isa in set(ISAS) - set(supported()):
        assert f"--isa: this processor has no {isa}; it has: {has}\n" in said_of(*command, "--isa", isa)
    assert not list(tmp_path.iterdir())
