"""Report of a study: results.json, methods.txt, figures, tables and scripts."""

from __future__ import annotations

import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from overview_dsp.cli.extensions import atomic_folder, save_figure
from overview_dsp.cli.extensions import plot_style as style
from overview_studies.analysis import MOST_MISSING, Analysis, MeasureEstimate, condition_text
from overview_studies.answers import MARK, Answers
from overview_studies.figures import figures_of
from overview_studies.measures import DISTANCES, LEVELS, SHARE_AT_LIMIT, Missing
from overview_studies.scales import scale_of
from overview_studies.scripts import (
    MAIN_MEASURES,
    MEASURES,
    PYTHON_SCRIPT,
    R_SCRIPT,
    measures_csv,
    python_script,
    r_script,
)
from overview_studies.statistics import MAX_LAPSE
from overview_studies.tables import forms_csv, responses_csv
from overview_studies.thresholds import EXPONENT_SPREAD, LAPSE, MIN_REVERSALS

RESULTS = "results.json"


def write_report(analysis: Analysis, path: str | Path) -> list[str]:
    """Write the report folder atomically; return the names of its files.

    Raises
    ------
    InputError, OutputError
        The folder cannot be written, or contains other files.
    """
    answers = analysis.answers
    results = json.dumps(analysis.as_json(), indent=2, ensure_ascii=False, allow_nan=False)
    texts = {
        RESULTS: f"{results}\n",
        "methods.txt": methods_text(analysis),
        "responses.csv": responses_csv(answers),
        "forms.csv": forms_csv(answers),
        MEASURES: measures_csv(answers, analysis.measures),
        R_SCRIPT: r_script(answers),
        PYTHON_SCRIPT: python_script(answers),
    }
    with atomic_folder(path, answers.marked(RESULTS)) as folder:
        for name, text in texts.items():
            (folder / answers.marked(name)).write_text(text, encoding="utf-8")
        for name, figure in figures_of(analysis).items():
            if answers.simulated:
                figure.text(0.5, 0.5, MARK, fontsize=36, rotation=20, alpha=0.5,
                            color=style.VERMILION, ha="center", va="center", zorder=10)  # fmt: skip
            save_figure(figure, folder / answers.marked(name))
        return sorted(file.name for file in folder.iterdir())


def estimate_text(line: MeasureEstimate, digits: int = 2) -> str:
    """Return an estimate as text, such as 1.49 [1.31, 1.66]."""
    one = line.estimate
    if math.isnan(one.mean):
        return "no estimate"
    if math.isnan(one.low):
        return f"{one.mean:.{digits}f}"
    return f"{one.mean:.{digits}f} [{one.low:.{digits}f}, {one.high:.{digits}f}]"


def methods_text(analysis: Analysis) -> str:
    """Return a draft of the methods section, with all numbers."""
    return (
        "\n\n".join(
            part
            for part in (
                _participants(analysis),
                _design(analysis),
                _stimuli(analysis),
                _analysis(analysis),
                _results(analysis),
            )
            if part
        )
        + "\n"
    )


def _participants(analysis: Analysis) -> str:
    answers, study = analysis.answers, analysis.answers.study
    count = len(answers.sessions)
    parts = []
    who = "participants took part in"
    if answers.simulated:
        parts.append("SIMULATED DATA: no person took part; observers of known ability answered.")
        who = "simulated observers answered"
    excluded = [f"{code} ({why})" for code, why in analysis.excluded.items()]
    parts.append(
        f"{count} {who} the study {study['title']!r} (planned: {study['participants']}). "
        f"{_exclusion_rules(study)} Excluded: {', '.join(excluded) or 'no participant'}."
    )
    return " ".join(parts)


def _exclusion_rules(study: dict[str, Any]) -> str:
    rule = study["exclude"]
    rules = ["an answer that no participant can have given"]
    if rule["incomplete"]:
        rules.append("an incomplete session")
    if rule["attention"]:
        rules.append(f"less than {rule['attention']:.0%} of the attention trials correct")
    return f"Reasons for exclusion, set beforehand: {'; '.join(rules)}."


def _design(analysis: Analysis) -> str:
    answers, study = analysis.answers, analysis.answers.study
    order_texts = {"williams": "in the order of a Williams square", "full": "in every order",
            "blocks": "shuffled in blocks"}  # fmt: skip
    factors = [
        f"{name} ({', '.join(map(str, factor['levels']))}; "
        + ("between participants" if factor["kind"] == "between"
           else f"within participants, {order_texts[factor['order']]}") + ")"
        for name, factor in study["factors"].items()
    ]  # fmt: skip
    # repeated practice and runs that end early are not in the list
    counts = Counter(row["phase"] for row in answers.rows())
    trials = ", ".join(
        f"{counts[phase] / len(answers.sessions):.3g} {phase}"
        for phase in ("practice", "main", "catch", "attention")
        if counts[phase]
    )
    task = study["task"]
    task_text = f"The task was {task['name']!r}, with the question {task['question']!r}"
    task_text += (
        f" and the answers {', '.join(task['choices'])}." if task["name"] == "identify" else ""
    )
    return (
        f"{task_text} Factors: {'; '.join(factors) or 'none'}. Lists were made from the seed "
        f"{study['seed']} before data collection and assigned by the server, one per "
        f"participant. Trials per participant, on average: {trials}.{_adaptive_rule(answers)}"
    )


def _adaptive_rule(answers: Answers) -> str:
    """Return how a staircase or QUEST+ chooses the levels; empty for other tasks."""
    steps = [step for one in answers.lists.values() for step in one["steps"]]
    run = next((step for step in steps if step["type"] == "adaptive"), None)
    if run is None:
        return ""
    intervals = {
        "2afc": "Each trial had two intervals, one of them with the standard.",
        "yesno": "Each trial had one interval; catch trials, without a stimulus, did not change "
        "the level.",
    }
    if run["tracks"] is None:
        false_alarms = ", rate of false alarms" if run["method"] == "yesno" else ""
        rule = (
            f"QUEST+ presented the level with the least expected entropy in {run['most']} trials a "
            f"run; its {len(run['quest']['prior'])} hypotheses of a cumulative normal (threshold, "
            f"width, lapse rate{false_alarms}) had equal prior probabilities."
        )
    else:
        track = run["tracks"][0]
        share = 0.5 ** (1.0 / track["down"])
        rule = (
            f"{len(run['tracks'])} interleaved staircases went down after {track['down']} correct "
            f"answers in a row and up after a wrong one, which converges to {share:.1%} correct; "
            f"steps of {', '.join(map(str, track['steps']))} levels by reversal, "
            f"{track['reversals']} reversals each, at most {run['most']} trials a run."
        )
    return f" {intervals[run['method']]} {rule}"


def _stimuli(analysis: Analysis) -> str:
    study = analysis.answers.study
    stimuli = study["stimuli"].values()
    gestures = sorted({one["gesture"] for one in stimuli})
    free = "free" in gestures
    devices = {r["user_agent"] for r in analysis.answers.rows() if r["user_agent"]}
    rates = {r["sample_rate"] for r in analysis.answers.rows() if r["sample_rate"]}
    lags = [r["output_latency_ms"] for r in analysis.answers.rows()
            if r["output_latency_ms"] is not None]  # fmt: skip
    parts = [
        f"{len(study['stimuli'])} stimuli were made with overview-dsp {study['program']} from the "
        f"presets {', '.join(sorted({one['preset'] for one in stimuli}))}, "
        + ("explored freely" if free else f"played with the gestures {', '.join(gestures)}")
        + ("; every movement was recorded and replays bit for bit." if free else ".")
    ]
    if any(one["static"] for one in stimuli):
        parts.append(
            "In the static condition the position of the input set the amplitude of the same "
            "carrier directly, without the disk; each event was as strong (RMS over 10 ms) as with "
            "the friction model under a sweep of 2 s, or the stimulus's own gesture."
        )
    if study["mask"] is not None:
        parts.append(f"Noise of {study['mask']['level_db']:g} dBFS RMS masked other sounds.")
    if devices:
        parts.append(
            f"{len(devices)} kinds of browser at {', '.join(f'{rate:g}' for rate in sorted(rates))}"
            f" Hz, output latency {np.median(lags) if lags else math.nan:.0f} ms (median)."
        )
    parts.append(f"The study's file has the SHA-256 {study['design_sha256']}.")
    return " ".join(parts)


def _analysis(analysis: Analysis) -> str:
    parts = [
        "Estimates are means over participants, with one number each and 95 % bootstrap intervals "
        "(10,000 resamples of participants; percentiles widened for few participants, Hesterberg "
        "2015). Differences between levels are within participants where the factor is; of a "
        "factor between participants, each group is resampled apart.",
    ]
    task = analysis.answers.study["task"]
    if task["name"] in ("identify", "compare"):
        parts.append("d' and c have the log-linear correction (Hautus 1995).")
    if task["name"] == "identify":
        parts.append(
            "With more than two answers, each is compared with all others, and d' is their mean. "
            "Information transfer is that of the summed matrix, corrected after Miller and Madow. "
            "Accuracy is over main and catch trials, in which another answer is correct."
        )
    kind = scale_of(analysis.answers.study).kind
    level = {"log": "logarithm of the level", "index": "index of the level"}.get(kind, "level")
    no_threshold = (
        "outside of the presented levels, or from answers that are like guesses (likelihood ratio, "
        "p > 0.025)"
    )
    by_task = {
        "compare": f"Psychometric functions are cumulative normals of the {level} with one lapse "
        f"rate of all participants in each condition, at most {MAX_LAPSE:.0%}, fitted by maximum "
        "likelihood without priors; each resample has lapse rates of its own. Widths are corrected "
        "for the bias of small samples (Cox and Snell 1968). A "
        "point of equality outside of the compared levels is not reported.",
        "staircase": f"A threshold is the {level} with the share of correct answers to which the "
        f"staircase converges, by {_threshold_function(task)}, fitted by maximum likelihood to all "
        f"trials with a lapse rate of {LAPSE:.0%}. There is none with fewer than {MIN_REVERSALS} "
        f"reversals, or {no_threshold}.",
        "quest": f"A threshold is the posterior mean of the {level}. There is none in a run that "
        f"was not finished, or {no_threshold}.",
        "adjust": f"The adjusted quantity is the {level} less that of the standard. There is none "
        f"with more than {SHARE_AT_LIMIT:.0%} of the answers at the lowest or highest level.",
    }
    if task["name"] in by_task:
        parts.append(
            f"{by_task[task['name']]} Means and differences are of the same quantity. A mean is "
            f"given where at most {MOST_MISSING:.0%} of the participants in the condition have no "
            "such level."
        )
    return " ".join(parts)


def _threshold_function(task: dict[str, Any]) -> str:
    """Return which function of the level the trials of a staircase have."""
    if task["method"] == "yesno":
        return "a cumulative normal with a rate of false alarms"
    return (
        "a d' that is a power of the distance from the standard (the logarithm of the exponent has "
        f"a normal prior around 0, standard deviation {EXPONENT_SPREAD:g})"
    )


def _results(analysis: Analysis) -> str:
    parts = []
    main = {MAIN_MEASURES[analysis.answers.study["task"]["name"]], *LEVELS, *DISTANCES}
    for line in analysis.estimates:
        if line.measure in (*main, "accuracy", "information", "rt", "tlx"):
            digits = 0 if line.measure == "rt" else 2
            parts.append(
                f"{line.measure}, {condition_text(line.condition)}: {estimate_text(line, digits)}."
            )
    parts += [
        f"{line.measure}, difference {condition_text(line.condition)}: {estimate_text(line)}."
        for line in analysis.differences
        if line.measure in main
    ]
    parts += [missing_text(one) for one in analysis.missing]
    for condition, (above, of) in analysis.better_than_guessing.items():
        parts.append(
            f"{above} of {of} participants were above chance in {condition_text(condition)} (exact "
            "binomial test each, p < 0.05)."
        )
    return "\n".join(parts)


def missing_text(one: Missing) -> str:
    """Return a line on a participant without a level."""
    return (
        f"{one.measure}, {condition_text(one.condition)}: none of {one.participant}: {one.reason}"
    )


def summary(analysis: Analysis) -> list[str]:
    """Return one text line for each estimate and difference of the main measure."""
    main = MAIN_MEASURES[analysis.answers.study["task"]["name"]]
    lines = [f"{MARK}: no person took part"] if analysis.answers.simulated else []
    lines += [
        f"{main}, {condition_text(line.condition)}: {estimate_text(line)}"
        for line in (*analysis.estimates, *analysis.differences)
        if line.measure == main
    ]
    return lines + [missing_text(one) for one in analysis.missing]
