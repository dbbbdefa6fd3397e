"""The numbers behind the figures, as Markdown tables. Each function takes all experiments' cells and
returns Markdown, or None where there is nothing to tell."""

import numpy as np

import curves
import estimates
import markdown
import names
import published
import scores
from draw import controls, efficiency, heads, learning

INTERVAL = (f"Intervals: 95 %, stratified bootstrap, {estimates.RESAMPLES} resamples (rliable); "
            f"\"too few\" stands where there are fewer than {estimates.FEWEST} seeds.")
MEANING = ("Under noise: mean of the last 10 updates of a run; deterministic: its last evaluation "
           "(mean action, random placements that no training run draws).")
NEEDED = 0.9  # of the policy's own return


def _iqm_text(by_task, score):
    return markdown.estimate_text(estimates.iqm(by_task), score.share) if all(by_task) else "–"


_ENDS = (scores.RETURN, scores.SUCCESS, scores.SUCCESS_END, scores.DETERMINISTIC, scores.DETERMINISTIC_END)


def _ends(cells):
    """Final scores of each task and arm, and over tasks."""
    rows = []
    arms, tasks = names.arms_of(cells), names.tasks_of(cells)
    for task in tasks:
        for arm in arms:
            own = scores.select(cells, task, arm)
            if own:
                row = [task, names.label_of(arm, cells), str(len(own)), markdown.millions(cell.steps for cell in own)]
                rows.append(row + [_iqm_text([list(scores.by_seed(own, score).values())], score)
                                   for score in _ENDS])
    shared = scores.shared_tasks(cells, tasks, arms, scores.RETURN)
    for arm in arms if len(shared) > 1 else []:
        counts = [len(scores.select(cells, task, arm)) for task in shared]
        row = [f"{len(shared)} tasks", names.label_of(arm, cells), scores.seeds_text(counts),
               markdown.millions(cell.steps for cell in scores.select(cells, arm=arm) if cell.task in shared)]
        rows.append(row + [_iqm_text(scores.by_task(cells, arm, shared, score), score) for score in
                           (scores.NORMALISED, *_ENDS[1:])])
    header = (" task", " arm", "seeds", "steps (M)", "return", "success, noise", "at the last step",
              "success, deterministic", "at the last step")
    text = markdown.table(header, rows) + f"\n\nInterquartile means over seeds. {MEANING} {INTERVAL}"
    if len(shared) > 1:
        text += (" Over tasks, returns are divided by the largest possible one (10 a step, 5000 an episode). Of tasks, "
                 f"those enter of which every arm has at least {estimates.FEWEST} seeds (or any, where no task has so "
                 "many); of seeds, as many of each task as the one with the fewest has.")
    return text


def final(experiments):
    cells = experiments.get("main", [])
    return _ends(cells) if cells else None


def _baselines(cells):
    return [arm for arm in names.arms_of(cells) if arm != "multihead"]


def improvement(experiments):
    cells = experiments.get("main", [])
    tasks, rows = names.tasks_of(cells), []
    for arm in _baselines(cells):
        for score in scores.COMPARED:
            shared = scores.shared_tasks(cells, tasks, ("multihead", arm), score)
            if not shared:
                continue
            x, y = (scores.by_task(cells, name, shared, score) for name in ("multihead", arm))
            estimate = estimates.probability_of_improvement(x, y)
            rows.append([names.label_of(arm, cells), score.label, str(len(shared)), str(estimate.seeds),
                         markdown.estimate_text(estimate, True)])
    if not rows:
        return None
    return markdown.table((" multi-head over", " score at the end", "tasks", "seeds", "probability"), rows) + (
        "\n\nProbability that a run of multi-head scores higher than one of the other arm on the same task, ties "
        f"counted half, averaged over the tasks. {INTERVAL} An interval of no width says that all runs of one arm were "
        "better than all of the other, not that this is certain.")


_DIFFERENCE_COLUMNS = (" task", "seeds", " interval", "return", "p", "success, noise", "p",
                       "success, deterministic", "p")
_P = [i for i, column in enumerate(_DIFFERENCE_COLUMNS) if column == "p"]


def _difference_row(task, cells, against):
    seeds, interval, row = "", "", []
    for score in scores.COMPARED:
        x, y = scores.by_seed(cells, score), scores.by_seed(against, score)
        if not (x and y):
            row += ["–", "–"]
            continue
        found = estimates.difference(x, y)
        seeds = seeds or "{}, {}".format(*found.seeds)
        interval = interval or ("paired" if found.paired else "unpaired")
        row += [markdown.estimate_text(found.estimate, score.share, markdown.signed),
                "–" if found.p is None else f"{found.p:.3f}"]
    return [task, seeds, interval, *row]


def _test_text(rows):
    """A note on p, and how small it can be with the seeds of these rows; empty where none has a p."""
    tested = {tuple(map(int, row[1].split(", "))) for row in rows if any(row[i] != "–" for i in _P)}
    if not tested:
        return ""
    first, *others = (f"{estimates.smallest_p(*seeds):.3f} with {seeds[0]} and {seeds[1]}" for seeds in sorted(tested))
    smallest = ", ".join([f"{first} seeds", *others])
    return (" p: two-sided permutation test of the difference of means, exact (all splits of the runs between the "
            f"arms) up to 9 seeds an arm; the smallest possible is {smallest}. Not corrected for the number of rows.")


def _difference_table(header, rows, preface=""):
    """@param header  of what stands before _DIFFERENCE_COLUMNS in each row."""
    if not rows:
        return None
    tests = _test_text([row[len(header):] for row in rows])
    return f"{markdown.table((*header, *_DIFFERENCE_COLUMNS), rows)}\n\n{preface}{_DIFFERENCE}{tests}"


def _difference_rows(compared):
    """@param compared  (task, cells, cells to compare with) each, of one arm.
    @return a row for each, and one over the tasks."""
    rows, over_all, names_of = [_difference_row(*each) for each in compared], [], []
    for score in scores.COMPARED:
        found = estimates.pooled_difference(*([scores.by_seed(each[i], score) for each in compared] for i in (1, 2)))
        over_all += [markdown.estimate_text(found[0], score.share, markdown.signed) if found else "–", "–"]
        names_of += [f"{found[1]} tasks", str(found[0].seeds)] if found else []
    return rows + ([[*names_of[:2], "paired", *over_all]] if names_of else [])


def differences(experiments):
    cells = experiments.get("main", [])
    rows = []
    for arm in _baselines(cells):
        compared = [(task, scores.select(cells, task, "multihead"), scores.select(cells, task, arm))
                    for task in names.tasks_of(cells)]
        compared = [each for each in compared if each[1] and each[2]]
        rows += [[names.label_of(arm, cells), *row] for row in _difference_rows(compared)]
    return _difference_table([" multi-head less"], rows)


_DIFFERENCE = (
    f"Differences of means at the end, with 95 % percentile bootstrap intervals ({estimates.RESAMPLES} resamples): "
    f"paired, over the differences of runs of equal seed, where at least {estimates.FEWEST} seeds are common; "
    "unpaired, each arm resampled on its own, elsewhere. Over tasks: the mean of the tasks' differences, pairs "
    "resampled within each task, as many of each as the task with the fewest has; no test. With so few seeds such "
    "intervals are too narrow: a nominal 95 % covers about 84 % with five seeds and 75 % with three (simulated, normal "
    "data, paired). " + MEANING)


def time_to_success(experiments):
    """Of the deterministic policy at its last evaluation."""
    rows = []
    for name in ("main", "solve"):
        cells = experiments.get(name, [])
        arms = names.arms_of(cells)
        for task in names.tasks_of(cells):
            for arm in arms:
                own = [cell for cell in scores.select(cells, task, arm) if "random" in cell.evaluations]
                last = [cell.evaluations["random"]["time_to_success"][-1] for cell in own]
                found = [value for value in last if np.isfinite(value)]
                if found:
                    rows.append([name, task, names.label_of(arm, cells), f"{len(found)} of {len(own)}",
                                 markdown.estimate_text(estimates.iqm([found]), False)])
    if not rows:
        return None
    return markdown.table((" experiment", " task", " arm", "seeds with successes", "steps"), rows) + (
        "\n\nSteps of an episode until its first success, mean over the successful episodes of the last "
        f"deterministic evaluation; interquartile mean over the runs that have successes. {INTERVAL}")


def _reach_text(found, number):
    """Median, and how many."""
    reached = np.isfinite(found)
    if not reached.any():
        return f"never (0 of {len(found)})"
    middle = np.median(found)
    text = number(middle) if np.isfinite(middle) else "later"
    return f"{text} ({reached.sum()} of {len(found)})"


def reach(experiments):
    """Steps and minutes until 0.5, 0.8 and 0.9."""
    rows = []
    for name in ("main", "solve"):
        cells = experiments.get(name, [])
        for task in names.tasks_of(cells):
            for arm in names.arms_of(cells):
                own = scores.select(cells, task, arm)
                for source in (learning.DETERMINISTIC, learning.NOISE):
                    counted = [cell for cell in own if source == learning.NOISE or "random" in cell.evaluations]
                    if not counted:
                        continue
                    row = [name, task, names.label_of(arm, cells), source]
                    for threshold in efficiency.THRESHOLDS:
                        steps = efficiency.reaches(counted, source, threshold)
                        row.append(_reach_text(steps / 1e6, lambda value: f"{value:.2f}"))
                    minutes = np.array([curves.minutes_at(cell.progress, value) if np.isfinite(value) else np.inf
                                        for cell, value in zip(counted, steps)])
                    rows.append(row + [_reach_text(minutes, lambda value: f"{value:.1f}")])
    if not rows:
        return None
    header = (" experiment", " task", " arm", " success", *(f"M steps to {threshold}" for threshold in
              efficiency.THRESHOLDS), f"minutes to {efficiency.THRESHOLDS[-1]}")
    return markdown.table(header, rows) + (
        "\n\nMedians over all seeds, those that never got there counted as later; in brackets: how many got there. "
        "Deterministic: the first milestone; under noise: the first mean over 10 updates. Minutes are wall-clock "
        "time of runs that shared a machine of 2 cores with others.")


def public(experiments):
    """Beside what others published."""
    rows = []
    for name in ("main", "solve"):
        cells = [cell for cell in experiments.get(name, []) if cell.method == "multihead"]
        for task in names.tasks_of(cells):
            for arm in names.arms_of(scores.select(cells, task)):
                own = scores.select(cells, task, arm)
                rows.append([task, f"{names.label_of(arm, own)} ({name})", markdown.millions(cell.steps for cell in own)]
                            + [_iqm_text([list(scores.by_seed(own, score).values())], score)
                               for score in (scores.DETERMINISTIC, scores.RETURN)])
    if not rows:
        return None
    steps = f"{published.STEPS / 1e6:g}"
    tasks = sorted({row[0] for row in rows})
    for task in tasks:
        if task in published.SAC:
            rows += [[task, "SAC", steps, f"{published.SAC[task]:.2f}", "–"],
                     [task, "TD-MPC2", steps, f"about {published.TD_MPC2[task]:.1f}", "–"]]
        if task in published.APPO_RETURN:
            rows.append([task, "APPO of Sample Factory", f"{published.APPO_STEPS / 1e6:g}", "–",
                         str(published.APPO_RETURN[task])])
    rows.sort(key=lambda row: tasks.index(row[0]))
    return markdown.table((" task", " who", "steps (M)", "success, deterministic", "return"), rows) + (
        "\n\nOthers' results are published ones (SAC and TD-MPC2: means of 3 seeds by the authors of TD-MPC2), "
        f"on their own settings of the tasks. {INTERVAL}")


def _trend_text(sweep, score):
    """The rank correlation of k with the score over all runs."""
    pairs = [(k, value) for k, (cells, _) in sweep.items() for value in scores.by_seed(cells, score).values()]
    found = estimates.trend(*zip(*pairs)) if pairs else None
    if found is None:
        return "–"
    correlation, p = found
    return f"{correlation:+.2f} (p {'< 0.001' if p < 0.001 else f'= {p:.3f}'})"


def head_sweep(experiments):
    rows = []
    for task in names.tasks_of(experiments.get("heads", [])):
        sweep = heads.sweep(experiments, task)
        for k, (cells, borrowed) in sweep.items():
            row = [task, str(k), "main" if borrowed else "heads", str(len(cells))]
            rows.append(row + [_iqm_text([list(scores.by_seed(cells, score).values())], score)
                               for score in scores.COMPARED])
        runs = sum(len(cells) for cells, _ in sweep.values())
        rows.append([task, "trend", "–", str(runs), *(_trend_text(sweep, score) for score in scores.COMPARED)])
    if not rows:
        return None
    header = (" task", "k", " experiment", "seeds", "return", "success, noise", "success, deterministic")
    return markdown.table(header, rows) + (
        f"\n\nInterquartile means over seeds at the end. {MEANING} {INTERVAL} Trend: Spearman's rank correlation of "
        "k with the score over all runs of the task, p of its two-sided permutation test.")


def control_differences(experiments):
    found, rows = controls.pairs(experiments), []
    for arm in names.in_order({arm for arm, *_ in found}, names.ARMS):
        own = [row for row in found if row[0] == arm]
        arm, less, _, cells, against = own[0]
        labels = [names.label_of(arm, cells), names.label_of(less, against)]
        rows += [[*labels, *row] for row in _difference_rows([row[2:] for row in own])]
    return _difference_table([" control", " less"], rows)


def engine_differences(experiments):
    """Cells of the main comparison on the other engine, less themselves."""
    cells, main = experiments.get("engine", []), experiments.get("main", [])
    rows = []
    for task in names.tasks_of(cells):
        for arm in names.in_order({cell.arm for cell in scores.select(cells, task)}, names.ARMS):
            other, same = scores.select(cells, task, arm), scores.select(main, task, arm)
            if same:
                rows.append([names.label_of(arm, cells), *_difference_row(task, other, same)])
    return _difference_table([" arm"], rows, "Experiment engine, whose file names its engine, less main. ")


def solve(experiments):
    cells = experiments.get("solve", [])
    return _ends(cells) if cells else None


def _number_a_seed(found):
    return " ".join("–" if not np.isfinite(value) else f"{value:.2f}" for value in found)


def sac(experiments):
    """Of each seed, the last evaluation and when success was reached, beside what others published."""
    cells = experiments.get("sac", [])
    rows = []
    for task in names.tasks_of(cells):
        for arm in names.arms_of(cells):
            own = sorted((cell for cell in scores.select(cells, task, arm) if "random" in cell.evaluations),
                         key=lambda cell: cell.seed)
            if not own:
                continue
            ends = [_number_a_seed(scores.by_seed(own, score).values()) for score in
                    (scores.DETERMINISTIC, scores.DETERMINISTIC_200, scores.DETERMINISTIC_END)]
            reached = efficiency.reaches(own, learning.DETERMINISTIC, NEEDED)
            rows.append([task, names.label_of(arm, cells), markdown.millions(cell.steps for cell in own), *ends,
                         _number_a_seed(reached / 1e6)])
        theirs = f"{published.SAC[task]:.2f}" if task in published.SAC else "–"
        rows.append([task, "SAC, published", markdown.millions([published.STEPS]), "", theirs, "", ""])
    if not rows:
        return None
    header = (" task", " arm", "steps (M)", " success", " by step 200", " at the last step", " 0.9 first after (M)")
    return markdown.table(header, rows) + (
        "\n\nOne number a seed, of the mean action's last evaluation; 0.9 first after: the first milestone of that success "
        "(– never). Published: mean of three seeds by the authors of TD-MPC2, episodes of "
        f"{published.EPISODE} steps.")


def exchanges(found):
    """@param found  task to exchange.Exchange."""
    if not found:
        return None
    rows = []
    for task, policy in found.items():
        row = [task]
        for values, share in ((policy.success, True), (policy.success_end, True), (policy.returns, False)):
            others, own = policy.of_others(values)
            row += [markdown.value(number, share) for number in (own, others.mean(), values[-1].max())]
        # Of a block, the best of the other heads: what no other head makes up for.
        others, own = policy.of_others(policy.returns)
        needed = [block for block, best in enumerate(others.max(axis=1)) if best < NEEDED * own]
        free = [block for block, worst in enumerate(others.min(axis=1)) if worst >= NEEDED * own]
        rows.append([*row, ", ".join(map(str, needed)) or "–", ", ".join(map(str, free)) or "–"])
    header = [" task"]
    for score in ("success", "at the last step", "return"):
        header += [score, "exchanged", "one head"]
    header += [" blocks that need their head", " blocks that do not"]
    return markdown.table(header, rows) + (
        "\n\nThe committed policies as they are; with one block of time given to another head, the mean over all k (k - 1) "
        "such exchanges; and with one head in all blocks, the best of the k. A block needs its head where each other "
        f"head brings less than {NEEDED:.0%} of the policy's own return, and does not where each brings more.")


TABLES = {"final": final, "improvement": improvement, "differences": differences,
          "time-to-success": time_to_success, "reach": reach, "public": public, "heads": head_sweep,
          "controls": control_differences, "engine": engine_differences, "solve": solve,
          "sac": sac}
