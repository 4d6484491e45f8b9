from __future__ import annotations

import pytest

from overview_dsp.devices.sensors.decoders import ENOUGH, DetectedFormat, detect
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import ACCELERATION, ANGULAR_VELOCITY, Counters
from overview_dsp.devices.sensors.stream import Stream
from tests.devices.sensors.streams import frame_stream


def lines(line: str, count: int = 8, before: str = "") -> bytes:
    return (before + "\n" + f"{line}\r\n" * count).encode()


@pytest.mark.parametrize(
    ("data", "detected"),
    [
        (b"".join(frame_stream(3)), DetectedFormat("frames")),
        (b"\n\n,1" + b"".join(frame_stream(4))[7:], DetectedFormat("frames")),
        (lines('{"ax": 1, "ay": 2, "az": 3}'), DetectedFormat("json")),
        (lines("0.1,0.2,9.8"), DetectedFormat("text", ACCELERATION)),
        (lines("0.1 0.2 9.8 1 2 3"), DetectedFormat("text", ACCELERATION + ANGULAR_VELOCITY)),
        (lines("12.5"), DetectedFormat("text", ("roll_deg",))),
        (
            lines("1,2,3,4", before="\nt_us,ax,ay,az"),
            DetectedFormat("text", ("t_us", *ACCELERATION)),
        ),
        (
            b"ets Jun 8 2016\nboot: ok\n" + lines("1,2,9.5"),
            DetectedFormat("text", ACCELERATION),
        ),
    ],
)
def test_a_stream_is_detected_from_its_content(data, detected):
    assert detect(data) == detected
    counters = Counters()
    assert detected.decoder(counters).feed(data)
    assert str(detected)


@pytest.mark.parametrize("count", range(1, 12))
def test_json_is_never_taken_for_labelled_lines(count):
    found = detect(lines('{"ax": 1, "ay": 2, "az": 3}', count))
    assert found == (DetectedFormat("json") if count >= 5 else None)


@pytest.mark.parametrize("line", ["512", "0", "-3", "300.5", "1,2", "1,2,3,4", "1,2,3,4,5,6,7"])
def test_an_ambiguous_stream_is_an_error_of_one_line_that_asks_for_a_profile(line):
    said = detect(lines(line))
    assert isinstance(said, str)
    assert "sensor=" in said
    assert line in said
    assert "\n" not in said


@pytest.mark.parametrize("data", [b"", b"1,2,3\n1,2,3\n", lines("0.1,0.2", 3), frame_stream(1)[0]])
def test_too_few_bytes_are_not_detected_yet(data):
    assert detect(data) is None


def test_noise_is_reported_with_a_remedy():
    said = detect(b"\xf3\x00\x81\xff" * (ENOUGH // 4))
    assert isinstance(said, str)
    assert "baud=" in said


def numbered(*numbers: int) -> tuple[list[int], Counters]:
    counters = Counters()
    stream = Stream(Sensor(values={"stream.format": "json"}), counters)
    sent = "".join(f'\n{{"sequence": {number}, "roll_deg": 1.0}}' for number in numbers)
    samples = stream.feed(f"{sent}\n".encode(), 0.0)
    return [int(reading["sequence"]) for _, reading in samples], counters


def test_missing_samples_are_counted_over_the_wrap_and_repeated_ones_dropped():
    passed, counters = numbered(65533, 65534, 65534, 2, 3, 3)
    assert passed == [65533, 65534, 2, 3]
    assert (counters.lost, counters.repeated) == (3, 2)


def test_a_restarted_device_has_no_lost_samples():
    assert numbered(40_000, 0, 1)[1].lost in (25_535, 0)
    assert numbered(1000, 0, 1)[1].lost == 0
