"""When to say that something has not come."""

import time

AFTER = (10.0, 60.0)  # seconds


class Patience:
    """Begins when it is made, and runs out after each of AFTER unless what is waited for comes."""

    def __init__(self):
        self._begin, self._after = time.monotonic(), list(AFTER)

    @property
    def ends_at(self):
        """time.monotonic() of the next time it runs out; None: it does not."""
        return self._begin + self._after[0] if self._after else None

    def end(self):
        """It came."""
        self._after = []

    def runs_out(self):
        """@return seconds waited, once each time; else None."""
        if not self._after or time.monotonic() < self.ends_at:
            return None
        return self._after.pop(0)
