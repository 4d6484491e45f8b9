from __future__ import annotations

import itertools

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.devices.sensors.profile import (
    LIBRARY,
    SENSOR_PARAMETERS,
    Sensor,
    load_sensor,
    parse_sensor,
)
from overview_dsp.devices.sensors.units import units_of

HEAD = "schema = 3\n"


def test_every_bundled_sensor_is_read():
    assert LIBRARY.bundled == (
        "dualsense", "encoder", "imu", "joycon", "joycon-right", "phone", "potentiometer", "roll",
        "simplefoc",
    )  # fmt: skip
    for name in LIBRARY.bundled:
        assert load_sensor(name).title


def test_the_bundled_imu_says_the_defaults():
    assert load_sensor("imu").values == Sensor().values


def test_files_of_earlier_schemas_give_the_same_sensor():
    new = """schema = 3
[stream]
format = "auto"
columns = ["motor_target", "shaft_rad"]
[acceleration]
unit = "auto"
[angles]
twist = "auto"
[motor]
protocol = "simplefoc"
nm_per_unit = 0.003
command_letter = "B"
knock = 1.0
home = 0.5
"""
    second = new.replace("schema = 3", "schema = 2")
    second = second.replace("knock =", "impact_gain =").replace("home =", "recoil_gain =")
    first = new.replace("schema = 3", "schema = 1").replace("auto", "told")
    first = first.replace("command_letter", "letter")
    sensor = parse_sensor(new, "mine", "mine.toml")
    for old in (first, second):
        assert parse_sensor(old, "mine", "mine.toml") == sensor
    with pytest.raises(ov.InputError, match=r"mine\.toml:13: motor\.knock = 9"):
        parse_sensor(first.replace("knock = 1.0", "knock = 9"), "mine", "mine.toml")
    for text, key in ((second, "impact_gain"), (first, "letter")):
        with pytest.raises(ov.InputError, match=rf"motor\.{key}: unknown key"):
            parse_sensor(text.replace(text[:10], new[:10]), "mine", "mine.toml")


def test_a_file_says_units_axes_and_columns():
    text = HEAD + '[stream]\ncolumns = ["t_ms", "ax", "ay", "az"]\n[axes]\nx = "-y"\ny = "x"\n'
    sensor = parse_sensor(text, "mine", "mine.toml")
    assert sensor.columns == ("t_ms", "ax", "ay", "az")
    assert sensor.axes == ((1, -1.0), (0, 1.0), (2, 1.0))


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("x = 1\n", 1, "unknown key"),
        (HEAD + "[axes]\nx = 'w'\n", 3, "x"),
        (HEAD + "[axes]\nx = '-x'\n", None, "right-handed"),
        (HEAD + "[axes]\nx = 'y'\n", None, "right-handed"),
        (HEAD + "[stream]\nbaud = 1\n", 3, "300 to"),
        (HEAD + "[stream]\ncolumns = ['az', 'aq']\n", 3, "known:"),
        (HEAD + "[stream]\ncolumns = ['ax', 'ax']\n", 3, "twice"),
        (HEAD + "[stream]\ncolumns = 'ax'\n", 3, "a list"),
        (HEAD + "[stream]\ncolumns = []\n", 3, "a list"),
        (HEAD + "[stream]\nformat = 'text'\n", 2, "columns is missing"),
        (HEAD + "[stream]\nformat = 'json'\ncolumns = ['ax']\n", 4, "text"),
        (HEAD + "[acceleration]\nscale = 0\n", 3, "any other"),
        (HEAD + "[potentiometer]\nlow = 1023\n", 3, "two ends"),
        (HEAD + "stream = 3\n", 2, "a table"),
        (HEAD + "[roll]\n", 2, "unknown key"),
        (HEAD + "[encoder]\ncount = 3\n", 3, "counts"),
        ("schema = 4\n", 1, "must be 3"),
        ("title = 3\nschema = 3\n", 1, "must be text"),
        ("", None, "schema is missing"),
        ("=", None, "not TOML"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line_with_its_place(text, line, said):
    with pytest.raises(ov.InputError) as caught:
        parse_sensor(text, "mine", "mine.toml")
    message = str(caught.value)
    assert message.startswith("mine.toml:")
    assert said in message
    assert line is None or message.startswith(f"mine.toml:{line}:")
    assert "\n" not in message


@pytest.mark.parametrize("name", ["potentiometr", "no/such.toml", "nothing"])
def test_a_sensor_that_is_not_there_names_what_is(name):
    with pytest.raises(ov.InputError) as caught:
        load_sensor(name)
    assert name in str(caught.value)


def test_every_parameter_has_a_sentence_and_an_allowed_default():
    for known in SENSOR_PARAMETERS.values():
        assert known.doc.endswith(".")
        assert known.check(known.default) == known.default


def test_every_rotation_of_the_axes_is_allowed_and_no_mirror():
    """Face up, however the sensor is mounted: the device's z is where it says."""
    names = ("x", "y", "z", "-x", "-y", "-z")
    raw = {name: np.eye(3)["xyz".index(name[-1])] * (-1 if "-" in name else 1) for name in names}
    allowed = 0
    for x, y, z in itertools.product(names, repeat=3):
        values = {"axes.x": x, "axes.y": y, "axes.z": z}
        if not np.array_equal(np.cross(raw[x], raw[y]), raw[z]):
            with pytest.raises(ov.InputError, match="right-handed"):
                Sensor(values=values)
            continue
        allowed += 1
        sensor = Sensor(values={**values, "acceleration.unit": "m/s²"})
        units = units_of(sensor, False, [[0.0, 0.0, 9.8]])
        for axis, device in ((x, (1, 0, 0)), (y, (0, 1, 0)), (z, (0, 0, 1))):
            assert units.acceleration_of(list(raw[axis])) == pytest.approx(device)
            assert units.angular_velocity_of(list(raw[axis])) == pytest.approx(device)
    assert allowed == 24
