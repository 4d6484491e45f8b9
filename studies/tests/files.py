"""Study files for tests: small ones, each of another task."""

from __future__ import annotations

from overview_studies.design import load_design
from overview_studies.folder import make_lists
from overview_studies.stimuli import stimuli_of

IDENTIFY = """
title = "Touch against twist"
name = "touch-twist"
seed = 7
participants = 4

[factors]
mapping = { within = ["friction", "static"], order = "williams" }
input = { between = ["touch", "twist"] }

[task]
name = "identify"

[stimuli]
made = { kinds = ["goal", "foul"], variants = 2 }
presets = ["football"]
gestures = ["free"]

[phases]
practice = { repeats = 1, criterion = 0.5 }
main = { repeats = 3 }
catch = 0.25
attention = 1

[questionnaires]
start = ["consent"]
each = ["tlx"]
end = ["comments"]
consent = { version = "1", text = "I agree." }
"""

DETECT = """
title = "Was there a goal?"
seed = 3
participants = {participants}
factors = {{ {factors} }}
[task]
name = "identify"
[stimuli]
made = {{ kinds = ["goal"] }}
gestures = ["sweep:0.5"]
[phases]
main = {{ repeats = {repeats} }}
catch = 0.5
"""

LEVELS = """
title = "How strong"
seed = 5
participants = 2
[task]
name = "{task}"
vary = "kinds.goal.height"
{more}
[stimuli]
made = {{ kinds = ["goal"] }}
gestures = ["sweep:0.5"]
[stimuli.parameters]
"kinds.goal.height" = [2.0, 4.0, 8.0, 16.0, 32.0]
[phases]
main = {{ repeats = 4 }}
"""


def detecting(participants=24, repeats=32, factors=""):
    return DETECT.format(participants=participants, repeats=repeats, factors=factors)


def varying(task, more="standard = 8.0"):
    return LEVELS.format(task=task, more=more)


def other(task, more="", stimuli='made = { kinds = ["goal"], counts = [1, 2, 3] }'):
    return f"""
title = "Another task"
participants = 2
[task]
name = "{task}"
[stimuli]
{stimuli}
gestures = ["sweep:0.5"]
[phases]
main = {{ repeats = 2 }}
{more}
"""


def written(folder, text, name="study.toml"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def design_of(folder, text):
    return load_design(written(folder, text))


def lists_of(folder, text):
    design = design_of(folder, text)
    return make_lists(design, stimuli_of(design))


def study_of(folder, text):
    """study.json without what only a page plays, and the lists by number."""
    from overview_studies.folder import draft_study

    return draft_study(design_of(folder, text))
