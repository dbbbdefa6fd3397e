"""One run under a plan of faults."""

import queue
import time

from team import UPDATES, Failed

FINDS_AGAIN = 12.0  # seconds that an actor may say that it waits, when nothing keeps it from the learner
PATIENCE = 30.0  # seconds without an update, though it could go on, after which the run hangs
QUIET_END = 5  # updates before the end of the run by which every fault is over


class Conductor:
    """@param plan  [(update, fault)], see faults.plan()."""

    def __init__(self, team, plan, say=lambda text: None, updates=UPDATES):
        self.team, self.plan, self.updates = team, list(plan), updates
        self.struck, self.missed = [], []
        self.longest_silence = 0.0  # seconds from when it could go on to the next update
        self._say = say
        self._active = []  # (end, fault)
        self._update = 0
        self._may_go_on_since = time.monotonic()
        self._free_since = {}  # of each actor that nothing keeps from the learner

    def conduct(self):
        """Blocks until the run has ended. @return weights_sha256. @throws Failed."""
        while self.team.learner.child.poll() != 0 and self.team.done is None:
            self.step()
        self.end_all()
        return self.team.finish()

    def step(self):
        """Blocks half a second at most."""
        self._begin_faults()
        self._wait()
        self._end_faults()
        self.team.check(
            not any(f.absent for _, f in self._active if f.target == "learner"),
            [n for n in self.team.actors if not self._is(n, lambda fault: fault.absent)],
        )
        self._watch_progress()
        self._watch_actors()

    def end_all(self):
        for _, fault in self._active:
            self._end(fault)
        self._active = []

    def busy(self, target):
        return self._is(target, lambda _: True)

    def _is(self, target, test):
        return any(test(fault) for _, fault in self._active if fault.target == target)

    def _begin_faults(self):
        if self._update >= self.updates - QUIET_END:
            return
        waiting = []
        for begin, fault in self.plan:
            # Two at once on one machine would undo each other: the second waits, and no other for it.
            if begin > self._update or self.busy(fault.target):
                waiting.append((begin, fault))
            else:
                self.begin(fault)
        self.plan = waiting

    def begin(self, fault):
        self._say(f"update {self._update}: {fault}")
        fault.begin(self.team)
        self._active.append((time.monotonic() + fault.seconds, fault))

    def _end_faults(self):
        now = time.monotonic()
        ending = self._update >= self.updates - QUIET_END
        due = [f for end, f in self._active if end <= now or ending or f.enough(self.team)]
        self._active = [(end, fault) for end, fault in self._active if fault not in due]
        for fault in due:
            self._end(fault)

    def _end(self, fault):
        fault.end(self.team)
        (self.struck if fault.struck else self.missed).append(fault)

    def _wait(self):
        """For the next event, or until a fault is over or somebody has to be looked after."""
        ends = [end - time.monotonic() for end, _ in self._active]
        try:
            kind, value, when = self.team.events.get(timeout=max(0.0, min([0.5, *ends])))
        except queue.Empty:
            return
        if kind == "update":
            self._update = value
            self.longest_silence = max(self.longest_silence, when - self._may_go_on_since)
            self._may_go_on_since = when

    def _watch_progress(self):
        actors = [n for n in self.team.actors if not self._is(n, lambda f: f.blocks_actor)]
        if not actors or self._is("learner", lambda fault: fault.blocks_learner):
            self._may_go_on_since = time.monotonic()
        if time.monotonic() - self._may_go_on_since > PATIENCE:
            logs = "\n\n".join(str(process) for process in self.team.all)
            raise Failed(f"no update for {PATIENCE:.0f} s after update {self._update}\n{logs}")

    def _watch_actors(self):
        now = time.monotonic()
        kept = self._is("learner", lambda fault: fault.blocks_learner)
        for name in self.team.actors:
            if kept or self.busy(name) or self.busy("wire"):
                self._free_since[name] = now
                continue
            free = now - self._free_since.setdefault(name, now)
            if min(free, self.team.waits(name)) > FINDS_AGAIN:
                raise Failed(f"{name} does not find the learner: {self.team.actors[name]}")
