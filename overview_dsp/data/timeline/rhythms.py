"""What the rhythms of WFDB annotation files are called, for who reads a label.

Codes: those of PhysioBank's databases (mitdb, afdb, vfdb, cudb, ltafdb),
https://archive.physionet.org/physiobank/annotations.shtml. A rhythm holds until the next one.
"""

from __future__ import annotations

import re

KIND = "rhythm"
"""The kind of the events whose labels hold such a code."""

RHYTHMS: dict[str, str] = {
    "N": "normal rhythm",
    "NSR": "normal rhythm",
    "AB": "atrial bigeminy",
    "AFIB": "atrial fibrillation",
    "AFL": "atrial flutter",
    "ASYS": "asystole",
    "B": "ventricular bigeminy",
    "BI": "first-degree heart block",
    "BII": "second-degree heart block",
    "HGEA": "high-grade ventricular ectopic activity",
    "IVR": "idioventricular rhythm",
    "J": "nodal (AV junctional) rhythm",
    "NOD": "nodal (AV junctional) rhythm",
    "NOISE": "noise",
    "P": "paced rhythm",
    "PM": "paced rhythm",
    "PREX": "pre-excitation (Wolff-Parkinson-White)",
    "SBR": "sinus bradycardia",
    "SVTA": "supraventricular tachyarrhythmia",
    "T": "ventricular trigeminy",
    "VER": "ventricular escape rhythm",
    "VF": "ventricular fibrillation",
    "VFIB": "ventricular fibrillation",
    "VFL": "ventricular flutter",
    "VT": "ventricular tachycardia",
}
"""Code, without the bracket that opens it, and its name."""

_CODE = re.compile(r"rhythm \((\w+)\)?")


def rhythm_words(label: str) -> str:
    """Return the name of the rhythm that a label codes, `rhythm (AFIB`; any other as it is.

    A code that is in no table stays, without the bracket that nothing closes.
    """
    found = _CODE.fullmatch(label)
    return label if found is None else RHYTHMS.get(found[1], f"rhythm {found[1]}")
