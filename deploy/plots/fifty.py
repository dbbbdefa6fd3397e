"""The tables of experiment fifty: all tasks, beside the official scripted policies and what others published."""

import numpy as np

import estimates
import markdown
import names
import published
import scores
import traits
from draw.every_task import BASELINE, EXPERIMENT, HEADS, SOLVED, differences, tasks_text

SUCCESSES = {"any": scores.DETERMINISTIC, "last": scores.DETERMINISTIC_END,
             f"by {published.EPISODE}": scores.DETERMINISTIC_200}
NAMES = ("fifty", "fifty-summary", "fifty-traits")
_EVALUATED = ("Mean action at the last milestone, on 50 placements that no training run draws. Success at any step, at "
              f"the last one, and by step {published.EPISODE}, where published evaluations end.")


def tables(experiments, experts):
    """@param experts  task to experts.Expert.  @return name to Markdown, or to None where there is nothing to tell."""
    cells = experiments.get(EXPERIMENT, [])
    if not cells:
        return dict.fromkeys(NAMES)
    return dict(zip(NAMES, (by_task(cells, experts), summary(cells), of_traits(cells))))


def _means(cells, arm, score):
    """@return task to mean over seeds, of the tasks that have the score."""
    tasks = names.tasks_of(cells)
    found = zip(tasks, scores.by_task(cells, arm, tasks, score))
    return {task: float(np.mean(values)) for task, values in found if values}


def _known(value, share):
    return "–" if value is None else markdown.value(value, share)


def by_task(cells, experts):
    arms, columns = names.arms_of(cells), (*SUCCESSES.items(), ("return", scores.DETERMINISTIC_RETURN))
    means = [(_means(cells, arm, score), score.share) for arm in arms for _, score in columns]
    header = [" task"] + [f"{names.label_of(arm, cells)}: {name}" for arm in arms for name, _ in columns]
    header += ["expert: any", "expert: last", "expert: return"] if experts else []
    rows = []
    for task in names.tasks_of(cells):
        row = [task, *(_known(found.get(task), share) for found, share in means)]
        rows.append(row + _expert_columns(experts.get(task)) if experts else row)
    counts = [len(scores.select(cells, task, arm)) for task in names.tasks_of(cells) for arm in arms]
    return markdown.table(header, rows) + (
        f"\n\n{tasks_text(cells)[0].upper()}{tasks_text(cells)[1:]}; means over seeds ({scores.seeds_text(counts)} an arm). "
        f"{_EVALUATED} " + (_EXPERT if experts else _NO_EXPERT) + " Published results of all tasks are means over them.")


_EXPERT = "Expert: the official scripted policy on ten official placements, by step 500."
_NO_EXPERT = "The official scripted policy's results are told by `metronome-actor`, which was not built."


def _expert_columns(expert):
    if expert is None:
        return ["–"] * 3
    return [markdown.value(expert.success, True), markdown.value(expert.success_end, True),
            markdown.value(expert.mean_return, False)]


def summary(cells):
    rows = [_summary_row(cells, arm) for arm in names.arms_of(cells)]
    rows += [[f"{who} (published)", "50", "3", f"{steps:g}", "–", "–", f"{mean:g}", "–", "–", str(solved), "–"]
             for who, steps, mean, solved in published.FIFTY]
    header = (" who", "tasks", "seeds", "steps (M)", *SUCCESSES,
              *(f"tasks of {SOLVED} or more: {name}" for name in SUCCESSES), "IQM of any")
    return f"{markdown.table(header, rows)}\n\n{_SUMMARY}{_sign_table(cells)}"


_SUMMARY = (
    f"Over the tasks of which the arm has finished runs. {_EVALUATED} Of each, the mean over tasks and seeds, and the "
    f"tasks whose mean over seeds is {SOLVED} or more. IQM: interquartile mean of the success at any step "
    f"over tasks and seeds, with its 95 % bootstrap interval ({estimates.RESAMPLES} resamples, rliable). Runs are "
    f"resampled within each task; where a task has fewer than {estimates.FEWEST} seeds, tasks are resampled, and the "
    "interval tells how much depends on the choice of tasks, nothing of how much on the seed. Published: three seeds, "
    f"episodes of {published.EPISODE} steps, on the authors' own settings of the tasks.")


def _sign_table(cells):
    rows = [row for arm in names.arms_of(cells) if arm != HEADS for row in _sign_rows(cells, arm)]
    if not rows:
        return ""
    header = (" multi-head against", " score", "tasks", "mean difference", "better", "worse", "equal", "p")
    return f"\n\n{markdown.table(header, rows)}\n\n{_SIGNS}"


_SIGNS = (
    "Tasks on which the mean over seeds of multi-head is better or worse, by whatever little. p: two-sided sign test, "
    "exact, of the tasks that differ. Not corrected for the number of rows. With one seed a task it asks whether heads "
    "are better on more tasks than not, not whether they are on any single one.")


def _summary_row(cells, arm):
    own = scores.select(cells, arm=arm)
    means = [list(_means(own, arm, score).values()) for score in SUCCESSES.values()]
    tasks = names.tasks_of(own)
    every_run = [values for values in scores.by_task(own, arm, tasks, scores.DETERMINISTIC) if values]
    seeds = scores.seeds_text([len(scores.select(own, task)) for task in tasks])
    return [names.label_of(arm, cells), str(len(tasks)), seeds, markdown.millions(cell.steps for cell in own),
            *(_known(np.mean(values) if values else None, True) for values in means),
            *(str(sum(value >= SOLVED - 1e-9 for value in values)) if values else "–" for values in means),
            markdown.estimate_text(estimates.iqm_over_tasks(every_run), True) if every_run else "–"]


def _sign_rows(cells, baseline):
    rows = []
    for name, score in (*SUCCESSES.items(), ("normalised return", scores.DETERMINISTIC_NORMALISED)):
        values = [found.estimate.value for found in differences(cells, baseline, score).values()]
        if values:
            signs = estimates.signs(values)
            rows.append([names.label_of(baseline, cells), name, str(len(values)), markdown.signed(np.mean(values), True),
                         str(signs.better), str(signs.worse), str(signs.equal), _p_text(signs.p)])
    return rows


def _p_text(p):
    return "–" if p is None else "< 0.001" if p < 0.001 else f"{p:.3f}"


def of_traits(cells):
    """Of heads less PPO."""
    found = [{task: difference.estimate.value for task, difference in differences(cells, BASELINE, score).items()
              if task in traits.OF} for score in (scores.DETERMINISTIC, scores.DETERMINISTIC_NORMALISED)]
    rows = [_trait_row(trait, found) for trait in traits.MEANING] if found[0] else []
    if not rows:
        return None
    header = [" trait", "tasks with it", "without", *(f"{name}: {of}" for name in ("success", "return") for of in
                                                      ("with it", "without", "difference", "p"))]
    return markdown.table(header, rows) + (
        "\n\nMeans over tasks of what heads give over PPO with one head: success at any step, and normalised return, of "
        "the mean action at the last milestone. p: two-sided permutation test of the difference of the two means, tasks "
        "dealt to either group at random; not corrected for the number of rows, and traits go together: each task with "
        f"{traits.GRASP} has {traits.SEQUENCE}. Traits: "
        + "; ".join(f"{trait}: {meaning}" for trait, meaning in traits.MEANING.items()) + ".")


def _trait_row(trait, found):
    row = []
    for differences_of in found:
        groups = [[value for task, value in differences_of.items() if (trait in traits.OF[task]) == has]
                  for has in (True, False)]
        row = row or [trait, *(str(len(group)) for group in groups)]
        row += _contrast_columns(*groups)
    return row


def _contrast_columns(with_it, without):
    means = [markdown.signed(np.mean(group), True) if group else "–" for group in (with_it, without)]
    if not (with_it and without):
        return [*means, "–", "–"]
    difference, p = estimates.contrast(with_it, without)
    return [*means, markdown.signed(difference, True), _p_text(p)]
