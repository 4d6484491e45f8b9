"""A timeline that grows, on its pages: told, fetched, small."""

from __future__ import annotations

import asyncio
import base64
import contextlib
import json
import struct
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import httpx
import pytest

import overview_dsp as ov
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.web.live_data import LiveData
from overview_dsp.web.sound_data import window_bytes
from overview_dsp.web.static_publisher import KEPT_VERSIONS, StaticPublisher
from tests.live.stepped_session import event
from tests.web.packed import updated
from tests.web.serving import served


def update(client, since, rate=48_000):
    answer = client.get("/live/update", params={"since": since, "rate": rate})
    assert answer.status_code == 200
    (length,) = struct.unpack("<I", answer.content[:4])
    return json.loads(answer.content[4 : 4 + length]), answer.content[4 + length :]


class Listening:
    """The notices that a page gets, from a thread of its own."""

    def __init__(self, server, since="", more="", **headers):
        self.notices, self.at = [], []
        self._over = threading.Event()
        asked = (server, f"{since}{more}", headers)
        threading.Thread(target=self._run, args=asked, daemon=True).start()

    def _run(self, server, since, headers):
        with (
            contextlib.suppress(httpx.HTTPError),  # the server is closed
            server.client(**headers) as client,
            client.stream("GET", f"/live/events?since={since}", timeout=60) as answer,
        ):
            for line in answer.iter_lines():
                if line.startswith("data: "):
                    self.at.append(time.monotonic())
                    self.notices.append(json.loads(line[6:]))
                if self._over.is_set():
                    return

    def until(self, condition, seconds=30.0):
        end = time.monotonic() + seconds
        while not any(condition(one) for one in self.notices):
            assert time.monotonic() < end, self.notices
            time.sleep(0.01)
        return next(one for one in self.notices if condition(one))

    def close(self):
        self._over.set()


@pytest.fixture
def live():
    live = ov.LiveTimeline("Home - Away", expected_duration_s=5700.0)
    live.append(events=[event(0, "period"), event(300, "foul", "a")], clock_s=800.0)
    return live


@pytest.fixture
def server(live):
    with served(live.padded_snapshot(), plays=False, live=live) as server:
        yield server


def test_what_is_new_is_told_in_a_line_and_fetched_as_the_surface_of_the_moment(server, live):
    page = Listening(server, since=live.revision)
    with server.client() as client:
        first, patch = update(client, -1)
        assert first["packed"]
        mine = updated(b"", first, patch)
        assert len(patch) < len(mine) / 4
        assert first["info"]["duration_s"] == 5700.0
        assert [one["kind"] for one in first["view"]["events"]] == ["period", "foul"]
        assert first["view"]["gaps"] == [[800.0 / 5700.0, 1.0]]
        time.sleep(0.2)
        live.append(events=[event(900, "goal", "1-0")], clock_s=905.0)
        told = page.until(lambda one: one["changes"])
        assert [one["label"] for one in told["changes"]] == ["1-0"]
        assert told["status_text"] == "data until 15:05.0"
        assert len(json.dumps(told)) < 500
        second, patch = update(client, first["version"])
        assert second["version"] == told["version"]
        assert len(patch) < len(mine) / 2
        mine = updated(mine, second, patch)
        preset = ov.load_preset("football")
        assert mine == window_bytes(build_surface(live.padded_snapshot(), preset), preset, 48_000)
        live.retract("no such id")
        live.retract(event(900, "goal", "1-0"))
        page.until(lambda one: any(change["action"] == "retracted" for change in one["changes"]))
        live.end(910.0)
        assert page.until(lambda one: one["ended"])["status_text"] == "the end"
    page.close()


def surface_of(live, rate=48_000):
    preset = ov.load_preset("football")
    return window_bytes(build_surface(live.padded_snapshot(), preset), preset, rate)


def update_of(notice):
    made = base64.b64decode(notice["update"])
    (length,) = struct.unpack("<I", made[:4])
    return json.loads(made[4 : 4 + length]), made[4 + length :]


def test_updates_come_with_what_is_told_of_them_from_version_to_version(server, live):
    page = Listening(server, since=live.revision, more="&rate=48000&have=-1")
    first, patch = update_of(page.until(lambda one: True))
    mine = updated(b"", first, patch)
    assert mine == surface_of(live)
    taken = 1
    for n in range(3):
        live.append(events=[event(900 + 60 * n, "goal", str(n))], clock_s=901.0 + 60 * n)
        page.until(lambda one, n=n: any(change["label"] == str(n) for change in one["changes"]))
        for notice in page.notices[taken:]:
            update, patch = update_of(notice)
            assert update["version"] == notice["version"]
            assert len(patch) < len(mine) / 2
            mine = updated(mine, update, patch)
        taken = len(page.notices)
        assert mine == surface_of(live)
    page.close()
    # one that was cut off goes on from the last event that it had
    live.append(events=[event(1200, "foul", "late")], clock_s=1201.0)
    again = Listening(server, more="&rate=48000&have=-1",
                      **{"Last-Event-ID": str(update["version"])})  # fmt: skip
    update, patch = update_of(again.until(lambda one: True))
    assert updated(mine, update, patch) == surface_of(live)
    again.close()


def test_a_hundred_pages_that_have_the_same_get_one_events_bytes(live):
    data = LiveData(live, lambda: ov.load_preset("football"))
    made = []
    build = data.update
    data.update = lambda *key: made.append(key) or build(*key)

    async def pages():
        live.append(events=[event(900, "goal", "1-0")], clock_s=905.0)
        data.refresh()
        return await asyncio.gather(*(data._event(0, -1, 0) for _ in range(100)))

    with ThreadPoolExecutor(1) as thread:  # a loop of its own: a browser's may run in this one
        answers = thread.submit(asyncio.run, pages()).result()
    assert made == [(-1, 0)]
    assert len({id(text) for _, text in answers}) == 1
    assert len(answers[0][1]) < 40_000


def test_a_series_has_its_values_also_where_it_began_with_none():
    live = ov.LiveTimeline("load", expected_duration_s=3600.0, unit="kW")
    with (
        served(live.padded_snapshot(), plays=False, live=live) as server,
        server.client() as client,
    ):
        assert client.get("/data/timeline.json").json()["series"]["unit"] == "kW"
        for now in (60.0, 120.0):
            values = [(float(t), 20.0 + t / 7.0) for t in range(0, int(now) + 1, 10)]
            live.append(intensity=values, clock_s=now)
            told, _ = update(client, -1)
            assert told["info"]["series"]["unit"] == "kW"
            points = client.get("/data/points-0.json").json()
            assert points["time_s"] == [at for at, _ in values]
            assert points["value"] == pytest.approx([value for _, value in values])
            low, span = told["view"]["scale"]
            assert (low, low + span) == pytest.approx((20.0, values[-1][1]))


def test_a_page_that_reconnects_receives_the_missed_changes(server, live):
    version = live.revision
    for n in range(3):
        live.append(events=[event(900 + n, "goal", f"{n + 1}-0")])
    page = Listening(server, **{"Last-Event-ID": str(version)})
    told = page.until(lambda one: True)
    assert [one["label"] for one in told["changes"]] == ["1-0", "2-0", "3-0"]
    page.close()
    with server.client() as client:
        known = client.get("/data/timeline.json").json()["live"]
    assert known["levels"] == 4
    fresh = Listening(server, since=known["version"])  # nothing is new to it
    live.append(events=[event(990, "goal", "4-0")])
    assert [one["label"] for one in fresh.until(lambda one: one["changes"])["changes"]] == ["4-0"]
    fresh.close()


def test_windows_and_the_first_files_are_of_the_timeline_as_it_is(server, live):
    with server.client(Origin=server.origin) as client:
        live.layout = "so far"
        live.append(clock_s=1000.0, events=[event(950, "goal", "x")])
        assert client.get("/data/timeline.json").json()["duration_s"] == 1030.0
        window = {"window": [900.0, 1000.0]}
        shown = client.post("/data/window", content=json.dumps(window)).json()
        assert "goal" in [one["kind"] for one in shown["events"]]


def test_live_events_need_the_token(server):
    with server.client(token=None) as client:
        assert client.get("/live/events").status_code == 401
        assert client.get("/live/update?since=-1&rate=48000").status_code == 401
    with server.client() as client:
        assert client.get("/live/events?since=0&rate=1").status_code == 400
        for query in ("", "?since=x&rate=48000", "?since=-1&rate=1", "?since=-1&rate=1e9"):
            answer = client.get(f"/live/update{query}")
            assert answer.status_code == 400
            assert answer.text.count("\n") == 1


def test_more_pages_than_the_usual_limit_receive_live_events(server, live):
    pages = [Listening(server, since=live.revision) for _ in range(70)]
    time.sleep(2.0)
    live.append(events=[event(900, "goal", "1-0")])
    for page in pages:
        page.until(lambda one: one["changes"])
        page.close()


def test_a_folder_is_kept_up_for_any_host(live, tmp_path):
    notes = []
    folder = tmp_path / "site"
    football = ov.load_preset("football")
    published = StaticPublisher(live, football, folder, notes.append, interval_s=0.02)
    try:
        told = json.loads((folder / "data" / "timeline.json").read_bytes())
        assert told["live"] == {"levels": 0, "version": live.revision, "poll_s": 0.02}
        assert told["server"] is None
        for n in range(8):
            live.append(events=[event(900 + n, "goal", f"{n}-0")], clock_s=910.0 + n)
            end = time.monotonic() + 30.0
            now = {}
            while now.get("version") != live.revision:
                assert time.monotonic() < end
                time.sleep(0.01)
                now = json.loads((folder / "live" / "now.json").read_bytes())
                # whatever it names is there
                assert (folder / "live" / f"{now['version']}-44100.update").stat().st_size > 1e4
        assert [one["label"] for one in now["changes"] if one["kind"] == "goal"][-1] == "7-0"
        kept = set()
        while len(kept) != 1 + 2 * (KEPT_VERSIONS + 1):  # the oldest go last
            assert time.monotonic() < end, kept
            kept = {path.name for path in (folder / "live").iterdir()}
        assert f"{now['version']}-48000.update" in kept
        content = (folder / "live" / f"{now['version']}-48000.update").read_bytes()
        (length,) = struct.unpack("<I", content[:4])
        view = json.loads(content[4 : 4 + length])
        surface = build_surface(live.padded_snapshot(), football)
        assert updated(b"", view, content[4 + length :]) == window_bytes(surface, football, 48_000)
    finally:
        published.close()
    assert notes == []


def test_a_folder_of_a_series_has_the_values_of_each_version(tmp_path):
    live = ov.LiveTimeline("load", expected_duration_s=3600.0, unit="kW")
    live.append(intensity=[(0.0, 1.5), (60.0, 2.5)])
    folder = tmp_path / "site"
    published = StaticPublisher(live, ov.load_preset("series"), folder, print, interval_s=0.02)
    live.append(intensity=[(120.0, 4.25)])
    published.close()
    version = json.loads((folder / "live" / "now.json").read_bytes())["version"]
    points = json.loads((folder / "live" / f"{version}-points.json").read_bytes())
    assert points == {"time_s": [0, 60, 120], "value": [1.5, 2.5, 4.25]}
