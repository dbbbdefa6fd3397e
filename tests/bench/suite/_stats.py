"""Medians over rounds, and Markdown tables of them."""

import statistics


def by_case(rows):
    """{case: {quantity: {round: value}}}, in the order measured."""
    values = {}
    for row in rows:
        values.setdefault(row["case"], {}).setdefault(row["quantity"], {})[row["round"]] = row["value"]
    return values


def median(of_rounds):
    return statistics.median(of_rounds.values())


def medians(rows):
    """{case: {quantity: median over the rounds}}, in the order measured."""
    return {case: {name: median(rounds) for name, rounds in of.items()} for case, of in by_case(rows).items()}


def median_ratio(a, b):
    """Median of each round's own ratio: what changes from round to round is the same for both."""
    return statistics.median(a[round_number] / b[round_number] for round_number in a if round_number in b)


def markdown(header, lines):
    """A table whose first column is text and whose others are numbers."""
    rule = "| --- |" + " ---: |" * (len(header) - 1)
    return "\n".join(["| " + " | ".join(header) + " |", rule, *("| " + " | ".join(line) + " |" for line in lines)])
