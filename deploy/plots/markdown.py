"""Tables of numbers as Markdown."""


def table(header, rows):
    """Numbers to the right: all but the columns whose header begins with a space."""
    lines = ["| " + " | ".join(name.strip() for name in header) + " |",
             "| " + " | ".join("---" if name.startswith(" ") else "---:" for name in header) + " |"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def value(number, share):
    return f"{number:.2f}" if share else f"{number:.0f}"


def signed(number, share):
    return f"{number:+.2f}" if share else f"{number:+.0f}"


def millions(steps):
    found = {value / 1e6 for value in steps}
    low, high = min(found), max(found)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def estimate_text(estimate, share, number=value):
    point = number(estimate.value, share)
    if estimate.low is None:
        return f"{point} (too few)"
    return f"{point} ({number(estimate.low, share)} to {number(estimate.high, share)})"
