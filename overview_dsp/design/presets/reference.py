"""Parameter reference and JSON schema, made from the parameter table."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from overview_dsp.design.presets.model import TAG_SCALES
from overview_dsp.design.presets.parameter import value_text
from overview_dsp.design.presets.parameters import (
    KIND_PARAMETERS,
    MODE_PARAMETERS,
    PARAMETERS,
    SECTIONS,
)
from overview_dsp.design.presets.validation import LIST_DOCS, SCHEMA, preset_model

_HEAD = Path(__file__).with_name("reference_head.md").read_text(encoding="utf-8")


def reference() -> str:
    """Return the reference as Markdown."""
    parts = [_HEAD.format(schema=SCHEMA, tags=", ".join(f"`{name}`" for name in TAG_SCALES))]
    for section, members in SECTIONS.items():
        parts.append(f"## [{section}]\n\n{_table(members.values())}")
        if section == "surface":
            drawn = LIST_DOCS["map"][0].lower() + LIST_DOCS["map"][1:]
            parts.append(f"`points` (a list of 2 to 256 numbers): {drawn}\n")
    parts.append(
        "## [kinds.NAME]\n\nAn event kind's profile and click; exactly one of the two widths. "
        "`kinds.default` serves\nevents of any other kind.\n\n" + _table(KIND_PARAMETERS.values())
    )
    parts += [
        "`points` (a list of 2 to 256 numbers, 0 to 1) is a profile over two widths that replaces "
        "the shape. `aliases` (a list of names) are other event kinds that use this one,\n"
        "unless the preset names them.\n",
        "## kinds.NAME.modes\n\nA list of modal resonators, struck when the disk passes.\n\n"
        + _table(MODE_PARAMETERS.values()),
    ]
    return "\n".join(parts)


def _table(members: Any) -> str:
    rows = ["| key | default | range | meaning |", "|---|---|---|---|"]
    for known in members:
        text = "required" if known.default is None else value_text(known.default)
        rows.append(f"| `{known.key}` | {text} | {known.allowed} | {known.doc} |")
    return "\n".join(rows) + "\n"


_FIELDS = ("id", "default", "allowed", "low", "high", "choices", "surface", "unit", "scale", "doc")


def reference_json() -> list[dict[str, Any]]:
    """Return the reference as data, one dict per parameter.

    A number has no `choices` and is from `low` to `high`. `surface` is as in `Parameter`.
    """
    groups = (
        PARAMETERS.values(),
        (replace(known, id=f"kinds.NAME.{known.id}") for known in KIND_PARAMETERS.values()),
        (replace(known, id=f"kinds.NAME.modes.{known.id}") for known in MODE_PARAMETERS.values()),
    )
    return [
        {key: getattr(known, key) for key in _FIELDS} | {"choices": list(known.choices)}
        for members in groups
        for known in members
    ]


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of preset files, for TOML editors.

    A number may also be an expression: a text with a `$`.
    """
    schema: dict[str, Any] = _with_expressions(preset_model().model_json_schema(by_alias=True))
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "overView preset"
    schema["properties"]["schema"] = {"enum": list(range(1, SCHEMA + 1))}
    schema["properties"]["extends"] = {
        "type": "string",
        "description": "Preset with the values that this file does not set.",
    }
    schema["properties"]["drop"] = {
        "type": "array",
        "items": {"type": "string"},
        "description": "Kinds of the extended preset that are removed.",
    }
    schema["required"] = ["schema"]  # other keys may come from the extended preset
    for definition in schema["$defs"].values():
        definition.pop("required", None)
    return schema


def _with_expressions(node: Any) -> Any:
    if isinstance(node, list):
        return [_with_expressions(item) for item in node]
    if not isinstance(node, dict):
        return node
    found = {key: _with_expressions(value) for key, value in node.items()}
    if found.get("type") == "number":
        kept = {key: found.pop(key) for key in ("description", "default", "unit") if key in found}
        return {**kept, "anyOf": [found, {"type": "string", "pattern": r"\$"}]}
    return found
