"""An eavesdropper: what crosses this machine's loopback, as any tool with the right to capture sees
it."""

import os
import socket
import struct
import threading

_ALL = 0x0003  # ETH_P_ALL
_BYTES = 64 << 20  # as many may wait for us
_UDP = 17


def unavailable():
    """@return why nothing can be captured here, or None."""
    try:
        socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0).close()
    except OSError as error:
        return f"no packets can be captured here: {error}"
    return None


class Capture:
    """Keeps the UDP packets of one DDS domain while it is open."""

    def __init__(self, domain):
        first = 7400 + 250 * domain
        self._ports = range(first, first + 250)
        self._packets = []
        self._end = os.urandom(16)
        self._socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(_ALL))
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BYTES)
        self._socket.bind(("lo", 0))
        self._thread = threading.Thread(target=self._read, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(self._end, ("127.0.0.1", self._ports[-1]))
        self._thread.join()
        self._socket.close()

    def _read(self):
        while True:
            packet, address = self._socket.recvfrom(1 << 17)
            if address[2] == socket.PACKET_OUTGOING or packet[23] != _UDP:  # each is seen twice
                continue
            if packet.endswith(self._end):
                return
            if struct.unpack("!H", packet[36:38])[0] in self._ports:
                self._packets.append(packet)

    def count(self, pattern=b""):
        """@return how many packets hold `pattern`, once it is closed."""
        return sum(pattern in packet for packet in self._packets)
