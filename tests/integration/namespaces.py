"""Machines of a test on one machine: network namespaces, each in a subnet of its own behind a router.
Nothing but the router's forwarding connects them, so no multicast passes from one to another."""

import json
import os
import subprocess


def unavailable():
    """@return why no namespaces can be made here, or None."""
    if os.geteuid() != 0:
        return "network namespaces need root"
    probe = f"metronome-probe-{os.getpid()}"
    made = subprocess.run(["ip", "netns", "add", probe], capture_output=True, text=True)
    if made.returncode != 0:
        return f"no network namespaces here: {made.stderr.strip()}"
    _run("ip", "netns", "delete", probe)
    return None


def mounts_unavailable():
    """@return why a process cannot have mounts of its own here, or None."""
    made = subprocess.run(["unshare", "--mount", "true"], capture_output=True, text=True)
    return f"no mounts of one's own here: {made.stderr.strip()}" if made.returncode else None


def _run(*command):
    done = subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}: {done.stderr.strip()}")
    return done.stdout


class Namespace:
    def __init__(self, name):
        self.name = name
        _run("ip", "netns", "add", name)
        self.run("ip", "link", "set", "lo", "up")

    def command(self, *command):
        """@return what to execute, so that `command` runs inside (as the same process id)."""
        # Not `ip netns exec`: that remounts /sys, which a container's or a chroot's / does not allow.
        return ["nsenter", f"--net=/run/netns/{self.name}", *map(str, command)]

    def run(self, *command):
        return _run(*self.command(*command))

    def close(self):
        subprocess.run(["ip", "netns", "delete", self.name], capture_output=True, check=False)


class Mounts:
    """This machine with other files in places: processes of it see what `commands` mount, and nobody
    else does."""

    def __init__(self, *commands):
        """@param commands  of the shell, e.g. "mount ...". @raise RuntimeError if one fails."""
        script = "\n".join([*commands, "echo made", "exec sleep infinity"])
        with_us = ("setpriv", "--pdeathsig", "KILL")  # it ends when we do, however that is
        self._holder = subprocess.Popen(
            (*with_us, "unshare", "--mount", "sh", "-ec", script), stdout=subprocess.PIPE, text=True
        )
        if self._holder.stdout.readline() != "made\n":
            raise RuntimeError(f"no mount namespace with {commands}")

    def process(self, *command):
        """@return what to execute, so that `command` runs inside (as the same process id)."""
        # Root folder and working folder too: a mount namespace begins at its own.
        entered = ("--mount", "--root", "--wd", f"--target={self._holder.pid}")
        return ["nsenter", *entered, *map(str, command)]

    def run(self, *command):
        return _run(*self.process(*command))

    def close(self):
        self._holder.kill()
        self._holder.wait()
        self._holder.stdout.close()


class Host(Namespace):
    """A machine with one network card. Conditions of its link are set at the router's end, so that
    the machine itself notices nothing but their effect."""

    def __init__(self, router, prefix, name, number):
        super().__init__(f"{prefix}-{name}")
        self.host_name = name
        self.router = router
        self.address = f"10.213.{number}.2"
        self.gateway = f"10.213.{number}.1"
        self.port = f"to{number}"  # the router's end
        self._tables = 0

    def plug_in(self):
        """Joins the machine to the router by a veth pair."""
        _run(
            *("ip", "link", "add", self.port, "netns", self.router.name, "type", "veth"),
            *("peer", "name", "eth0", "netns", self.name),
        )
        self.configure()

    def configure(self):
        """Addresses and routes, once both ends of the link are there."""
        self.router.run("ip", "address", "add", f"{self.gateway}/30", "dev", self.port)
        self.router.run("ip", "link", "set", self.port, "up")
        self.run("ip", "address", "add", f"{self.address}/30", "dev", "eth0")
        self.run("ip", "link", "set", "eth0", "up")
        self.run("ip", "route", "add", "default", "via", self.gateway, "dev", "eth0")

    def process(self, *command):
        """As command(), under the machine's own host name."""
        named = 'hostname "$0" && exec "$@"'
        return self.command("unshare", "--uts", "sh", "-c", named, self.host_name, *command)

    def set_link(self, state):
        """@param state  "up" or "down"."""
        self.router.run("ip", "link", "set", self.port, state)

    def drop(self, share, direction="both"):
        """Loses a random share, in [0, 1], of the packets "from" or "to" the machine, or "both".
        @return a name for dropped() and stop_dropping()."""
        self._tables += 1
        table = f"{self.port}-{self._tables}"
        ways = {"from": ["iifname"], "to": ["oifname"], "both": ["iifname", "oifname"]}[direction]
        which = "" if share >= 1 else f"numgen random mod 1000 < {round(share * 1000)} "
        rules = "; ".join(f'{way} "{self.port}" {which}counter drop' for way in ways)
        chain = f"chain lossy {{ type filter hook forward priority 0; {rules}; }}"
        self.router.run("nft", f"table inet {table} {{ {chain}; }}")
        return table

    def dropped(self, table):
        """@return packets lost by drop() so far."""
        listing = json.loads(self.router.run("nft", "-j", "list", "table", "inet", table))
        return sum(
            part["counter"]["packets"]
            for entry in listing["nftables"]
            for part in entry.get("rule", {}).get("expr", [])
            if "counter" in part
        )

    def stop_dropping(self, table):
        self.router.run("nft", "delete", "table", "inet", table)

    def narrow(self, bits_per_second):
        """Limits what the machine receives and sends (token bucket, at most 0.2 s queued)."""
        for end, device in ((self.router, self.port), (self, "eth0")):
            end.run(
                *("tc", "qdisc", "replace", "dev", device, "root", "tbf"),
                *("rate", f"{bits_per_second}bit", "burst", "16kb", "latency", "200ms"),
            )

    def narrowed(self):
        """@return packets that narrow() has delayed or dropped so far."""
        total = 0
        for end, device in ((self.router, self.port), (self, "eth0")):
            shown = end.run("tc", "-s", "-j", "qdisc", "show", "dev", device)
            total += sum(q.get("overlimits", 0) + q.get("drops", 0) for q in json.loads(shown))
        return total

    def widen(self):
        for end, device in ((self.router, self.port), (self, "eth0")):
            end.run("tc", "qdisc", "delete", "dev", device, "root")


class Network:
    """Machines around a router. Close it: namespaces outlive the process that made them."""

    def __init__(self):
        self._prefix = f"metronome-{os.getpid()}"
        self.hosts = {}
        self.router = Namespace(f"{self._prefix}-router")
        self.router.run("sysctl", "-qw", "net.ipv4.ip_forward=1")

    def host(self, name, plug_in=True):
        """A new machine. @param plug_in  false: the caller makes its link (device "eth0" inside,
        `port` in the router) and calls configure()."""
        made = Host(self.router, self._prefix, name, len(self.hosts) + 1)
        self.hosts[name] = made
        if plug_in:
            made.plug_in()
        return made

    def close(self):
        for host in self.hosts.values():
            host.close()
        self.router.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
