"""Pages and the desk: a preset saved there, a server that goes and comes, hands of others."""

from __future__ import annotations

from math import cos, sin

import httpx
import pytest

from overview_dsp.errors import InputError
from overview_dsp.units import HALF_TURN
from overview_dsp.web.security.auth_token import Access, Verdict, load_token
from tests.cli.test_serve import MATCH, running
from tests.web.driving import at, until
from tests.web.serving import served
from tests.web.test_preset_editor import opened, slide
from tests.web.test_served_page import connected, page_of, says


@pytest.fixture
def own(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('schema = 2\nextends = "football"\n[tactor]\ngain_db = -3\n')
    return path


def test_a_saved_preset_is_used_by_every_page(match, chromium, own):
    with (
        served(match, plays=False, preset=str(own)) as server,
        page_of(server, chromium) as (one, wrong),
        page_of(server, chromium) as (other, _),
    ):
        for tab in (one, other):
            until(tab, "p.served?.presets.preset && p.sound.node")
            tab.evaluate("""() => {
                window.changed = 0;
                const change = overview.sound.node.change.bind(overview.sound.node);
                overview.sound.node.change = (bytes) => { changed += 1; change(bytes); };
            }""")
        own.write_text(own.read_text().replace("-3", "-11"))
        for tab in (one, other):
            until(tab, "p.data.preset?.values['tactor.gain_db'] === -11 && changed === 1")
        own.write_text("schema = 2\nnonsense")
        says(one, "fault", "mine.toml")
        own.write_text('schema = 2\nextends = "football"\n[tactor]\ngain_db = -7\n')
        until(one, "p.data.preset.values['tactor.gain_db'] === -7")
        assert one.text_content("#fault") == ""
        assert wrong == []


def test_an_open_editor_shows_the_saved_preset_and_keeps_the_users_changes(match, chromium, own):
    with (
        served(match, plays=False, preset=str(own)) as server,
        page_of(server, chromium) as (tab, wrong),
    ):
        until(tab, "p.served?.presets.preset && p.sound.node")
        opened(tab)
        slide(tab, "tactor", "tactor.gain_db", 1)
        tuned = tab.evaluate("overview.editor.preset.values['tactor.gain_db']")
        own.write_text(own.read_text().replace("-3", "-11"))
        says(tab, "editor-message", "mine was changed on the server and is now A; ")
        says(tab, "editor-message", "your changes are B")
        until(tab, "p.data.preset.values['tactor.gain_db'] === -11 && !p.editor.busy")
        slider = "#editor-rows input[name='tactor.gain_db']"
        assert tab.get_attribute("#editor-a", "aria-pressed") == "true"
        assert tab.get_attribute(slider, "aria-valuetext") == "-11 dB"
        tab.click("#editor-b")
        until(tab, f"p.data.preset.values['tactor.gain_db'] === {tuned} && !p.editor.busy")
        assert tab.get_attribute(slider, "aria-valuetext") == f"{tuned:g} dB"
        assert wrong == []


def test_inputs_of_a_host_see_each_other_by_name(match, chromium):
    with (
        served(match) as server,
        page_of(server, chromium) as (one, wrong),
        page_of(server, chromium) as (other, _),
    ):
        connected(one)
        connected(other)
        one.evaluate("overview.settings.name = 'Anna'; overview.apply()")
        one.mouse.move(*at(one, 0.4))
        one.mouse.down()
        says(other, "link", "Anna controls the disk")
        shown = other.locator("#others .active")
        assert shown.text_content() == "Anna"
        left = other.evaluate("overview.picture.geometry.x(0.4)")
        assert f"translateX({left:.1f}px)" in shown.get_attribute("style")
        one.mouse.up()
        says(other, "link", "connected to the host")
        assert wrong == []


def test_a_kept_token_lets_the_same_pages_in_after_a_restart(tmp_path):
    file = tmp_path / "token"
    with running("serve", MATCH, "--port", 0, "--token-file", file, folder=tmp_path) as server:
        with httpx.Client(base_url=server.origin) as client:
            client.post("/session", headers=server.headers)
            cookies = dict(client.cookies)
        first = server.token
        server.end()
    assert file.stat().st_mode & 0o777 == 0o600
    with running("serve", MATCH, "--port", 0, "--token-file", file, folder=tmp_path) as server:
        assert server.token == first
        port = server.origin.rpartition(":")[2]
        cookies = {f"overview-{port}": next(iter(cookies.values()))}
        answer = httpx.get(f"{server.origin}/data/timeline.json", cookies=cookies)
        assert answer.status_code == 200


def test_a_kept_token_is_one_or_a_line_says_why_not(tmp_path):
    token = load_token(str(tmp_path / "t"))
    assert load_token(str(tmp_path / "t")) == token
    access = Access(token=token)
    assert access.check(None, Access(token=token).session, "::1") is Verdict.ALLOWED
    assert access.check(None, Access(token="x" * 22).session, "::1") is Verdict.MISSING
    (tmp_path / "diary").write_text("dear diary")
    with pytest.raises(InputError, match="not a token"):
        load_token(str(tmp_path / "diary"))
    with pytest.raises(InputError, match="No such file"):
        load_token(str(tmp_path / "none" / "t"))


def test_a_server_that_cant_be_reached_is_reported(match, chromium):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, _):
        until(tab, "p.served?.presets.preset && p.sound.node")
        server.web.close()
        tab.click("#in")
        says(tab, "fault", "the server doesn't answer")


def test_a_page_goes_on_with_a_server_that_was_started_again(tmp_path, chromium, own):
    given = ("serve", MATCH, "--preset", own, "--token-file", tmp_path / "token", "--port")
    with (
        running(*given, 0, folder=tmp_path) as server,
        page_of(server, chromium, server.token) as (tab, _),
    ):
        until(tab, "p.served?.presets.preset && p.sound.node")
        port = server.origin.rpartition(":")[2]
        server.end()
        says(tab, "fault", "the server can't be reached: this page keeps working")
        tab.mouse.move(*at(tab, 0.2))
        tab.mouse.down()
        until(tab, "p.meters?.clock > 0 && Math.abs(p.cursor - 0.2) < 0.01")
        tab.mouse.up()
        with running(*given, port, folder=tmp_path):
            until(tab, "document.getElementById('fault').textContent === ''")
            tab.click("#in")
            until(tab, "p.view.zoom === 1")
            own.write_text(own.read_text().replace("-3", "-9"))
            until(tab, "p.data.preset?.values['tactor.gain_db'] === -9")
            assert tab.text_content("#fault") == ""


def test_twist_without_a_sensor_says_so(match, chromium):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, _):
        until(tab, "p.sound?.node")
        tab.click("#settings")
        tab.click("#twist")
        says(tab, "fault", "reports no motion")
        assert tab.get_attribute("#twist", "aria-pressed") == "false"


def test_the_drawn_disk_is_turned_by_a_circular_drag(match, chromium):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, wrong):
        until(tab, "p.sound?.node")
        tab.focus("#slider")
        tab.keyboard.press("PageUp")
        until(tab, "p.cursor > 0.09")
        tab.keyboard.press("Escape")
        tab.click("#settings")
        tab.get_by_role("checkbox", name="Circular drag").check()
        tab.get_by_text("Done").click()
        tab.wait_for_timeout(200)
        box = tab.locator("#disk").bounding_box()
        x, y, radius = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box["width"] / 3
        dial, left, top = tab.evaluate(
            "[overview.picture.geometry.dial, overview.picture.left, overview.picture.top]"
        )
        assert (x, y) == pytest.approx((left + dial["x"], top + dial["y"]), abs=1)
        tab.mouse.move(x - radius, y - 1)
        tab.mouse.down()
        until(tab, "p.input.active === 'touch' && p.position < 0.02")
        for half in (0, 1):
            for step in range(1, 21):
                angle = HALF_TURN * (1 + half / 2 + step / 40)
                tab.mouse.move(x + radius * cos(angle), y + radius * sin(angle))
            until(tab, f"Math.abs(p.cursor - {0.5 + half / 2}) < 0.01")
        tab.mouse.move(x + radius, y + 30)  # beyond the end
        tab.mouse.move(x - radius, y + 30)
        tab.wait_for_timeout(100)
        assert tab.evaluate("overview.position") == 1
        tab.mouse.up()
        assert wrong == []
