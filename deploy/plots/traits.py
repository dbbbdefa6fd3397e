"""Traits of the fifty tasks, to ask which of them go with a gain of heads.

Each is one question about what actor/metaworld/tasks/ says of a task: its reward, what counts as success, and how far
the official scripted policy gets.
"""

SEQUENCE, GRASP, PRECISION, HOLD = "sequence", "grasp", "precision", "hold"

MEANING = {
    SEQUENCE: "the reward pays for a hold of the thing (fingers around it, or closed at it) beside its way to the goal, "
              "so that a hold comes before the move",
    GRASP: "the fingers have to close on a free thing: its goal is above the table or behind a rim",
    PRECISION: "success asks for one thing in, through or around another, with 5 cm to spare or less in some direction",
    HOLD: "to get there is not to stay there: of the scripted policy's episodes with success, at most half have it at "
          "the last step",
}

OF = {
    "assembly": {SEQUENCE, GRASP, PRECISION},
    "basketball": {SEQUENCE, GRASP, PRECISION},
    "bin-picking": {SEQUENCE, GRASP, PRECISION},
    "box-close": {SEQUENCE, GRASP},
    "button-press": set(),
    "button-press-topdown": set(),
    "button-press-topdown-wall": set(),
    "button-press-wall": set(),
    "coffee-button": {HOLD},
    "coffee-pull": {SEQUENCE},
    "coffee-push": {SEQUENCE},
    "dial-turn": set(),
    "disassemble": {SEQUENCE, GRASP},
    "door-close": set(),
    "door-lock": set(),
    "door-open": {SEQUENCE, HOLD},
    "door-unlock": set(),
    "drawer-close": set(),
    "drawer-open": set(),
    "faucet-close": set(),
    "faucet-open": set(),
    "hammer": {SEQUENCE, GRASP},
    "hand-insert": {SEQUENCE, PRECISION},
    "handle-press": {HOLD},
    "handle-press-side": {HOLD},
    "handle-pull": {SEQUENCE},
    "handle-pull-side": {SEQUENCE, HOLD},
    "lever-pull": {HOLD},
    "peg-insert-side": {SEQUENCE, GRASP, PRECISION},
    "peg-unplug-side": {SEQUENCE, GRASP, HOLD},
    "pick-out-of-hole": {SEQUENCE, GRASP},
    "pick-place": {SEQUENCE, GRASP},
    "pick-place-wall": {SEQUENCE, GRASP},
    "plate-slide": set(),
    "plate-slide-back": {HOLD},
    "plate-slide-back-side": {HOLD},
    "plate-slide-side": {HOLD},
    "push": {SEQUENCE, HOLD},
    "push-back": {SEQUENCE, HOLD},
    "push-wall": {SEQUENCE, HOLD},
    "reach": set(),
    "reach-wall": set(),
    "shelf-place": {SEQUENCE, GRASP, HOLD},
    "soccer": {SEQUENCE},
    "stick-pull": {SEQUENCE, GRASP, PRECISION, HOLD},
    "stick-push": {SEQUENCE, GRASP, HOLD},
    "sweep": {SEQUENCE},
    "sweep-into": {SEQUENCE, PRECISION, HOLD},
    "window-close": set(),
    "window-open": set(),
}
