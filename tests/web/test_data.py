"""The data of a page over a real socket: what it shows, sounds with and keeps."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from importlib.metadata import EntryPoint, entry_points

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.offline.export.browser_memory import encode_change
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.web.assets import WEB
from overview_dsp.web.media import open_media
from overview_dsp.web.site_data import event_fields, kind_styles, window_json
from overview_dsp.web.static_site import start_page, write_site
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


def test_a_server_has_the_files_that_a_folder_has(page, match, football, tmp_path):
    write_site(match, football, tmp_path / "site", levels=1)
    files = [path for path in (tmp_path / "site").rglob("*") if path.is_file()]
    told = page.get("/data/timeline.json").json()
    names = {path.relative_to(tmp_path / "site").as_posix() for path in files}
    sound = {f"sound/{name}" for name in ("0.packed", "back.packed", "5-44100.patch")}
    assert {"data/window-5.json"} | sound <= names
    for path in files:
        name = path.relative_to(tmp_path / "site").as_posix()
        # what keeps a folder for use without a network, and its picture for who shares it
        if name in ("files.js", "worker.js", "preview.png"):
            assert page.get(f"/{name}").status_code == 404
            continue
        answer = page.get("/" if name == "index.html" else f"/{name}")
        assert answer.status_code == 200, name
        if name == "index.html":
            assert start_page(answer.text, match) == path.read_text()
        elif name == "data/timeline.json":
            kept = json.loads(path.read_text())
            assert kept["server"] is None
            assert told["windows"][:6] == kept["windows"]
            same = {key: value for key, value in told.items() if key not in ("server", "windows")}
            assert same.items() <= kept.items()
        else:
            assert answer.content == path.read_bytes(), name


def test_a_page_receives_what_sounds_and_what_it_shows_first(page, match):
    server = page.get("/data/timeline.json").json()["server"]
    assert server == {
        "audio": "here",
        "window": [0.0, match.duration_s],
        "media": {"url": "/media", "type": "video/mp4", "offset_s": -3.5},
        "pages": [*entry_points(group="overview_dsp.pages").names],
    }


def test_any_window_is_drawn_as_the_surface_has_it(page, match, football):
    answer = page.post("/data/window", json={"window": [100.0, 2000.0]})
    part = match.window(100.0, 2000.0)
    drawn = answer.json()
    assert drawn == json.loads(json.dumps(window_json(part, build_surface(part, football), 100.0)))
    assert len(drawn["events"]) == len(part.events)
    changed = page.get("/data/preset").json()["preset"]
    changed["values"]["surface.angle_map"] = 0.0
    even = page.post("/data/window", json={"window": [100.0, 2000.0], "preset": changed}).json()
    assert even["angle_map"] is None
    assert drawn["angle_map"] is not None


@pytest.mark.parametrize(
    ("asked", "word"),
    [({"window": [5, 1]}, "window"), ({"window": [-1, 5]}, "window"), ({}, "window"),
     ({"window": [0, 1e9]}, "window"), ({"window": "x"}, "window"),
     ({"window": [0, 60], "preset": 5}, "preset"), ({"window": [0, 60], "x": 1}, "keys")],
)  # fmt: skip
def test_an_invalid_window_gives_a_one_line_error(page, asked, word):
    refused(page.post("/data/window", json=asked), word)


def test_a_preset_file_is_read_again_with_the_page(match, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('schema = 2\nextends = "football"\n')
    with served(match, plays=False, preset=str(path)) as server, server.client() as page:
        before = page.get("/sound/0.packed").content
        path.write_text('schema = 2\nextends = "football"\n[tactor]\ngain_db = -9\n')
        assert page.get("/sound/0.packed").content == before  # the page that is open keeps its own
        page.get("/data/timeline.json")
        assert page.get("/sound/0.packed").content != before
        assert page.get("/data/preset").json()["preset"]["values"]["tactor.gain_db"] == -9.0


def test_presets_come_by_name_with_the_parameter_table(page):
    names = page.get("/data/presets").json()
    assert "football" in names["bundled"]
    found = page.get("/data/preset?name=crowd").json()
    assert found["preset"]["name"] == "crowd"
    table = {row["id"]: row for row in found["parameters"]}
    gain = table["tactor.gain_db"]
    assert (gain["unit"], gain["choices"], gain["surface"]) == ("dB", [], False)
    assert gain["low"] < gain["default"] < gain["high"]
    assert table["disk.release"]["choices"] == ["recoil", "return"]
    assert table["surface.friction"]["surface"]
    assert page.get("/data/preset").json()["preset"]["name"] == "football"


@pytest.mark.parametrize("name", ["../football", "/etc/passwd", "football.toml", "x" * 300, ""])
def test_a_preset_is_never_a_path(page, name):
    refused(page.get("/data/preset", params={"name": name}), "unknown preset")
    refused(page.post("/data/window", json={"window": [0, 60], "preset": name}), "unknown preset")
    refused(
        page.post("/sound/change", json={"sample_rate": 48000, "after": name}), "unknown preset"
    )


def test_a_page_gets_the_native_engines_changes(page, match, football):
    changed = page.get("/data/preset").json()["preset"]
    changed["values"]["tactor.gain_db"] = -9.0
    asked = {"sample_rate": 48000, "before": "football", "after": changed, "window": [0, 50.0]}
    answer = page.post("/sound/change", json=asked)
    after = football.with_changes({"tactor.gain_db": -9.0})
    surface = build_surface(match.window(0.0, 50.0), after)
    assert answer.content == encode_change(football, after, 48000.0, surface)


CHANGE = {"sample_rate": 48000, "after": "football"}


@pytest.mark.parametrize(
    "asked",
    [{}, {"after": "football"}, {**CHANGE, "x": 1}, {**CHANGE, "sample_rate": 1e9},
     {**CHANGE, "sample_rate": True}, {**CHANGE, "sample_rate": "x"}, {**CHANGE, "after": 5},
     {**CHANGE, "before": {}}, {**CHANGE, "window": [5, 1]}, {**CHANGE, "window": [1]},
     {**CHANGE, "window": "ab"}, {**CHANGE, "window": [None, 2]}, {**CHANGE, "window": None},
     {**CHANGE, "sample_rate": 10**400}],
)  # fmt: skip
def test_an_impossible_engine_gives_a_one_line_error(page, asked):
    refused(page.post("/sound/change", content=json.dumps(asked)))


@pytest.mark.parametrize("body", [b"", b"[]", b"\xff", b"[" * 100_000, b'{"sample_rate": NaN}'])
def test_a_body_that_is_no_object_gives_a_one_line_error(page, body):
    refused(page.post("/sound/change", content=body))


def test_a_preset_is_kept_whole_and_found_again(page, own_folder):
    changed = page.get("/data/preset").json()["preset"]
    changed["values"]["tactor.gain_db"] = -9.0
    text = page.post("/preset/toml", json=changed).text
    answer = page.put("/preset/my-match", content=text)
    assert (answer.status_code, answer.json()) == (201, {"name": "my-match"})
    assert ov.load_preset("my-match").values["tactor.gain_db"] == -9.0
    assert "my-match" in page.get("/data/presets").json()["own"]
    refused(page.put("/preset/my-match", content=text), "already exists")
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
def test_a_preset_that_isnt_valid_gives_a_one_line_error_and_leaves_no_file(
    page, own_folder, name, text
):
    refused(page.put(f"/preset/{name}", content=text))
    assert not own_folder.exists() or not list(own_folder.iterdir())


def test_names_that_are_paths_lead_nowhere(page, own_folder):
    for name in ("../x", "..%2fx", "a/b", ""):
        assert page.put(f"/preset/{name}", content="schema = 2").status_code in (404, 405)
    assert not own_folder.exists()


def test_the_film_is_served_in_ranges(page):
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
    assert page.post("/data/timeline.json").status_code == 405
    assert page.put("/").status_code == 405


def test_the_whole_of_a_series_is_the_same_whichever_way_it_is_asked_for(tmp_path):
    value = np.cumsum(np.random.default_rng(5).normal(size=2000))
    rows = "".join(f"{time},{one:.3f}\n" for time, one in enumerate(value))
    (tmp_path / "walk.csv").write_text("time_s,value\n" + rows)
    timeline = ov.load_timeline(tmp_path / "walk.csv")
    whole = {"window": [0, timeline.duration_s]}
    with (
        served(timeline, plays=False, preset="series") as server,
        server.client(Origin=server.origin) as page,
    ):
        drawn = page.get("/data/window-0.json").json()
        assert page.post("/data/window", json=whole).json() == drawn
        change = page.post("/sound/change", json={**whole, "sample_rate": 48_000})
        series = ov.load_preset("series")
        assert change.content == encode_change(
            series, series, 48_000, build_surface(timeline, series)
        )
        # a closer look finds more in as much of it
        assert len(timeline.window(0, timeline.duration_s).events) > len(drawn["events"])


def test_a_series_and_a_bare_timeline_are_served_too(tmp_path):
    curve = ov.Intensity(np.arange(100.0), np.sin(np.arange(100.0)), "dB")
    times = [0.0, 10.0]
    timelines = [
        ov.Timeline("curve", 120.0, intensity=curve, gaps=((20.0, 30.0),)),
        ov.Timeline("events", 60.0, tuple(ov.Event(time, "goal") for time in times)),
    ]
    for timeline in timelines:
        with served(timeline, plays=False) as server, server.client() as page:
            assert page.get("/data/timeline.json").json()["title"] == timeline.title
            drawn = page.get("/data/window-0.json").json()
            # the curve ends before the timeline
            for i, level in enumerate(drawn["level"]):
                at = i / (len(drawn["level"]) - 1)
                known = not timeline.gaps or at <= 20 / 120 or 30 / 120 <= at <= 99 / 120
                assert level is None or 0.0 <= level <= 1.0
                assert level is not None or not known
            assert drawn["gaps"] == [[start / 120.0, end / 120.0] for start, end in timeline.gaps]
            assert page.get("/sound/0.packed").status_code == 200


def test_a_page_has_the_map_of_each_window(page, match, football):
    for window in ([0.0, match.duration_s], [1000.0, 2000.0]):
        drawn = page.post("/data/window", json={"window": window}).json()
        start, end = window
        part = match if end == match.duration_s else match.window(start, end)
        surface = build_surface(part, football)
        assert drawn["angle_map"]["position"] == surface.angle_map.position.tolist()
        assert drawn["angle_map"]["time_s"] == (start + surface.angle_map.time_s).tolist()
        positions = [event["position"] for event in drawn["events"]]
        assert positions == surface.angle_map.events.tolist()


def test_without_the_map_no_preset_of_a_page_has_one(match):
    with (
        served(match, plays=False, linear=True) as server,
        server.client(Origin=server.origin) as client,
    ):
        whole = {"window": [0.0, match.duration_s]}
        assert client.post("/data/window", json=whole).json()["angle_map"] is None
        for name in ("football", "football-stadium"):
            preset = client.get(f"/data/preset?name={name}").json()["preset"]
            assert preset["values"]["surface.angle_map"] == 0.0


@pytest.mark.parametrize("known", [(), ("goal", "own_goal", "near_miss", "foul"), "series"])
def test_each_kind_has_its_own_mark_which_the_page_can_draw(known, football, tmp_path):
    names = [*known, *(f"other_{i}" for i in range(14))] if known != "series" else ["note", "news"]
    events = tuple(ov.Event(float(i), kind) for i, kind in enumerate(names))
    timeline = ov.Timeline("kinds", 100.0, events)
    if known == "series":
        rows = [f"{i},{np.sin(i):.3f}" for i in range(100)]
        (tmp_path / "kinds.csv").write_text("\n".join(["time_s,value (V)", *rows]))
        timeline = replace(ov.load_timeline(tmp_path / "kinds.csv"), events=events)
        assert timeline.rules is not None
    styles = kind_styles(timeline, football)
    shapes = [style["shape"] for style in styles.values() if style["shape"] != "bar"]
    assert len(shapes) == len(set(shapes)) >= len(names)
    drawn = re.search(
        r"const SHAPES = {(.*?)^};", (WEB / "site" / "marks.js").read_text(), re.S | re.M
    )
    assert {shape.removeprefix("open_") for shape in shapes} <= set(
        re.findall(r"^  (\w+):", drawn[1], re.M)
    )


def test_a_page_of_a_package_that_cannot_be_loaded_is_left_out_with_a_warning(match, monkeypatch):
    broken = EntryPoint("broken", "no_such_package:routes", "overview_dsp.pages")
    monkeypatch.setattr("overview_dsp.web.data.entry_points", lambda group: [broken])
    with (
        pytest.warns(ov.OverviewWarning, match="the page broken of .*no_such_package.*left out"),
        served(match, plays=False) as running,
        running.client(Origin=running.origin) as client,
    ):
        assert client.get("/data/timeline.json").json()["server"]["pages"] == []


@pytest.mark.parametrize(
    ("kind", "label", "told"),
    [
        ("largest_fall", "-51.87 % to 1.65, 2000-09-29", {"label": "", "change": [-51.87, "%"]}),
        ("largest_rise", "+3 °C to 7.1 °C, 12:30", {"label": "", "change": [3.0, "°C"]}),
        ("largest_rise", "+3 to 7.1, 12:30", {"label": "", "change": [3.0, ""]}),
        ("crossing_up", "rises above 20 (20.0917), 2007-10-01", {"label": "rises above 20"}),
        ("split", "7:1 split to 100.3, 2014-06-09", {"label": "7:1 split"}),
        ("largest_rise", "+a lot", {"label": "+a lot"}),
        ("goal", "back to 1-1 (penalty)", {"label": "back to 1-1 (penalty)"}),
    ],
)
def test_the_words_of_an_event_have_no_value_and_no_date(kind, label, told):
    assert event_fields(ov.Event(1.0, kind, label)) == told


def test_goals_have_scores_by_their_sides_or_else_by_their_labels(match, football):
    def scores(timeline):
        surface = build_surface(timeline, football)
        told = window_json(timeline, surface, 0.0)["events"]
        return [(one["kind"], one["score"]) for one in told if "score" in one]

    after = ["1-0", "1-1", "2-1", "3-1", "4-1", "4-2"]
    assert scores(match) == list(zip(["own_goal", *["goal"] * 5], after, strict=True))
    bare = tuple(replace(one, side=0) for one in match.events)
    assert scores(replace(match, events=bare, sides=())) == scores(match)
    unnamed = tuple(replace(one, label="") for one in match.events)
    assert scores(replace(match, events=unnamed)) == scores(match)
