"""Every program of the gallery runs by itself, and what it shows has words."""

from __future__ import annotations

import re
import runpy
import warnings

import matplotlib as mpl
import pytest

from tests.docs.markdown_blocks import ROOT

EXAMPLES = sorted((ROOT / "examples").glob("plot_*.py"))


@pytest.fixture
def drawn(monkeypatch, tmp_path):
    """A folder of its own; no window; the figures are closed afterwards."""
    mpl.use("agg")
    from matplotlib import pyplot as plt

    monkeypatch.chdir(tmp_path)
    plt.close("all")
    yield plt
    plt.close("all")


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_leaves_nothing_and_its_pictures_have_sentences(path, drawn, tmp_path):
    if "overview study" in path.read_text(encoding="utf-8"):
        pytest.importorskip("overview_studies", reason="needs the studies: pip install ./studies")
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        runpy.run_path(str(path), run_name="__main__")
    assert list(tmp_path.iterdir()) == []
    figures = [drawn.figure(number) for number in drawn.get_fignums()]
    assert figures
    for figure in figures:
        for axes in figure.axes:
            # sphinx-gallery makes the alternative text of it
            assert len(axes.get_title().split()) >= 6, path.name


def test_there_are_examples_for_each_sort_of_user():
    assert len(EXAMPLES) >= 8
    for path in EXAMPLES:
        text = path.read_text(encoding="utf-8")
        assert re.match(r'"""\n[^\n]+\n=+\n\n[^\n]{40,}', text), path.name
        assert not re.search(r"^\s*(?:from|import) overview_dsp\.", text, re.M), path.name
