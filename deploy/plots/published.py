"""Others' results on these tasks, to compare with."""

# Task to share of successes of the deterministic policy at 2 M environment steps, mean of 3 seeds:
# soft actor-critic as measured by the authors of TD-MPC2 (Hansen, Su, Wang, arXiv:2310.16828; files
# results/sac/mw-TASK.csv of nicklashansen/tdmpc2), and TD-MPC2 itself, about 1 on all four.
STEPS = 2_000_000
SAC = {"assembly": 0.33, "bin-picking": 0.30, "box-close": 0.30, "push": 0.80}
TD_MPC2 = {"assembly": 1.0, "bin-picking": 1.0, "box-close": 1.0, "push": 1.0}

# Of all fifty tasks: who, million environment steps, mean success, tasks of success 0.9 or more. Three seeds, episodes
# of EPISODE steps. BRC: Nauman et al., arXiv:2505.23150; the others: the files of TD-MPC2's authors.
EPISODE = 200
FIFTY = (("TD-MPC2", 2, 0.96, 43), ("BRC", 1, 0.915, 41), ("SAC", 2, 0.75, 26), ("DreamerV3", 2, 0.41, 3))

# Task to mean return (of 5000) of Sample Factory's APPO after 100 M environment steps.
APPO_STEPS = 100_000_000
APPO_RETURN = {"assembly": 1465, "box-close": 932}
