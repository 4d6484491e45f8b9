"""Is a haptic document what its format says? Every fault, a line each."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

from overview_dsp import validation
from overview_dsp.errors import InputError
from overview_dsp.offline.export import ahap, android, haptic, hjif
from overview_dsp.offline.export.reading import load_document

_CHECKS = {
    "Pattern": ahap.faults_of,
    "signals": haptic.faults_of,
    "perceptions": hjif.faults_of,
    "waveform": android.faults_of,
}
_MOST = 20
"""Faults that are told: the first ones are what the others come from."""


def check_clip(path: str | os.PathLike[str]) -> list[str]:
    """Say what is wrong with a haptic clip, by the rules of its format and what players do with it.

    Stricter than `read_clip`, which takes what can be played.

    Parameters
    ----------
    path : str or path
        An AHAP, `.haptic`, HJIF or Android file (JSON, or the XML of a waveform).

    Returns
    -------
    list of str
        A line a fault, the first 20; empty if there is none.

    Raises
    ------
    InputError
        It can't be read.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> written = ov.export.export(result, "hjif", "match.hjif")
    >>> ov.export.check_clip("match.hjif")
    []
    """
    validation.path(path, "a clip")
    if Path(path).suffix.lower() == ".xml":
        return _xml(Path(path))[:_MOST]
    try:
        document = load_document(path)
    except InputError as error:
        if ": not JSON" in str(error):
            return [str(error).partition(": ")[2]]
        raise
    for key, faults_of in _CHECKS.items():
        if isinstance(document, dict) and key in document:
            return faults_of(document)[:_MOST]
    return [f"none of {', '.join(_CHECKS)} is in it: neither AHAP, .haptic, HJIF nor Android"]


def _xml(path: Path) -> list[str]:
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: can't be read ({error})") from None
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        return ["it has a document type (<!DOCTYPE ...>), which may hide a bomb"]
    try:
        root = ElementTree.fromstring(text.encode())
    except (ElementTree.ParseError, ValueError) as error:
        return [f"not XML: {error}"]
    return android.xml_faults_of(root)
