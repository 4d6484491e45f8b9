"""Questionnaires of a study, including the raw TLX."""

from __future__ import annotations

from typing import Any

from overview_studies.design import Design
from overview_studies.lists import form_name

TLX = {
    # Hart and Staveland 1988; the raw TLX omits the pair comparisons
    "mental": ("Mental demand: how mentally demanding was the task?", "very low", "very high"),
    "physical": ("Physical demand: how physically demanding was it?", "very low", "very high"),
    "temporal": ("Temporal demand: how hurried was the pace?", "very low", "very high"),
    "performance": ("Performance: how successful were you?", "perfect", "failure"),
    "effort": ("Effort: how hard did you have to work?", "very low", "very high"),
    "frustration": ("Frustration: how irritated or stressed were you?", "very low", "very high"),
}


def forms_of(design: Design) -> dict[str, Any]:
    """Return the forms of a study by name, as stored in study.json."""
    forms = design.file.questionnaires
    found: dict[str, Any] = {}
    for name in [*forms.start, *forms.each, *forms.end]:
        if name == "tlx":
            found[name] = {
                "items": [
                    {"id": id, "question": question, "low": low, "high": high,
                     "min": 0, "max": 100, "step": 5}
                    for id, (question, low, high) in TLX.items()
                ]
            }  # fmt: skip
        elif name == "comments":
            question = "Do you have any comments?"
            found[name] = {"items": [{"id": "comments", "question": question, "lines": 5}]}
        elif name == "consent" and forms.consent is not None:
            found[name] = {"version": forms.consent.version, "text": forms.consent.text}
        else:
            found[form_name(name)] = {"file": f"forms/{form_name(name)}.html"}
    return found
