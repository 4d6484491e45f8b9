"""The exported folder: whole, light, and nobody else's files touched."""

from __future__ import annotations

import contextlib
import itertools
import json
import re
import shutil
import subprocess

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.files.atomic import atomic_folder
from overview_dsp.kernels.layout import CELLS
from overview_dsp.offline.export.browser_memory import encode_change, encode_engine
from overview_dsp.signal.surface.base_surface import rank_step
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.web.assets import folder_files, page_files
from overview_dsp.web.site_data import default_levels, site_windows
from overview_dsp.web.sound_data import pack, window_bytes
from overview_dsp.web.static_site import write_site
from tests.web.packed import unpacked
from tools.bundle_page import BUILD_INFO, BUNDLE, build_info, bundle


def test_the_page_is_light_and_fetches_nothing_from_elsewhere():
    own = page_files()
    # a page doesn't request these: an article has the element, the licence is for people, and
    # an index of several pages has a style of its own
    requested = own.keys() - {"embed.js", "LICENSE.txt", "gallery.css"}
    assert sum(len(own[name]) for name in requested) < 173_000
    assert sum(len(content) for content in folder_files(live=False).values()) < 151_000
    for name, content in own.items():
        if name.endswith((".js", ".css", ".html", ".webmanifest")):
            text = content.decode()
            assert "://" not in text, name
            assert not re.search("style=[\"']", text), name


def test_a_small_table_is_a_small_folder(tmp_path, match):
    curve = ov.Intensity(np.arange(12) * 86_400.0, np.arange(12.0) ** 2, "dollars")
    small = ov.Timeline("twelve", 11 * 86_400.0, intensity=curve)
    assert write_site(small, ov.load_preset("stocks"), tmp_path / "site") < 400_000
    assert default_levels(small) == 0
    long = ov.Intensity(np.arange(9000) * 60.0, np.arange(9000.0))
    assert default_levels(ov.Timeline("long", 9e5, intensity=long)) == 3
    assert default_levels(match) == 3
    assert default_levels(ov.Timeline("few", 6000.0, match.events)) == 1


def test_a_phone_gets_scripts_without_comments():
    for name, content in page_files().items():
        if name.endswith(".js"):
            assert not re.search(rb"(^|\s)//\s", content), name


def test_a_phone_gets_few_scripts_whose_imports_are_there():
    scripts = {name: file for name, file in page_files().items() if name.endswith(".js")}
    assert len(scripts.keys() - {"embed.js", "embedded.js"}) <= 8  # these are for articles
    for name, content in scripts.items():
        # "x" imported, import"x" for its effect, import("x") later
        for needed in re.findall(rb"(?:from|import\(?)\"\./([\w.]+)\"", content):
            assert needed.decode() in scripts, name
    assert not re.search(rb"(?:from|import)\"\./", scripts["main.js"])


def test_the_bundle_is_made_of_the_sources_as_they_are():
    assert (BUNDLE / BUILD_INFO).read_text() == build_info()


@pytest.mark.skipif(shutil.which("npm") is None, reason="needs npm: apt-get install npm")
def test_the_bundle_made_anew_is_the_one_in_the_package(tmp_path):
    try:
        bundle(tmp_path / "bundle")
    except subprocess.CalledProcessError as error:
        if error.cmd[0] == "npm":
            pytest.skip("needs a registry that npm can reach")
        raise
    again = {file.name: file.read_bytes() for file in (tmp_path / "bundle").iterdir()}
    assert again == {file.name: file.read_bytes() for file in BUNDLE.iterdir()}


def test_a_folder_is_whole_or_as_it_was(tmp_path, match, football):
    place = tmp_path / "site"
    write_site(match, football, place, levels=0)
    before = (place / "files.js").read_text()
    with contextlib.suppress(RuntimeError), atomic_folder(place, "files.js") as folder:
        (folder / "half").write_text("")
        raise RuntimeError
    assert (place / "files.js").read_text() == before
    assert [one.name for one in tmp_path.iterdir()] == ["site"]
    write_site(match, ov.load_preset("crowd"), place, levels=0)
    assert (place / "files.js").read_text() != before
    assert [one.name for one in tmp_path.iterdir()] == ["site"]


def patched(base: bytes, patch: bytes) -> bytes:
    """Bytes with the runs of a patch, as `sound_data` says."""
    replaces, runs = np.frombuffer(patch, "<u4", 2)
    assert not replaces
    made, at = bytearray(base), 8
    for _ in range(runs):
        column, count = np.frombuffer(patch, "<u4", 2, at).tolist()
        made[8 * column : 8 * (column + count)] = patch[at + 8 : at + 8 + 8 * count]
        at += 8 + 8 * count
    assert at == len(patch)
    return bytes(made)


def test_friction_by_rank_is_less_than_half_as_many_bytes(match, football):
    surface = build_surface(match, football)
    raw = window_bytes(surface, football, 48_000)
    step = rank_step(match, football, CELLS)
    assert len(pack(raw, step)) < len(pack(raw)) / 2
    assert unpacked(pack(raw, step)) == raw


def test_a_folder_sounds_as_the_native_engine_at_every_rate(match, football, tmp_path):
    write_site(match, football, tmp_path / "site", levels=1, seed=3)
    told = json.loads((tmp_path / "site/data/timeline.json").read_text())
    for rate in told["rates"]:

        def bytes_of(name, rate=rate):
            base = unpacked((tmp_path / "site/sound" / f"{name}.packed").read_bytes())
            patch = tmp_path / "site/sound" / f"{name}-{rate}.patch"
            return base if rate == told["rates"][0] else patched(base, patch.read_bytes())

        engine = ov.Engine(football, match, seed=3)
        engine.prepare(rate, 128)
        assert bytes_of("0") == encode_engine(engine)
        for i, window in enumerate(told["windows"]):
            part = match.window(window["start_s"], window["end_s"]) if i else match
            surface = build_surface(part, football)
            expected = encode_change(football, football, rate, surface)
            assert bytes_of(str(i) if i else "back") == expected


def test_other_peoples_files_are_never_replaced(tmp_path, match, football):
    (tmp_path / "thesis.txt").write_text("years")
    with pytest.raises(ov.InputError, match="other files"):
        write_site(match, football, tmp_path)
    with pytest.raises(ov.InputError, match="is a file"):
        write_site(match, football, tmp_path / "thesis.txt")
    assert [one.name for one in tmp_path.iterdir()] == ["thesis.txt"]


def test_the_windows_cover_the_whole_and_overlap(match):
    parts = site_windows(match, 2)
    assert [part.level for part in parts] == [0] + [1] * 5 + [2] * 17
    for level in (1, 2):
        one = [part for part in parts if part.level == level]
        assert (one[0].start_s, one[-1].end_s) == (0.0, match.duration_s)
        for before, after in itertools.pairwise(one):
            assert after.start_s == pytest.approx((before.start_s + before.end_s) / 2)
