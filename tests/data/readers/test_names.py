from __future__ import annotations

import pytest

from overview_dsp.data.readers.football.match_timeline import short_name


@pytest.mark.parametrize(
    ("full", "short"),
    [
        ("Nikita Parris", "Parris"),
        ("Desiree van Lunteren", "van Lunteren"),
        ("Stefanie van der Gragt", "van der Gragt"),
        ("Lionel Andrés Messi Cuccittini", "Messi Cuccittini"),
        ("Gerard Piqué Bernabéu", "Piqué Bernabéu"),
        ("Neymar", "Neymar"),
        ("van Dijk", "van Dijk"),
        ("Di María", "Di María"),
        ("dos Santos Aveiro", "Santos Aveiro"),
        ("", ""),
        ("  ", ""),
        ("Ana de", "de"),
    ],
)
def test_a_label_gets_the_family_name(full: str, short: str) -> None:
    assert short_name(full) == short
