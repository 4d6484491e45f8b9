"""Report of a study: results.json, methods.txt, figures, tables and an R script."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from overview_dsp.cli.extensions import atomic_folder, save_figure
from overview_dsp.cli.extensions import plot_style as style
from overview_studies.analysis import MOST_MISSING, Analysis, MeasureEstimate, condition_text
from overview_studies.answers import MARK
from overview_studies.figures import MAIN_MEASURES, figures_of
from overview_studies.measures import LAST_REVERSALS, Missing
from overview_studies.scales import scale_of
from overview_studies.tables import R_SCRIPT, forms_csv, r_script, responses_csv

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
        R_SCRIPT: r_script(answers),
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
        f"{count} {who} the study {study['title']!r} (planned: "
        f"{study['participants']}). "
        + (
            f"Excluded by rules set beforehand: {', '.join(excluded)}."
            if excluded
            else "No participant was excluded."
        )
    )
    return " ".join(parts)


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
    counts: dict[str, list[int]] = {}
    for session in answers.sessions:
        of = [s for s in answers.lists[session.number]["steps"] if s["type"] == "trial"]
        for phase in ("practice", "main", "catch", "attention"):
            counts.setdefault(phase, []).append(sum(step["phase"] == phase for step in of))
    trials = ", ".join(
        f"{np.mean(number):.3g} {phase}" for phase, number in counts.items() if sum(number)
    )
    task = study["task"]
    task_text = f"The task was to {task['name']}: {task['question']!r}"
    task_text += (
        f" with the answers {', '.join(task['choices'])}." if task["name"] == "identify" else ""
    )
    return (
        f"{task_text} Factors: {'; '.join(factors) or 'none'}. Lists were made from the seed "
        f"{study['seed']} before data collection and assigned by the server, one per "
        f"participant{f'; trials of a list: {trials}' if trials else ''}."
    )


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
        "2015). Differences between levels are within participants where the factor is.",
    ]
    task = analysis.answers.study["task"]
    if task["name"] in ("identify", "compare"):
        parts.append("d' and c have the log-linear correction (Hautus 1995).")
    if task["name"] == "identify":
        parts.append(
            "With more than two answers, each is compared with all others, and d' is their mean. "
            "Information transfer is that of the summed matrix, corrected after Miller and Madow."
        )
    if task["name"] in ("compare", "staircase", "quest"):
        kind = scale_of(analysis.answers.study).kind
        axis = {"log": "the logarithm of the level", "index": "the index of the level"}
        parts.append(
            f"Psychometric functions are cumulative normals of {axis.get(kind, 'the level')} with "
            "a lapse rate up to 6 %, fitted by maximum likelihood without priors; means and "
            "differences are of the same quantity."
        )
        parts.append(
            f"A staircase has no threshold with fewer than {LAST_REVERSALS} reversals, or with a "
            "third of the last ones at the lowest or highest level; QUEST+ and points of equality "
            "have none outside of the levels. A mean is given where at most "
            f"{MOST_MISSING:.0%} of the participants have no such level."
        )
    return " ".join(parts)


def _results(analysis: Analysis) -> str:
    parts = []
    main = MAIN_MEASURES[analysis.answers.study["task"]["name"]]
    for line in analysis.estimates:
        if line.measure in (main, "accuracy", "information", "rt", "tlx"):
            digits = 0 if line.measure == "rt" else 2
            parts.append(
                f"{line.measure}, {condition_text(line.condition)}: {estimate_text(line, digits)}."
            )
    parts += [
        f"{line.measure}, difference {condition_text(line.condition)}: {estimate_text(line)}."
        for line in analysis.differences
        if line.measure == main
    ]
    parts += [missing_text(one) for one in analysis.missing]
    for condition, (above, of) in analysis.above_chance.items():
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
    main: Any = MAIN_MEASURES[analysis.answers.study["task"]["name"]]
    kept = [line for line in analysis.estimates if line.measure == main]
    lines = [f"{MARK}: no person took part"] if analysis.answers.simulated else []
    lines += [f"{main}, {condition_text(line.condition)}: {estimate_text(line)}" for line in kept]
    lines += [
        f"{main}, {condition_text(line.condition)}: {estimate_text(line)}"
        for line in analysis.differences
        if line.measure == main
    ]
    return lines + [missing_text(one) for one in analysis.missing]
