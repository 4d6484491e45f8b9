"""NumPy files as series."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.errors import InputError
from tests.data.readers.outcome import timeline_or_one_line

TIMES = np.arange(300) / 10.0
VALUES = np.sin(TIMES)


def header(shape: tuple[int, ...], descr: str = "<f8") -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        stream, {"descr": descr, "fortran_order": False, "shape": shape}
    )
    return stream.getvalue()


@pytest.mark.parametrize(
    ("saved", "options"),
    [
        (VALUES, {"rate": 10.0}),
        (VALUES.astype(np.float32), {"rate": 10.0}),
        (np.stack([TIMES, VALUES], axis=1), {}),
        (np.stack([TIMES, VALUES]), {}),
        (np.asfortranarray(np.stack([TIMES, VALUES], axis=1)), {}),
        (np.rec.fromarrays([TIMES, VALUES], names="time,level"), {}),
    ],
)
def test_an_array_is_a_series(saved: Any, options: dict[str, Any], tmp_path: Path) -> None:
    np.save(tmp_path / "x.npy", saved)
    timeline = load_timeline(tmp_path / "x.npy", **options)
    assert timeline.intensity is not None
    assert np.allclose(timeline.intensity.time_s, TIMES)
    assert np.allclose(timeline.intensity.value, VALUES, atol=1e-6)


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_arrays_of_an_archive_are_its_columns(save: Any, tmp_path: Path) -> None:
    days = np.datetime64("2024-01-01") + np.arange(300)
    save(tmp_path / "x.npz", date=days, level=VALUES, about=np.zeros(3))
    timeline = load_timeline(tmp_path / "x.npz")
    assert timeline.title == "x: level"
    assert timeline.start is not None
    assert timeline.start.isoformat() == "2024-01-01T00:00:00"
    assert timeline.duration_s == 299 * 86_400.0
    assert any("another length are left out: about" in note for note in timeline.notes)
    save(tmp_path / "one.npz", VALUES)
    assert load_timeline(tmp_path / "one.npz", rate=10.0).duration_s == pytest.approx(29.9)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (header((10**15,)) + bytes(80), r"shape \(10{15},\), 8\d+ bytes, but 80 bytes follow"),
        (header((20,)) + bytes(80), "160 bytes, but 80 bytes follow"),
        (header((0,)), "no rows"),
        (header((2, 2, 2)) + bytes(64), "3 dimensions"),
        (header((2,), "|O") + bytes(16), "Python objects"),
        (b"\x93NUMPY\x01\x00\x05\x00{a()}", "no NumPy array"),
    ],
)
def test_an_unsuitable_array_gives_a_one_line_error(
    data: bytes, words: str, tmp_path: Path
) -> None:
    (tmp_path / "x.npy").write_bytes(data)
    with pytest.raises(InputError, match=words):
        load_timeline(tmp_path / "x.npy", rate=10.0)


def test_an_archive_that_claims_or_holds_too_much_is_refused(tmp_path: Path) -> None:
    for name, content in (("claims", b""), ("holds", bytes(3 * 2**20))):
        path = tmp_path / f"{name}.npz"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for member in ("a.npy", "b.npy"):
                archive.writestr(member, header((10**9 if not content else 3 * 2**17,)) + content)
        with pytest.raises(InputError, match=r"'[ab]': unpacks to more than .*--read max-mb"):
            load_timeline(path, max_mb=5.0)


def test_a_zip_of_other_files_is_still_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "x.zip", "w") as archive:
        archive.writestr("a.npy", "")
        archive.writestr("b.txt", "")
    with pytest.raises(InputError, match="of 2 files; unpack it"):
        load_timeline(tmp_path / "x.zip")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.data())
def test_any_damage_ends_in_a_timeline_or_a_one_line_error(
    tmp_path: Path, data: st.DataObject
) -> None:
    path = tmp_path / data.draw(st.sampled_from(["x.npy", "x.npz"]))
    if path.suffix == ".npy":
        np.save(path, np.stack([TIMES, VALUES], axis=1))
    else:
        np.savez(path, time=TIMES, level=VALUES)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, 200) | st.integers(0, len(content) - 1))
        content[at : at + data.draw(st.integers(0, 40))] = data.draw(st.binary(max_size=8))
    path.write_bytes(bytes(content) or b"x")
    timeline_or_one_line(lambda: load_timeline(path, rate=data.draw(st.sampled_from([None, 10.0]))))
