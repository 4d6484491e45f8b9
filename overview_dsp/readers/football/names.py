"""Short names for labels."""

from __future__ import annotations

_PARTICLES = frozenset(
    {"al", "bin", "da", "das", "de", "del", "della", "den", "der", "di", "do", "dos", "du", "el"}
    | {"la", "le", "st.", "ten", "ter", "van", "von"}
)


def short_name(full_name: str) -> str:
    """Return what a label calls a player: the family name, with its particles (`van Lunteren`).

    Two names: the second. Three or more: the last two, since full Spanish and Portuguese names
    carry two family names of which the first is the known one (`Messi Cuccittini`).
    """
    names: list[str] = []
    particles: list[str] = []
    for word in full_name.split():
        if names and word.lower() in _PARTICLES:
            particles.append(word)
        else:
            names.append(" ".join([*particles, word]))
            particles = []
    if particles:
        names.append(" ".join(particles))
    return " ".join(names[-2:] if len(names) > 2 else names[-1:])
