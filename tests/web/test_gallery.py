"""Several timelines in one exported folder: a page that shows them, and one of each."""

from __future__ import annotations

import os

import pytest

import overview_dsp as ov
from tests.cli.running import overview
from tests.web.driving import DESKTOP, PHONE, until, violations
from tests.web.exported import opened_host

MATCHES = ("world-cup-final-2018", "world-cup-final-2018")
ADDRESS = "https://example.org/matches"


@pytest.fixture(scope="module")
def gallery(tmp_path_factory):
    folder = tmp_path_factory.mktemp("gallery") / "site"
    given = ("--to", "web", "--zoom-levels", 0, "--base-url", ADDRESS, "-o", folder)
    assert overview("export", *MATCHES, *given).code == 0
    return folder


def test_each_timeline_of_a_gallery_links_to_its_page_and_back(gallery, chromium):
    title = ov.load_timeline(MATCHES[0]).title
    names = (gallery / "gallery.txt").read_text().split()
    assert len(set(names)) == 2
    with opened_host(gallery) as host:
        context = chromium.new_context(viewport=PHONE)
        page = context.new_page()
        wrong = []
        page.on("console", lambda said: said.type == "error" and wrong.append(said.text))
        page.goto(host.url)
        assert page.locator("li a").all_text_contents() == [title, title]
        page.locator("li a").nth(1).click()
        until(page, "p.view && p.sound.node")
        assert page.url == f"{host.url}{names[1]}/"
        page.go_back()
        assert page.locator("li img").first.evaluate(
            "async (one) => { await one.decode(); return 1; }"
        )
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert wrong == []
        context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [PHONE, DESKTOP], ids=["phone", "desktop"])
def test_axe_finds_nothing_in_the_gallery(gallery, chromium, axe, scheme, size):
    with opened_host(gallery) as host:
        context = chromium.new_context(viewport=size, color_scheme=scheme)
        page = context.new_page()
        page.goto(host.url)
        assert violations(page, axe) == []
        context.close()


def test_where_the_folder_will_be_makes_pictures_addresses_whole(gallery):
    first = (gallery / "gallery.txt").read_text().split()[0]
    for page, base in (
        ("index.html", f"{ADDRESS}/{first}"),
        (f"{first}/index.html", f"{ADDRESS}/{first}"),
    ):
        text = (gallery / page).read_text()
        assert f'<meta property="og:image" content="{base}/preview.png">' in text
    assert f'<meta property="og:url" content="{ADDRESS}/{first}/">' in text


def test_a_gallery_is_replaced_by_one_and_no_other_folder_is(gallery, tmp_path):
    os.makedirs(tmp_path / "own")
    (tmp_path / "own" / "thesis.txt").write_text("years")
    told = overview("export", *MATCHES, "--to", "web", "--zoom-levels", 0, "-o", tmp_path / "own")
    assert told.code != 0
    assert "other files" in told.err
    assert overview("export", *MATCHES, "--to", "web", "--zoom-levels", 0, "-o", gallery).code == 0
    assert "og:url" not in (gallery / "index.html").read_text()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((*MATCHES, "--to", "ahap"), "only --to web allows several"),
        ((*MATCHES, "--to", "c"), "only --to web allows several"),
        ((MATCHES[0], "--to", "web", "--base-url", "example.org"), "must be the URL of a folder"),
        ((MATCHES[0], "--to", "web", "--base-url", "https://["), "must be the URL of a folder"),
        ((MATCHES[0], "--to", "ahap", "--base-url", ADDRESS), "--base-url does not apply to clips"),
    ],
)
def test_what_cant_be_exported_gives_a_one_line_error(given, words):
    told = overview("export", *given)
    assert told.code == 2
    assert words in told.err
    assert len(told.errors) == 1
