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


def estimate_text(estimate, share, number=value):
    point = number(estimate.value, share)
    if estimate.low is None:
        return f"{point} (too few)"
    return f"{point} ({number(estimate.low, share)} to {number(estimate.high, share)})"
