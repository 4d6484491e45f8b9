"""The built documentation: nothing is fetched from elsewhere, and nothing is without words."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
import tomllib

import pytest

import overview_dsp as ov
from overview_dsp.cli import COMMANDS, SEPARATE_COMMANDS
from tests.docs.markdown_blocks import PAGES, ROOT

TOOLS = ("sphinx", "numpydoc", "sphinx_gallery", "pydata_sphinx_theme", "myst_parser",
         "sphinx_copybutton", "sphinx_design", "overview_studies")  # fmt: skip

# pages are trees of many objects, which Python's garbage collector looks through again and again
BUILD = (
    "import gc, sys; gc.set_threshold(100_000, 50, 100)\n"
    "from sphinx.cmd.build import main; sys.exit(main(sys.argv[1:]))"
)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The built pages: path (as in the address) to text."""
    missing = [name for name in TOOLS if importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"needs the docs extra: pip install '.[docs]' ./studies ({', '.join(missing)})")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-c", BUILD, "-W", "--keep-going", "-q", "-b", "html", "docs", folder],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr[-4000:]
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in folder.rglob("*.html")
        if not path.relative_to(folder).parts[0].startswith(("demo", "_"))
    }


def test_no_page_fetches_anything_from_another_host(site):
    fetched = re.compile(
        r'<(?:script|img|iframe|audio|source|link)\b[^>]*\b(?:src|href)="(?:https?:)?//[^"]+"'
    )
    for path, text in site.items():
        assert fetched.findall(text) == [], path


def test_every_picture_has_a_sentence(site):
    for path, text in site.items():
        if path in ("gallery/index.html", "search.html", "genindex.html"):
            continue  # its pictures stand beside their titles
        for tag in re.findall(r"<img\b[^>]*>", text):
            alt = re.search(r'alt="([^"]*)"', tag)
            assert alt, (path, tag)
            assert len(alt[1].split()) >= 5, (path, tag)
            assert not alt[1].startswith("plot "), (path, tag)


def test_every_player_has_a_name_and_a_transcript(site):
    players = 0
    for path, text in site.items():
        found = re.findall(r"<audio\b[^>]{0,400}", text)
        players += len(found)
        names = [re.search(r'aria-label="([^"]+)"', tag)[1] for tag in found]
        assert len(set(names)) == len(names), path
        assert text.count("<summary>Transcript:") == len(found), path
    assert players >= 8


def test_every_frame_has_a_title(site):
    frames = [tag for text in site.values() for tag in re.findall(r"<iframe\b[^>]*>", text)]
    assert frames
    assert all('title="' in tag for tag in frames)


def test_the_reference_has_every_public_name_and_every_command(site):
    pages = [text for path, text in site.items() if path.startswith("reference/generated/api/")]
    documented = {
        name for text in pages for name in re.findall(r'id="overview_dsp\.([\w.]+)"', text)
    }
    faces = ("presets", "measure", "export", "live", "actuators")
    for name in set(ov.__all__) - set(faces):
        assert name in documented, name
    for face in faces:
        for name in getattr(getattr(ov, face), "__all__", ()):
            assert name in documented or f"{face}.{name}" in documented, (face, name)
    for command in (*COMMANDS, *SEPARATE_COMMANDS):
        assert f"overview {command}" in site["reference/cli.html"]


def test_the_links_between_pages_lead_to_files():
    for page in PAGES:
        text = (ROOT / page).read_text(encoding="utf-8")
        text = re.sub(r"```.*?```", "", text, flags=re.S)
        for target in re.findall(r"\]\(([^)\s#]+)[^)]*\)", text):
            if re.match(r"https?:", target) or "generated/" in target or "gallery/" in target:
                continue  # made by the build, which checks them
            assert (ROOT / page.parent / target).exists(), (page, target)


def test_the_files_that_pages_name_are_there():
    named = re.compile(
        r"(?:overview_dsp|tools|presets|actuators|sensors|examples|docs|tests|studies)/[\w./-]+\.\w+"
    )
    made_by_the_build = ("docs/_build", "presets/feel")
    for page in PAGES:
        if page.name == "CHANGELOG.md":
            continue  # it names what was
        for path in named.findall((ROOT / page).read_text(encoding="utf-8")):
            if path.startswith(made_by_the_build):
                continue
            places = (ROOT / path, ROOT / "overview_dsp" / path, ROOT / page.parent / path)
            assert any(place.exists() for place in places), (page, path)


def test_the_citation_names_the_paper_and_this_version():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"version: {ov.__version__}" in text
    for part in ("Strachan", "Lefebvre", "Zijp-Rouzier", "MobileHCI 2009", "978-1-60558-281-8"):
        assert part in text
    assert "doi" not in text.lower()


def test_the_source_distribution_holds_docs_and_examples():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    included = project["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]
    assert {"docs", "examples", "CITATION.cff"} <= set(included)
