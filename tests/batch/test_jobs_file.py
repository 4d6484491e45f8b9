from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.batch import RenderGrid, load_jobs
from overview_dsp.batch.grid import Settings
from tests.batch.grids import CASES, JOBS, grid_in

REST = 'out = "o"\ntimelines = ["world-cup-final-2018"]\ngestures = ["tap:1"]\n'


def test_a_grid_has_every_combination_once_with_seeds_fastest(tmp_path):
    study = grid_in(tmp_path)
    assert len(study) == CASES
    cases = [study.case(index) for index in range(len(study))]
    places = {(c.timeline, c.preset, c.gesture, c.values, c.seed) for c in cases}
    assert len(places) == CASES
    assert [case.index for case in cases] == list(range(CASES))
    assert [case.seed for case in cases[:4]] == [0, 1, 2, 0]
    assert [case.values for case in cases[:4]] == [(-6.0,)] * 3 + [(0.0,)]
    assert [case.timeline for case in cases] == sorted(case.timeline for case in cases)


@given(
    sizes=st.lists(st.integers(1, 4), min_size=3, max_size=6),
    seeds=st.lists(st.integers(-(2**62), 2**62), min_size=1, max_size=4, unique=True),
)
def test_any_grid_numbers_its_cases_from_0_without_a_gap(sizes, seeds):
    timelines, presets, gestures, *parameters = (
        {str(i): None for i in range(size)} for size in sizes
    )
    values = {str(n): tuple(map(float, of)) for n, of in enumerate(parameters)}
    study = RenderGrid("o", timelines, presets, gestures, values, tuple(seeds), Settings())
    cases = [study.case(index) for index in range(len(study))]
    assert len({(c.timeline, c.preset, c.gesture, c.values, c.seed) for c in cases}) == len(study)


def test_parts_of_a_timeline_and_files_beside_the_jobs_are_found(tmp_path):
    timeline = ov.Timeline("t", 10.0, (ov.Event(5.0, "goal"), ov.Event(8.0, "foul")))
    (tmp_path / "data").mkdir()
    for name in ("b", "a"):
        ov.save_timeline(timeline, tmp_path / "data" / f"{name}.json")
    ov.save_gesture(ov.tap(0.3, 0.2), tmp_path / "take.csv")
    (tmp_path / "mine.toml").write_text('schema = 2\nextends = "football"\ntitle = "Mine"\n')
    study = grid_in(
        tmp_path,
        'out = "o"\n'
        'timelines = ["data/*.json", {file = "data/a.json", window = [4, "6"]}]\n'
        'presets = ["mine.toml", "football"]\n'
        'gestures = ["take.csv", "tap:0.5:0.1+take.csv"]\n',
    )
    assert study.out == str(tmp_path / "o")
    assert list(study.timelines) == ["data/a.json", "data/b.json", "data/a.json (window=4 to 6)"]
    assert study.timelines["data/a.json (window=4 to 6)"].duration_s == 2.0
    assert study.presets["mine.toml"].title == "Mine"
    assert study.gestures["tap:0.5:0.1+take.csv"].duration_s == pytest.approx(0.3)
    assert study.seeds == (0,)


def test_ranges_keep_their_ends_and_are_even_or_even_in_ratio(tmp_path):
    study = grid_in(
        tmp_path,
        REST
        + '[parameters]\n"tactor.gain_db" = {from = -12, to = 0, steps = 4}\n'
        + 'kinds.goal.height = {from = 0.3, to = 30.0, steps = 3, scale = "log"}\n',
    )
    assert study.parameters["tactor.gain_db"] == (-12.0, -8.0, -4.0, 0.0)
    low, middle, high = study.parameters["kinds.goal.height"]
    assert (low, high) == (0.3, 30.0)
    assert middle == pytest.approx(3.0)
    assert list(study.presets) == ["football"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["out"]),
        ("out = 1", ["jobs.toml:1:", "out"]),
        ("not toml", ["not TOML"]),
        (REST + "seed = 3", ["jobs.toml:4:", "seed", "seeds"]),
        (REST + "seeds = 0", ["jobs.toml:4:", "seeds"]),
        (REST + "seeds = [1, 1]", ["twice"]),
        (REST + "seeds = [1.5]", ["seeds"]),
        (REST + "sample_rate = 'x'", ["sample_rate"]),
        (REST + "sample_rate = 44100.5", ["44100.5"]),
        (REST + "tail = 'never'", ["tail", "never"]),
        (REST + "tail = -1", ["tail"]),
        (REST + "tail = true", ["tail"]),
        (REST + "format = 'mp9'", ["mp9"]),
        (REST + "format = '../x'", ["format"]),
        (REST + "subtype = 'PCM_12'", ["PCM_12"]),
        (REST + "presets = []", ["presets"]),
        (REST + "presets = ['fotball']", ["presets", "football"]),
        (REST + "presets = ['football', 'football']", ["twice"]),
        (REST + "parameters = 3", ["parameters"]),
        (REST + '[parameters]\n"tactor.gain" = [1]', ["jobs.toml:4:", "tactor.gain"]),
        (REST + '[parameters]\n"tactor.gain_db" = [1e9]', ["tactor.gain_db", "range"]),
        (REST + '[parameters]\n"tactor.gain_db" = []', ["tactor.gain_db"]),
        (REST + '[parameters]\n"tactor.gain_db" = [0, 0.0]', ["twice"]),
        (REST + '[parameters]\n"tactor.gain_db" = {from = 1}', ["from", "steps"]),
        (REST + '[parameters]\n"tactor.gain_db" = {from = -1, to = 1, steps = 1}', ["steps"]),
        (
            REST + '[parameters]\n"tactor.gain_db" = {from = -1, to = 1, steps = 3, scale = "log"}',
            ["log"],
        ),
        (REST + '[parameters]\nkinds.gaol.height = [1]', ["kinds.gaol.height"]),
        (REST.replace('"tap:1"', '"tap"'), ["jobs.toml:3:", "gestures", "tap"]),
        (REST.replace('"tap:1"', '"no.csv"'), ["gestures", "no.csv"]),
        (REST.replace('"world-cup-final-2018"', '"no.json"'), ["jobs.toml:2:", "no.json"]),
        (REST.replace('"world-cup-final-2018"', '"no*.json"'), ["no*.json"]),
        (REST.replace('"world-cup-final-2018"', "{}"), ["file"]),
        (
            REST.replace('"world-cup-final-2018"', '{file = "world-cup-final-2018", windw = 1}'),
            ["windw"],
        ),
        (
            REST.replace('"world-cup-final-2018"', '{file = "world-cup-final-2018", window = 1}'),
            ["window"],
        ),
        (
            REST.replace(
                '"world-cup-final-2018"',
                '{file = "world-cup-final-2018", zoom_to = "goal:1", window = [1, 2]}',
            ),
            ["both"],
        ),
        (REST + "seeds = 99999\n" + '[parameters]\n"tactor.gain_db" = '
         "{from = -12, to = 0, steps = 5000}", ["499,995,000", "100,000,000"]),
    ],
)  # fmt: skip
def test_an_invalid_jobs_file_is_an_error_of_one_line_that_names_the_file(tmp_path, text, words):
    with pytest.raises(ov.InputError) as error:
        grid_in(tmp_path, text)
    line = str(error.value)
    assert "jobs.toml" in line
    for word in words:
        assert word in line, line
    assert "\n" not in line


def test_a_file_that_is_not_there_is_an_error_of_one_line(tmp_path):
    with pytest.raises(ov.InputError, match="no such"):
        load_jobs(tmp_path / "no such")


@given(data=st.data())
def test_a_broken_jobs_file_is_a_study_or_one_line(data, tmp_path_factory):
    text = list(JOBS)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at] = data.draw(st.characters(codec="utf-8"))
    folder = tmp_path_factory.mktemp("broken")
    # any other error fails the test
    with contextlib.suppress(ov.InputError):
        assert len(grid_in(folder, "".join(text))) >= 1
