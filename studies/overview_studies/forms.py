"""Questionnaires: what each asks, and the raw TLX's score."""

from __future__ import annotations

from typing import Any

from overview_studies.design import Design
from overview_studies.lists import form_name

TLX = {
    # Hart and Staveland 1988; raw: without the pair comparisons
    "mental": ("Mental demand: how mentally demanding was the task?", "very low", "very high"),
    "physical": ("Physical demand: how physically demanding was it?", "very low", "very high"),
    "temporal": ("Temporal demand: how hurried was the pace?", "very low", "very high"),
    "performance": ("Performance: how successful were you?", "perfect", "failure"),
    "effort": ("Effort: how hard did you have to work?", "very low", "very high"),
    "frustration": ("Frustration: how irritated or stressed were you?", "very low", "very high"),
}


def forms_of(design: Design) -> dict[str, Any]:
    """The forms that a study asks for, by name, as study.json has them."""
    asked = design.file.questionnaires
    found: dict[str, Any] = {}
    for name in [*asked.start, *asked.each, *asked.end]:
        if name == "tlx":
            found[name] = {
                "items": [
                    {"id": id, "question": question, "low": low, "high": high,
                     "min": 0, "max": 100, "step": 5}
                    for id, (question, low, high) in TLX.items()
                ]
            }  # fmt: skip
        elif name == "comments":
            question = "Is there anything you would like to tell us?"
            found[name] = {"items": [{"id": "comments", "question": question, "lines": 5}]}
        elif name == "consent" and asked.consent is not None:
            found[name] = {"version": asked.consent.version, "text": asked.consent.text}
        else:
            found[form_name(name)] = {"file": f"forms/{form_name(name)}.html"}
    return found
