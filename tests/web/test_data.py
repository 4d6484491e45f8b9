"""The data of a page over a real socket: what it shows, sounds with and keeps."""

from __future__ import annotations

import json
import math
import struct

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.surface import CELLS, build_surface
from overview_dsp.web.encoding import encode_change, encode_engine
from overview_dsp.web.media import open_media
from overview_dsp.web.surface_data import EVENT
from tests.web.serving import served

FILM = bytes(range(256)) * 400


@pytest.fixture(scope="module")
def server(match, tmp_path_factory):
    film = tmp_path_factory.mktemp("media") / "match.mp4"
    film.write_bytes(FILM)
    with served(match, plays=False, media=open_media(str(film), -3.5)) as running:
        yield running


@pytest.fixture
def page(server):
    with server.client(Origin=server.origin) as client:
        yield client


@pytest.fixture
def own_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("OVERVIEW_PRESETS", str(tmp_path / "own"))
    return tmp_path / "own"


def refused(answer, *words):
    assert answer.status_code == 400, answer.text
    assert answer.text.count("\n") == 1
    for word in words:
        assert word in answer.text


def test_a_page_is_told_the_timeline_as_the_surface_has_it(page, match):
    whole = page.get("/data/timeline?columns=513").json()
    assert whole["window"] == [0.0, match.duration_s]
    assert np.allclose(whole["curve"]["level"], match.normalised_levels(512), atol=1e-5)
    assert [event["time_s"] for event in whole["events"]] == [one.time_s for one in match.events]
    goal = match.event("goal", 2)
    start, end = goal.time_s - 60.0, goal.time_s + 60.0
    near = page.get("/data/timeline", params={"start": start, "end": end}).json()
    part = match.window(start, end)
    assert len(near["events"]) == len(part.events) > 2  # details too
    assert any(abs(event["time_s"] - goal.time_s) < 1e-9 for event in near["events"])
    assert near["kinds"] == part.kinds()
    assert len(near["curve"]["level"]) == len(near["curve"]["value"]) == 1024


@pytest.mark.parametrize(
    ("query", "word"),
    [("start=5&end=1", "window"), ("start=-1", "window"), ("end=1e9", "window"), ("end=nan", "end"),
     ("start=x", "start"), ("columns=1", "columns"), ("columns=1e9", "columns"),
     ("columns=2.5", "columns"), ("columns=inf", "columns")],
)  # fmt: skip
def test_a_window_that_is_none_is_one_clear_line(page, query, word):
    refused(page.get(f"/data/timeline?{query}"), word)


def test_the_surface_is_its_table_and_its_events(page, match, football):
    answer = page.get("/data/surface?start=100&end=2000&points=1025")
    data = answer.content
    points, count, zero = struct.unpack_from("<III", data, 4)
    assert (data[:4], points, zero) == (b"ovs1", 1025, 0)
    assert struct.unpack_from("<2d", data, 16) == (100.0, 2000.0)
    table = np.frombuffer(data, "<f4", points, 32)
    events = np.frombuffer(data, EVENT, count, 32 + 4 * points)
    assert len(data) == 32 + 4 * points + EVENT.itemsize * count
    surface = build_surface(match.window(100.0, 2000.0), football)
    assert table.max() == np.float32(surface.resistance.max())
    step = CELLS // 1024
    for i in (1, 500, 1023):
        half = step // 2  # the point in the middle of two may be either's
        near = surface.resistance[i * step - half + 1 : i * step + half].max()
        wide = surface.resistance[i * step - half : i * step + half + 1].max()
        assert np.float32(near) <= table[i] <= np.float32(wide)
    assert np.array_equal(events["place"], surface.place.astype("<f4"))
    assert np.array_equal(events["event"], surface.event)


def test_presets_come_by_name_with_the_parameter_table(page):
    names = page.get("/data/presets").json()
    assert "football" in names["bundled"]
    found = page.get("/data/preset?name=crowd").json()
    assert found["preset"]["name"] == "crowd"
    table = {row["id"]: row for row in found["parameters"]}
    assert table["tactor.gain_db"]["unit"]
    assert page.get("/data/preset").json()["preset"]["name"] == "football"


@pytest.mark.parametrize("name", ["../football", "/etc/passwd", "football.toml", "x" * 300, ""])
def test_a_preset_is_never_a_path(page, name):
    for path in ("/data/preset", "/data/surface"):
        refused(page.get(path, params={"name": name, "preset": name}), "no preset is called")
    refused(page.post("/sound/whole", json={"sample_rate": 48000, "preset": name}), "no preset")


def test_a_page_gets_the_native_engines_memory(page, match, football):
    asked = {"sample_rate": 44100, "preset": "football", "window": [0, 900.0], "seed": 7}
    answer = page.post("/sound/whole", json=asked)
    engine = ov.Engine(football, match.window(0.0, 900.0), seed=7)
    engine.prepare(44100, 128)
    assert answer.content == encode_engine(engine)


def test_a_page_gets_the_native_engines_changes(page, match, football):
    changed = page.get("/data/preset").json()["preset"]
    changed["values"]["tactor.gain_db"] = -9.0
    asked = {"sample_rate": 48000, "before": "football", "after": changed, "window": [0, 50.0]}
    answer = page.post("/sound/change", json=asked)
    after = football.with_changes({"tactor.gain_db": -9.0})
    surface = build_surface(match.window(0.0, 50.0), after)
    assert answer.content == encode_change(football, after, 48000.0, surface)


WHOLE = {"sample_rate": 48000, "preset": "football"}


@pytest.mark.parametrize(
    "asked",
    [{}, {"preset": "football"}, {**WHOLE, "x": 1}, {**WHOLE, "sample_rate": 1e9},
     {**WHOLE, "sample_rate": True}, {**WHOLE, "sample_rate": "x"}, {**WHOLE, "preset": 5},
     {**WHOLE, "preset": {}}, {**WHOLE, "window": [5, 1]}, {**WHOLE, "window": [1]},
     {**WHOLE, "window": "ab"}, {**WHOLE, "window": [None, 2]}, {**WHOLE, "seed": -1},
     {**WHOLE, "seed": 1.5}, {**WHOLE, "sample_rate": 10**400}],
)  # fmt: skip
def test_what_no_engine_can_be_is_one_clear_line(page, asked):
    refused(page.post("/sound/whole", content=json.dumps(asked)))


@pytest.mark.parametrize("body", [b"", b"[]", b"\xff", b"[" * 100_000, b'{"sample_rate": NaN}'])
def test_a_body_that_is_no_object_is_one_clear_line(page, body):
    refused(page.post("/sound/whole", content=body))


def test_a_preset_is_kept_whole_and_found_again(page, own_folder):
    changed = page.get("/data/preset").json()["preset"]
    changed["values"]["tactor.gain_db"] = -9.0
    text = page.post("/preset/toml", json=changed).text
    answer = page.put("/preset/my-match", content=text)
    assert (answer.status_code, answer.json()) == (201, {"name": "my-match"})
    assert ov.load_preset("my-match").values["tactor.gain_db"] == -9.0
    assert "my-match" in page.get("/data/presets").json()["own"]
    refused(page.put("/preset/my-match", content=text), "there already")
    again = text.replace("-9.0", "-6.0")
    assert page.put("/preset/my-match?replace=1", content=again).status_code == 201
    assert ov.load_preset("my-match").values["tactor.gain_db"] == -6.0
    assert [path.name for path in own_folder.iterdir()] == ["my-match.toml"]


@pytest.mark.parametrize(
    ("name", "text"),
    [("football", ""), ("a b", ""), (".hidden", ""), ("x" * 65, ""), ("nul", ""), ("a.b", ""),
     ("a%00b", ""), ("..%5Cx", ""), ("fine", "schema = "), ("fine", "schema = 2"),
     ("fine", 'schema = 2\nextends = "/etc/passwd.toml"'),
     ("fine", 'schema = 2\nextends = "../silk.toml"'), ("fine", 'schema = 2\nextends = "fine"'),
     ("fine", 'schema = 2\nextends = "crowd"\n[tactor]\ngain_db = 999')],
)  # fmt: skip
def test_a_preset_that_isnt_valid_is_one_clear_line_and_leaves_no_file(
    page, own_folder, name, text
):
    refused(page.put(f"/preset/{name}", content=text))
    assert not own_folder.exists() or not list(own_folder.iterdir())


def test_names_that_are_paths_lead_nowhere(page, own_folder):
    for name in ("../x", "..%2fx", "a/b", ""):
        assert page.put(f"/preset/{name}", content="schema = 2").status_code in (404, 405)
    assert not own_folder.exists()


def test_the_film_is_served_in_ranges(page):
    told = page.get("/data/session").json()
    assert told["media"] == {"url": "/media", "type": "video/mp4", "offset_s": -3.5}
    assert told["audio"] == "here"
    whole = page.get("/media")
    assert (whole.status_code, whole.content) == (200, FILM)
    assert whole.headers["accept-ranges"] == "bytes"
    for asked, part, range_told in (
        ("bytes=0-0", FILM[:1], f"bytes 0-0/{len(FILM)}"),
        ("bytes=500-999", FILM[500:1000], f"bytes 500-999/{len(FILM)}"),
        ("bytes=-7", FILM[-7:], f"bytes {len(FILM) - 7}-{len(FILM) - 1}/{len(FILM)}"),
        ("bytes=102000-", FILM[102000:], f"bytes 102000-{len(FILM) - 1}/{len(FILM)}"),
    ):
        answer = page.get("/media", headers={"Range": asked})
        assert (answer.status_code, answer.content) == (206, part)
        assert answer.headers["content-range"] == range_told
    assert page.get("/media", headers={"Range": "bytes=999999-"}).status_code == 416
    assert page.get("/media", headers={"Range": "bytes=0-1,5-9,7-8"}).status_code == 416
    assert page.get("/media", headers={"Range": "bytes=x"}).status_code in (200, 400, 416)
    assert page.head("/media").headers["content-length"] == str(len(FILM))


def test_the_film_needs_the_token_and_only_a_film_is_one(server, tmp_path):
    with server.client(None) as stranger:
        assert stranger.get("/media").status_code == 401
    for name in ("secret.txt", "none.mp4"):
        if name.endswith("txt"):
            (tmp_path / name).write_text("x")
        with pytest.raises(ov.InputError):
            open_media(str(tmp_path / name), 0.0)


def test_methods_that_arent_there_are_refused(page):
    assert page.delete("/preset/x").status_code == 405
    assert page.post("/data/timeline").status_code == 405
    assert page.put("/").status_code == 405


def test_a_series_and_a_bare_timeline_are_told_too(tmp_path):
    curve = ov.Intensity(np.arange(100.0), np.sin(np.arange(100.0)), "dB")
    times = [0.0, 10.0]
    timelines = [
        ov.Timeline("curve", 120.0, intensity=curve, gaps=((20.0, 30.0),)),
        ov.Timeline("events", 60.0, tuple(ov.Event(time, "goal") for time in times)),
    ]
    for timeline in timelines:
        with served(timeline, plays=False) as server, server.client() as page:
            told = page.get("/data/timeline?columns=16").json()
            assert told["title"] == timeline.title
            assert all(math.isfinite(level) for level in told["curve"]["level"])
            assert told["gaps"] == [list(gap) for gap in timeline.gaps]
            assert page.get("/data/surface").status_code == 200
