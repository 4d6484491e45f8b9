"""The beat and rhythm codes of annotation files, and what a preset calls them.

Codes: PhysioBank's, https://archive.physionet.org/physiobank/annotations.shtml.
"""

from __future__ import annotations

NORMAL = "beat"
PREMATURE = "premature"
MISSED = "missed_beat"

BEATS: dict[str, tuple[str, str]] = {
    "N": (NORMAL, ""),
    "L": ("bundle_branch_block", "left bundle branch block"),
    "R": ("bundle_branch_block", "right bundle branch block"),
    "B": ("bundle_branch_block", "bundle branch block"),
    "A": ("premature_atrial", "atrial premature"),
    "a": ("premature_atrial", "aberrated atrial premature"),
    "J": ("premature_nodal", "nodal (junctional) premature"),
    "S": ("premature_supraventricular", "supraventricular premature"),
    "V": ("premature_ventricular", "premature ventricular contraction"),
    "r": ("premature_ventricular", "R-on-T premature ventricular contraction"),
    "F": ("fusion", "fusion of ventricular and normal"),
    "e": ("escape_atrial", "atrial escape"),
    "j": ("escape_nodal", "nodal (junctional) escape"),
    "n": ("escape_supraventricular", "supraventricular escape"),
    "E": ("escape_ventricular", "ventricular escape"),
    "/": ("paced", "paced"),
    "f": ("fusion", "fusion of paced and normal"),
    "Q": ("unclassified", "unclassifiable"),
    "?": ("unclassified", "not classified during learning"),
}
"""Code of a beat: its kind and its words."""

OTHERS: dict[str, tuple[str, str]] = {
    "x": ("blocked_atrial", "P wave that no beat follows"),
    "!": ("flutter_wave", "ventricular flutter wave"),
    "[": ("flutter", "ventricular flutter or fibrillation begins"),
    "]": ("flutter", "ventricular flutter or fibrillation ends"),
    "+": ("rhythm", "rhythm"),
    "s": ("st_change", "ST segment changes"),
    "T": ("st_change", "T wave changes"),
    "~": ("signal_quality", "signal quality changes"),
    "|": ("artefact", "looks like a beat and is none"),
    '"': ("comment", ""),
}
"""Code of what is no beat: its kind and its words. Codes in neither table (waves, measurements) are
left out and counted."""

ORDINARY = frozenset({NORMAL, "bundle_branch_block", "paced"})
"""Kinds that make up a steady rhythm: ever so many of them are the ground, not what stands out."""
