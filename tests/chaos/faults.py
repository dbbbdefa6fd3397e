"""Faults, each drawn from a seed. A fault begins, lasts for `seconds`, ends, and then knows
whether it really struck."""

import errno
import os
import random
import signal

from team import Failed

LONGEST = 5.0  # seconds
LONGEST_TRY = 15.0  # of what ends once it has struck


class Fault:
    """@param target  the machine that it happens to; no two at once happen to the same."""

    blocks_learner = False  # nothing can go on while it lasts
    blocks_actor = False  # nothing of the target's can
    absent = False  # the target's process is not meant to be there

    def __init__(self, draw, target):
        self.target, self.struck = target, False
        self.seconds = draw.uniform(0.3, LONGEST)

    def enough(self, team):
        """@return whether it may end before its time."""
        return False

    @property
    def name(self):
        return type(self).__name__

    def __str__(self):
        return f"{self.name} {self.target} {self.seconds:.1f} s"


class ActorKilled(Fault):
    blocks_actor = absent = True

    def begin(self, team):
        actor = team.actors[self.target]
        actor.kill()
        self.struck = actor.child.returncode == -signal.SIGKILL

    def end(self, team):
        team.start_actor(self.target)


class ActorTerminated(ActorKilled):
    def begin(self, team):
        actor = team.actors[self.target]
        actor.signal(signal.SIGTERM)
        # One that has only just been started has no handler yet.
        self.struck = actor.wait(10) in (128 + signal.SIGTERM, -signal.SIGTERM)


def _stop(process):
    """@return whether it stands still."""
    process.signal(signal.SIGSTOP)
    _, status = os.waitpid(process.child.pid, os.WUNTRACED)
    return os.WIFSTOPPED(status)


class ActorStopped(Fault):
    blocks_actor = True

    def begin(self, team):
        self.struck = _stop(team.actors[self.target])

    def end(self, team):
        team.actors[self.target].signal(signal.SIGCONT)


class LearnerKilled(Fault):
    blocks_learner = absent = True

    def begin(self, team):
        team.learner.kill()
        self.struck = team.learner.child.returncode == -signal.SIGKILL

    def end(self, team):
        team.start_learner()


class LearnerInterrupted(LearnerKilled):
    def begin(self, team):
        team.learner.signal(signal.SIGINT)
        self.struck = team.learner.wait(20) == 128 + signal.SIGINT


class LearnerStopped(Fault):
    blocks_learner = True

    def begin(self, team):
        self.struck = _stop(team.learner)

    def end(self, team):
        team.learner.signal(signal.SIGCONT)


class LinkDown(Fault):
    blocks_actor = True

    def begin(self, team):
        host = team.host(self.target)
        host.set_link("down")
        self.struck = '"UP"' not in host.router.run("ip", "-j", "link", "show", host.port)

    def end(self, team):
        team.host(self.target).set_link("up")


class PacketsLost(Fault):
    def __init__(self, draw, target):
        super().__init__(draw, target)
        self.share = draw.choice([0.01, 0.05, 0.2, 1.0])
        self.direction = draw.choice(["from", "to", "both"])
        self.blocks_actor = self.share > 0.1

    def begin(self, team):
        self.table = team.host(self.target).drop(self.share, self.direction)

    def end(self, team):
        host = team.host(self.target)
        self.struck = host.dropped(self.table) > 0
        host.stop_dropping(self.table)


class LinkNarrow(Fault):
    def __init__(self, draw, target):
        super().__init__(draw, target)
        self.rate = draw.choice([500_000, 2_000_000, 8_000_000])
        self.blocks_actor = self.rate < 1_000_000

    def begin(self, team):
        team.host(self.target).narrow(self.rate)

    def end(self, team):
        host = team.host(self.target)
        self.struck = host.narrowed() > 0
        host.widen()


class BadWire(Fault):
    """Delay by which packets overtake each other, doubles, losses."""

    def __init__(self, draw, target):
        super().__init__(draw, target)
        most = draw.choice([0.01, 0.05, 0.2])
        self.condition = {"delay": [0.001, most], "double": 0.1, "lose": draw.choice([0, 0.02])}

    def begin(self, team):
        team.set_wire(self.condition)

    def end(self, team):
        happened = team.set_wire({})
        self.struck = happened["reordered"] > 0 and happened["doubled"] > 0


class DiskFull(Fault):
    """Until the learner has met it."""

    def __init__(self, draw, target):
        super().__init__(draw, target)
        self.seconds = LONGEST_TRY

    def begin(self, team):
        self.before = self._complaints(team)
        with open(team.folder / "filler", "wb", buffering=0) as filler:
            try:
                while True:
                    filler.write(bytes(1 << 16))
            except OSError as error:
                if error.errno != errno.ENOSPC:
                    raise

    def enough(self, team):
        return self._complaints(team) > self.before

    def end(self, team):
        self.struck = self._complaints(team) > self.before
        (team.folder / "filler").unlink()

    @staticmethod
    def _complaints(team):
        return sum("No space left" in line for process in team.all for line in process.lines)


class Hostile(Fault):
    """An actor that lies, until it has done so a few times."""

    KINDS = (
        *("wrong-head", "not-a-number", "infinite", "wrong-log-prob", "wrong-action", "too-short"),
        *("wrong-version", "old-run", "replayed", "renumbered", "not-assigned"),
        *("truncated", "oversized", "noise"),
    )

    def __init__(self, draw, target):
        super().__init__(draw, target)
        self.kind = draw.choice(self.KINDS)
        self.seconds = LONGEST_TRY

    @property
    def name(self):
        return f"Hostile {self.kind}"

    def begin(self, team):
        self.process = team.start_hostile(self.target, self.kind)

    def enough(self, team):
        return self.process.child.poll() is not None or self._lies() >= 5

    def _lies(self):
        return self.process.lines.count("sent a spoiled sample")

    def end(self, team):
        if self.process.child.poll() is None:
            self.process.kill()
        self.struck = self._lies() > 0
        if not self.struck and self.process.child.returncode not in (-signal.SIGKILL, 0):
            raise Failed(f"the hostile actor failed: {self.process}")


OF_ACTORS = (ActorKilled, ActorTerminated, ActorStopped, LinkDown, PacketsLost, LinkNarrow)
OF_LEARNER = (LearnerKilled, LearnerInterrupted, LearnerStopped)


def plan(seed, count, actor_hosts, updates):
    """@return [(update at which it begins, fault)], in order. Each kind comes before any comes twice."""
    draw = random.Random(seed)
    made, deck = [], []
    first, last = 2, int(updates * 0.8)
    for begin in sorted(draw.uniform(first, last) for _ in range(count)):
        if not deck:
            deck = [*OF_ACTORS, *OF_LEARNER, BadWire, DiskFull, Hostile, Hostile]
            draw.shuffle(deck)
        kind = deck.pop()
        if kind in OF_LEARNER:
            target = "learner"
        elif kind is BadWire:
            target = "wire"
        elif kind is DiskFull:
            target = "disk"
        else:
            target = draw.choice(actor_hosts)
        made.append((int(begin), kind(draw, target)))
    return made
