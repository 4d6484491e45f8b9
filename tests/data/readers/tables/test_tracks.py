"""GPX and TCX tracks as series."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.tables.tracks import EARTH_M
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.errors import InputError
from tests.data.readers.outcome import timeline_or_one_line

DEGREES = 10.0 / EARTH_M * 180.0 / math.pi
"""Of latitude: 10 m."""


def gpx(points: int = 60, step: float = DEGREES, time: bool = True) -> str:
    body = "".join(
        f'<trkpt lat="{47 + i * step:.9f}" lon="8.5"><ele>{400 + i}</ele>'
        + (f"<time>2024-05-01T10:00:{i:02}Z</time>" if time else "")
        + "<extensions><gpxtpx:TrackPointExtension><gpxtpx:hr>"
        + f"{120 + i % 5}</gpxtpx:hr></gpxtpx:TrackPointExtension></extensions></trkpt>\n"
        for i in range(points)
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<gpx version="1.1" creator="a test" '
        'xmlns="http://www.topografix.com/GPX/1/1" xmlns:gpxtpx="http://x">'
        f"<metadata><time>2020-01-01T00:00:00Z</time></metadata><trk><trkseg>{body}"
        "</trkseg></trk></gpx>"
    )


def tcx() -> str:
    body = "".join(
        f"<Trackpoint><Time>2024-05-01T12:00:{i:02}+02:00</Time><Position><LatitudeDegrees>47"
        "</LatitudeDegrees><LongitudeDegrees>8</LongitudeDegrees></Position>"
        f"<DistanceMeters>{5 * i}</DistanceMeters><HeartRateBpm><Value>{120 + i % 5}</Value>"
        "</HeartRateBpm></Trackpoint>"
        for i in range(60)
    )
    return (
        '<TrainingCenterDatabase xmlns="http://g"><Activities><Activity><Lap>'
        "<MaximumHeartRateBpm><Value>199</Value></MaximumHeartRateBpm>"
        f"<Track>{body}</Track></Lap></Activity></Activities></TrainingCenterDatabase>"
    )


def write(folder: Path, text: str, name: str = "track.gpx", encoding: str = "utf-8") -> Path:
    (folder / name).write_text(text, encoding=encoding)
    return folder / name


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_gpx_is_its_speed(encoding: str, tmp_path: Path) -> None:
    timeline = load_timeline(write(tmp_path, gpx(), encoding=encoding))
    assert timeline.title == "track: speed"
    assert timeline.start is not None
    assert timeline.start.isoformat() == "2024-05-01T10:00:00+00:00"
    assert timeline.duration_s == 59.0
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "km/h"
    assert np.allclose(timeline.intensity.value, 36.0, atol=0.01)  # 10 m a second


def test_a_steady_pace_has_no_turning_points(tmp_path: Path) -> None:
    timeline = load_timeline(write(tmp_path, gpx(step=1e-4)))
    assert set(timeline.kinds()) <= set(TICKS)


def test_a_track_also_has_elevation_and_heart_rate_as_values(tmp_path: Path) -> None:
    path = write(tmp_path, gpx())
    for value, unit, first in (("elevation", "m", 400.0), ("heart_rate", "bpm", 120.0)):
        curve = load_timeline(path, value=value).intensity
        assert curve is not None
        assert (curve.unit, float(curve.value[0])) == (unit, first)
    with pytest.raises(InputError, match=r"columns are 'time', 'speed \(km/h\)', 'elevation"):
        load_timeline(path, value="cadence")


def test_a_tcx_has_its_own_distance_and_heart_rate(tmp_path: Path) -> None:
    path = write(tmp_path, tcx(), "run.tcx")
    timeline = load_timeline(path)
    assert timeline.start is not None
    assert timeline.start.isoformat() == "2024-05-01T10:00:00+00:00"
    assert timeline.intensity is not None
    assert np.allclose(timeline.intensity.value, 18.0)  # 5 m a second
    curve = load_timeline(path, value="heart_rate").intensity
    assert curve is not None
    assert float(np.max(curve.value)) == 124.0


def test_points_of_a_track_are_counted_too(tmp_path: Path) -> None:
    timeline = load_timeline(write(tmp_path, gpx()), map="count:30s")
    assert timeline.intensity is not None
    assert list(timeline.intensity.value[1:-1]) == [30.0, 30.0]


BOMB = '<!DOCTYPE gpx [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_a_document_type_is_refused(encoding: str, tmp_path: Path) -> None:
    text = gpx().replace("?>\n", f"?>\n{BOMB}\n", 1)
    with pytest.raises(InputError, match=r"^[^ ]*track.gpx: the XML has a document type"):
        load_timeline(write(tmp_path, text, encoding=encoding))


def test_the_encoding_the_xml_claims_hides_nothing(tmp_path: Path) -> None:
    hidden = BOMB.replace("<!", "+ADwAIQ-")  # what UTF-7 would read as <!
    text = gpx().replace('encoding="UTF-8"?>', f'encoding="UTF-7"?>{hidden}', 1)
    with pytest.raises(InputError, match="broken XML"):
        load_timeline(write(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (gpx(time=False), "0 points of its tracks have a time; .* not a planned route"),
        (gpx(1), "1 points of its tracks have a time"),
        (gpx()[:-200], "broken XML"),
        ("<gpx>" + "<a>" * 100, "nested more than 64 levels deep"),
        (gpx().replace("<ele>", "<x>"), "broken XML"),
    ],
)
def test_data_that_are_not_a_track_give_a_one_line_error(
    text: str, words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        load_timeline(write(tmp_path, text))


def test_many_tags_in_a_point_take_no_memory(tmp_path: Path) -> None:
    import tracemalloc

    text = gpx(2).replace("<ele>", "<a/>" * 500_000 + "<ele>")
    path = write(tmp_path, text)
    tracemalloc.start()
    try:
        load_timeline(path)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 6 * len(text)  # a tree of these tags takes 30 times their text


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.data())
def test_any_damage_ends_in_a_timeline_or_a_one_line_error(
    tmp_path: Path, data: st.DataObject
) -> None:
    text = data.draw(st.sampled_from([gpx(), tcx()]))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        put = data.draw(
            st.sampled_from(["", "<", ">", '"', "&", "\0", "1e999", "-", "</trkpt>", "NaN", "9999"])
            | st.text(max_size=3)
        )
        text = text[:at] + put + text[at + data.draw(st.integers(0, 60)) :]
    path = tmp_path / "damaged.gpx"
    path.write_text(text, encoding="utf-8", errors="replace")
    timeline_or_one_line(lambda: load_timeline(path))
