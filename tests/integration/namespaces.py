"""Machines of a test: network namespaces around a router, each host on a subnet of its own.

Nothing but routed unicast passes between two hosts: no multicast, no shared subnet. Needs root.
"""

import itertools
import os
import subprocess
import time

_SERIAL = itertools.count()


def _ip(*words):
    done = subprocess.run(["ip", *words], capture_output=True, text=True)
    if done.returncode != 0:
        raise OSError(f"ip {' '.join(words)}: {done.stderr.strip()}")


class Host:
    """One machine: a network namespace and its link to the router."""

    def __init__(self, name, namespace, router, number):
        self.name, self.namespace = name, namespace
        self.address = f"10.77.{number}.2"
        self._router, self._link = router, f"to-{number}"
        gateway = f"10.77.{number}.1"
        _ip("link", "add", self._link, "netns", router, "type", "veth",
            "peer", "name", "eth0", "netns", namespace)  # fmt: skip
        _ip("-n", router, "address", "add", f"{gateway}/24", "dev", self._link)
        _ip("-n", router, "link", "set", self._link, "up")
        _ip("-n", namespace, "address", "add", f"{self.address}/24", "dev", "eth0")
        _ip("-n", namespace, "link", "set", "eth0", "up")
        _ip("-n", namespace, "route", "add", "default", "via", gateway)
        self._await_carrier()

    def _await_carrier(self, seconds=10):
        """Fast DDS announces for good the addresses of links that run when it starts: an earlier
        process would only ever be answered on 127.0.0.1."""
        show = ["ip", "-n", self.namespace, "-brief", "link", "show", "eth0"]
        deadline = time.monotonic() + seconds
        while " UP " not in subprocess.run(show, capture_output=True, text=True).stdout:
            if time.monotonic() > deadline:
                raise OSError(f"the link of {self.namespace} is not up after {seconds} s")

    def command(self, *words):
        """The command that runs `words` on this host, as one process."""
        return ["ip", "netns", "exec", self.namespace, *words]

    def unplug(self):
        """The router's end goes down: packets are lost, the host's own address stays."""
        _ip("-n", self._router, "link", "set", self._link, "down")

    def plug(self):
        _ip("-n", self._router, "link", "set", self._link, "up")


class Network:
    """A router and the hosts around it; as a context it leaves nothing behind.

    @throws OSError where this process may not make network namespaces.
    """

    def __init__(self):
        self._prefix = f"metronome-{os.getpid()}-{next(_SERIAL)}"
        self._namespaces = []
        self._hosts = 0

    def __enter__(self):
        try:
            self._router = self._namespace("router")
            subprocess.run(
                ["ip", "netns", "exec", self._router, "sysctl", "-qw", "net.ipv4.ip_forward=1"],
                check=True,
            )
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_):
        self.close()

    def _namespace(self, name):
        namespace = f"{self._prefix}-{name}"
        _ip("netns", "add", namespace)
        self._namespaces.append(namespace)
        _ip("-n", namespace, "link", "set", "lo", "up")
        return namespace

    def host(self, name):
        """A new machine, reachable from all others by its `address`."""
        self._hosts += 1
        return Host(name, self._namespace(name), self._router, self._hosts)

    def close(self):
        """Removes all namespaces; their links go with them. Processes in them must have ended."""
        while self._namespaces:
            _ip("netns", "delete", self._namespaces.pop())
