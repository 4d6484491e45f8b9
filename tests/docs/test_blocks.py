"""Every shell and Python block of README and docs runs, or says what it needs."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from tests.docs.markdown_blocks import ROOT, Block, all_blocks, blocks_of
from tests.docs.page_runner import Page, parsed, understood, without_modules

BLOCKS = all_blocks()
SHOWN = {"text", "c", "cpp", "js", "html", "toml", "json"}
"""Languages that are read, not run."""

DEVICES = {
    "a C compiler", "a sound output", "a recording", "a serial port", "a MIDI port", "a phone",
    "a cluster",
    "an editor", "a package registry", "a fresh environment", "a clone of the project",
    "five minutes", "both cores for a minute", "both cores for some seconds",
    "a program that writes angles", "a terminal", "a live service",
}  # fmt: skip
"""What a block may need that a test can't give it; its commands are parsed all the same."""

MODULES = {"extra batch": ("pyarrow", "fsspec"), "the studies": ("overview_studies",)}
"""What a block may need that may be installed: it runs where it is."""

RUN = [b for b in BLOCKS if b.language in ("python", "sh") and b.needs not in DEVICES]
MARKED = [b for b in BLOCKS if b.needs in DEVICES]


def runs(block: Block) -> bool:
    return block.needs not in DEVICES and not without_modules(MODULES.get(block.needs, ()))


@pytest.fixture(scope="module")
def things(tmp_path_factory):
    """The files that pages begin with: a match, tables, a preset, takes."""
    folder = tmp_path_factory.mktemp("things")
    match = ov.load_timeline("world-cup-final-2018")
    ov.save_timeline(match, folder / "match.json")
    (folder / "data").mkdir()
    shutil.copy(folder / "match.json", folder / "data" / "other.json")
    (folder / "takes").mkdir()
    ov.save_gesture(ov.tap(0.4, 0.1), folder / "takes" / "one.csv")
    (folder / "mine.toml").write_text('schema = 2\nextends = "football"\ntitle = "Mine"\n')
    days = np.arange("2023-01-02", "2024-07-01", dtype="datetime64[D]")
    level = 100.0 + np.cumsum(np.random.default_rng(1).normal(0.0, 1.0, len(days)))
    rows = "".join(f"{day},{value:.2f}\n" for day, value in zip(days, level, strict=True))
    (folder / "AAPL.csv").write_text("Date,Close\n" + rows)
    rows = "".join(
        f"{str(day)[8:]}.{str(day)[5:7]}.{str(day)[:4]},{value / 5.0:.1f}\n"
        for day, value in zip(days, level, strict=True)
    )
    (folder / "station.csv").write_text("day,temp_max\n" + rows)
    (folder / "sensor.txt").write_text("".join(f"{value:.3f}\n" for value in level))
    return folder


@pytest.fixture(scope="module")
def pages(tmp_path_factory, things):
    """A page's folder and names, made when its first block is run."""
    made: dict[Path, Page] = {}

    def page(path: Path) -> Page:
        if path not in made:
            folder = tmp_path_factory.mktemp("page") / "here"
            shutil.copytree(things, folder)
            made[path] = Page(folder, [block for block in BLOCKS if block.page == path])
        return made[path]

    return page


@pytest.mark.parametrize("block", RUN, ids=lambda block: block.name)
def test_a_block_runs_after_those_before_it(block, pages, monkeypatch):
    missing = without_modules(MODULES.get(block.needs, ()))
    if missing:
        pytest.skip(f"needs {block.needs}: {', '.join(missing)} not installed")
    page = pages(block.page)
    monkeypatch.chdir(page.folder)
    monkeypatch.setenv("OVERVIEW_PRESETS", str(page.folder / "own presets"))
    page.run_up_to(block, runs)


@pytest.mark.parametrize("block", MARKED, ids=lambda block: block.name)
def test_a_block_that_needs_a_device_is_understood(block):
    if block.language == "python":
        compile(block.text, block.name, "exec")
        return
    assert block.language == "sh"
    if "overview study" in block.text or "overview learn" in block.text:
        pytest.importorskip("overview_studies", reason="needs the studies: pip install ./studies")
    for line in block.text.splitlines():
        understood(line)


def test_every_block_has_a_language_and_a_mark_that_is_known():
    for block in BLOCKS:
        assert block.language in {"python", "sh", *SHOWN} or block.language.startswith("{"), block
        assert block.needs in {"", *DEVICES, *MODULES}, block
        assert "\npip " not in f"\n{block.text}" or block.needs, block


def test_what_needs_a_fresh_environment_is_run_by_ci():
    steps = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for block in BLOCKS:
        if block.needs == "a fresh environment":
            assert block.text.strip() in steps, block


def test_the_runner_sees_a_wrong_option_an_unknown_extra_and_a_missing_tool():
    for line in (
        "overview play x --hots 1",
        "pip install '.[webb]'",
        "pip install ./none",
        "python tools/none.py",
        "ls",
    ):
        with pytest.raises(AssertionError):
            understood(line)
    with pytest.raises(AssertionError, match="rendr"):
        parsed(["rendr"])


def test_a_mark_that_is_not_directly_before_a_block_is_an_error():
    with pytest.raises(ValueError, match="stands alone"):
        blocks_of(Path("x.md"), "<!-- needs: a phone -->\n\n```sh\nls\n```\n")


def test_a_broken_block_fails(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = "```python\nx = 1\n```\n\n```python\nassert x == 2\n```\n\n```sh\noverview rendr\n```\n"
    page = Page(tmp_path, blocks_of(Path("x.md"), text))
    with pytest.raises(AssertionError):
        page.run_up_to(page.blocks[1], runs)
    with pytest.raises(AssertionError, match="No such command"):
        page.run_up_to(page.blocks[2], runs)


def test_the_readme_is_short_and_shows_a_film_and_a_sound():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 120
    first_screen = "\n".join(text.splitlines()[:20])
    for folder, name, largest in (
        ("pictures", "film.gif", 2_000_000),
        ("sounds", "world-cup-final.mp3", 300_000),
    ):
        assert f"(docs/{folder}/{name})" in first_screen
        assert (ROOT / "docs" / folder / name).stat().st_size <= largest


def test_no_page_uses_a_name_that_moved():
    text = "\n".join(block.text for block in BLOCKS if block.language == "python")
    assert re.findall(r"^\s*(?:from|import) overview_dsp\.", text, re.M) == []
