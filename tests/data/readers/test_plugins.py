"""Readers of other packages, found by their entry points."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from overview_dsp.data.readers import FORMATS, list_matches, load_timeline
from overview_dsp.data.readers.formats import GROUP, package_readers
from overview_dsp.errors import InputError, OverviewWarning
from tests.cli.running import overview

STEPS = """
    import overview_dsp as ov

    name = "steps (STEPS, then a time in seconds a line)"
    options = ("rate",)

    def sniff(head):
        return head.startswith(b"STEPS")

    def read(path, rate=1.0):
        with open(path) as file:
            times = [float(line) * rate for line in file.readlines()[1:]]
        if not times:
            raise ov.InputError("no step in it")
        return ov.Timeline("a walk", times[-1], tuple(ov.Event(t, "step") for t in times))
"""
Install = Callable[..., None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Install a package of one module with an entry point, for the time of a test."""
    site = tmp_path / "site"

    def put(code: str, module: str = "steps_of_a_test") -> None:
        site.mkdir(exist_ok=True)
        (site / f"{module}.py").write_text(textwrap.dedent(code))
        info = site / f"{module}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(f"[{GROUP}]\nsteps = {module}\n")
        package_readers.cache_clear()

    monkeypatch.syspath_prepend(str(site))
    package_readers.cache_clear()
    before = set(sys.modules)
    yield put
    for name in set(sys.modules) - before:
        if name.endswith("_of_a_test"):
            del sys.modules[name]
    package_readers.cache_clear()


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    (tmp_path / "walk.txt").write_text("STEPS\n1.0\n1.5\n2.5\n")
    return tmp_path / "walk.txt"


def test_a_format_of_another_package_is_read(install: Install, walk: Path) -> None:
    with pytest.raises(InputError, match=r"walk\.txt"):
        load_timeline(walk)
    install(STEPS)
    assert load_timeline(walk).kinds() == {"step": 3}
    assert load_timeline(walk, rate=2.0).duration_s == 5.0
    assert list_matches(walk) == ()


def test_the_guide_names_the_group_that_is_looked_up() -> None:
    guide = Path(__file__).parents[3] / "docs" / "guide" / "data.md"
    assert f'[project.entry-points."{GROUP}"]' in guide.read_text(encoding="utf-8")


def test_an_option_that_a_package_reader_does_not_take_is_refused(
    install: Install, walk: Path
) -> None:
    install(STEPS)
    with pytest.raises(InputError, match=r"walk.txt: steps .*: value does not apply"):
        load_timeline(walk, value="x")


def test_a_package_format_is_listed_before_the_own_formats(install: Install) -> None:
    install(STEPS)
    listed = overview("timeline", "formats").out.splitlines()
    assert listed[0].startswith("steps (STEPS, then")
    assert len(listed) == len(FORMATS) + 2


def test_the_error_of_a_package_reader_is_shown_as_it_is(install: Install, walk: Path) -> None:
    install(STEPS)
    walk.write_text("STEPS\n")
    with pytest.raises(InputError, match=r"walk\.txt: no step in it$"):
        load_timeline(walk)


def test_compressed_files_are_unpacked_for_a_package_reader(install: Install, walk: Path) -> None:
    import gzip

    install(STEPS)
    packed = walk.with_suffix(".txt.gz")
    packed.write_bytes(gzip.compress(walk.read_bytes()))
    assert load_timeline(packed).kinds() == {"step": 3}


@pytest.mark.parametrize(
    ("changed", "to", "words"),
    [
        ("float(line)", "[][1]", r"the reader of steps_of_a_test \(steps\) failed \(IndexError"),
        ("return ov.Timeline(", "return (", "gave a tuple, not a Timeline"),
    ],
)
def test_a_faulty_reader_gives_a_one_line_error(
    changed: str, to: str, words: str, install: Install, walk: Path
) -> None:
    install(STEPS.replace(changed, to))
    with pytest.raises(InputError, match=words) as caught:
        load_timeline(walk)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("import nothing_of_this_name", "can't be loaded .ModuleNotFoundError"),
        ("name = 'x'\ndef sniff(head): return True", "has no read"),
        (STEPS.replace('("rate",)', '("speed",)'), "can't be loaded .*unknown: speed; known: "),
        (STEPS.replace("return head.startswith", "return head.begins"), "failed to look at a file"),
    ],
)
def test_a_broken_package_is_warned_of_and_the_rest_is_read(
    code: str, words: str, install: Install, tmp_path: Path
) -> None:
    install(code)
    (tmp_path / "talk.csv").write_text("time_s,kind\n1,a\n2,b\n")
    with pytest.warns(OverviewWarning, match=words):
        timeline = load_timeline(tmp_path / "talk.csv")
    assert timeline.kinds() == {"a": 1, "b": 1}


def test_a_reader_may_list_several_in_a_file(install: Install, walk: Path) -> None:
    code = (
        textwrap.dedent(STEPS).replace('("rate",)', '("match",)').replace("rate=1.0", "match='1'")
    )
    code = code.replace(" * rate", " * int(match)")
    install(code + "\ndef matches(path):\n    return ['to work', 'home']\n")
    assert list_matches(walk) == ("to work", "home")
    assert load_timeline(walk, match="2").duration_s == 5.0
