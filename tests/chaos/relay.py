"""The only wire between a machine and its router, and a bad one when told so: delays, reorders,
doubles and loses IP packets. A process of its own between two TUN devices.

    relay.py HOST_NAMESPACE ROUTER_NAMESPACE ROUTER_DEVICE

Standard input: one JSON object a line, {"delay": [least, most] seconds, "double": share, "lose": share},
each from then on. Standard output: {"ready": true} at first, and after each line what happened to
packets under the condition before it, {"delayed": n, "reordered": n, "doubled": n, "lost": n}.
"""

import ctypes
import fcntl
import heapq
import json
import os
import random
import selectors
import struct
import sys
import time

_CLONE_NEWNET = 0x40000000
_TUNSETIFF, _IFF_TUN, _IFF_NO_PI = 0x400454CA, 0x0001, 0x1000
_LIBC = ctypes.CDLL(None, use_errno=True)
_MOST_BYTES = 65536


def open_tun(namespace, device):
    """@return the packets' end of a new TUN device in that namespace."""
    with open(f"/run/netns/{namespace}", "rb") as entrance:
        if _LIBC.setns(entrance.fileno(), _CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), f"cannot enter namespace {namespace}")
    tun = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tun, _TUNSETIFF, struct.pack("16sH22x", device.encode(), _IFF_TUN | _IFF_NO_PI))
    return tun


class Relay:
    def __init__(self, ends):
        self._other = {ends[0]: ends[1], ends[1]: ends[0]}
        self._random = random.Random(1)
        self._waiting = []  # (due, order, packet, end)
        self._order = 0
        self._latest = {end: 0 for end in ends}  # order of the newest packet handed on
        self.set({})

    def set(self, condition):
        """@return what happened under the one before."""
        before = getattr(self, "_counts", None)
        self._delay = condition.get("delay", [0, 0])
        self._double = condition.get("double", 0)
        self._lose = condition.get("lose", 0)
        self._counts = {"delayed": 0, "reordered": 0, "doubled": 0, "lost": 0}
        return before

    def take_from(self, end):
        while True:
            try:
                packet = os.read(end, _MOST_BYTES)
            except (BlockingIOError, OSError):  # empty, or the device is down
                return
            self._accept(packet, self._other[end])

    def _accept(self, packet, end):
        if self._random.random() < self._lose:
            self._counts["lost"] += 1
            return
        copies = 1
        if self._random.random() < self._double:
            self._counts["doubled"] += 1
            copies = 2
        for _ in range(copies):
            delay = self._random.uniform(*self._delay)
            self._counts["delayed"] += delay > 0
            self._order += 1
            heapq.heappush(self._waiting, (time.monotonic() + delay, self._order, packet, end))

    def hand_on(self):
        """Writes what is due. @return seconds until the next is, or None."""
        while self._waiting:
            due, order, packet, end = self._waiting[0]
            left = due - time.monotonic()
            if left > 0:
                return left
            heapq.heappop(self._waiting)
            self._counts["reordered"] += order < self._latest[end]
            self._latest[end] = max(order, self._latest[end])
            try:
                os.write(end, packet)
            except OSError:  # the device is down: a wire that is cut
                self._counts["lost"] += 1
        return None


def main(host, router, router_device):
    ends = [open_tun(host, "eth0"), open_tun(router, router_device)]
    relay = Relay(ends)
    selector = selectors.DefaultSelector()
    for end in ends:
        selector.register(end, selectors.EVENT_READ, relay.take_from)
    selector.register(sys.stdin, selectors.EVENT_READ, None)
    print(json.dumps({"ready": True}), flush=True)
    while True:
        for key, _ in selector.select(relay.hand_on()):
            if key.data:
                key.data(key.fd)
                continue
            line = sys.stdin.readline()
            if not line:
                return
            print(json.dumps(relay.set(json.loads(line))), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
