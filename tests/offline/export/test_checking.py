"""The project's own checker: its exports are right, and every kind of damage is found."""

from __future__ import annotations

import copy
import json

import pytest

import overview_dsp as ov
from overview_dsp.offline.export.writing import export
from tests.cli.running import overview


@pytest.fixture(scope="module")
def written(match, football, tmp_path_factory):
    folder = tmp_path_factory.mktemp("clips")
    result = ov.render(match, football, ov.sweep(1.0))
    files = [
        path
        for to in ("ahap", "haptic", "hjif", "android")
        for path in export(result, to, folder / f"clip.{'json' if to == 'android' else to}").files
    ]
    return {path.name.partition(".")[2]: path for path in files}


@pytest.fixture(scope="module")
def documents(written):
    return {name: json.loads(path.read_text()) for name, path in written.items() if name != "xml"}


@pytest.mark.parametrize("name", ["ahap", "strikes.ahap", "haptic", "hjif", "json", "xml"])
def test_what_is_exported_has_no_fault(written, name):
    assert ov.export.check_clip(written[name]) == []


def curve(d):
    return next(e["ParameterCurve"] for e in d["Pattern"] if "ParameterCurve" in e)


def event(d):
    return next(e["Event"] for e in d["Pattern"] if "Event" in e)


def points(d):
    return d["signals"]["continuous"]["envelopes"]["amplitude"]


def pitches(d):
    return d["signals"]["continuous"]["envelopes"]["frequency"]


def emphasised(d):
    return next(point for point in points(d) if "emphasis" in point)


def perception(d):
    return d["perceptions"][0]


def band(d, channel=0):
    return perception(d)["channels"][channel]["bands"][0]


def frames(d):
    return band(d)["effects"][0]["keyframes"]


def friction(d):
    return d["perceptions"][1]["channels"][0]["bands"][0]["effects"][0]


def counted_from_the_clip(curve, start):
    curve["Time"] = start
    for point in curve["ParameterCurveControlPoints"]:
        point["Time"] += start


def swap(found, key):
    found[3][key], found[4][key] = found[4][key], found[3][key]


DAMAGE = {
    "ahap: no version": ("ahap", lambda d: d.pop("Version")),
    "ahap: another version": ("ahap", lambda d: d.update(Version=2.0)),
    "ahap: nothing in it": ("ahap", lambda d: d.update(Pattern=[])),
    "ahap: an unknown event": ("ahap", lambda d: event(d).update(EventType="HapticBuzz")),
    "ahap: a negative time": ("ahap", lambda d: event(d).update(Time=-0.1)),
    "ahap: a time that is a text": ("ahap", lambda d: event(d).update(Time="0")),
    "ahap: longer than 30 s": ("ahap", lambda d: event(d).update(EventDuration=30.5)),
    "ahap: no duration": ("ahap", lambda d: event(d).pop("EventDuration")),
    "ahap: intensity above 1": (
        "strikes.ahap",
        lambda d: event(d)["EventParameters"][0].update(ParameterValue=1.2),
    ),
    "ahap: an unknown parameter": (
        "strikes.ahap",
        lambda d: event(d)["EventParameters"][0].update(ParameterID="Intensity"),
    ),
    "ahap: no parameters": ("strikes.ahap", lambda d: event(d).pop("EventParameters")),
    "ahap: a curve of nothing": ("ahap", lambda d: curve(d).update(ParameterCurveControlPoints=[])),
    "ahap: a curve of another kind": (
        "ahap",
        lambda d: curve(d).update(ParameterID="HapticIntensity"),
    ),
    "ahap: control below 0": (
        "ahap",
        lambda d: curve(d)["ParameterCurveControlPoints"][2].update(ParameterValue=-0.1),
    ),
    "ahap: points in the wrong order": (
        "ahap",
        lambda d: swap(curve(d)["ParameterCurveControlPoints"], "Time"),
    ),
    "ahap: a curve after the clip": ("ahap", lambda d: curve(d).update(Time=50.0)),
    "ahap: times counted from the clip": ("ahap", lambda d: counted_from_the_clip(curve(d), 0.3)),
    "haptic: another version": ("haptic", lambda d: d["version"].update(major=2)),
    "haptic: no metadata": ("haptic", lambda d: d.pop("metadata")),
    "haptic: one point": ("haptic", lambda d: points(d).__delitem__(slice(1, None))),
    "haptic: begins late": ("haptic", lambda d: points(d)[0].update(time=0.0005)),
    "haptic: a time goes back": ("haptic", lambda d: swap(points(d), "time")),
    "haptic: amplitude above 1": ("haptic", lambda d: points(d)[5].update(amplitude=1.01)),
    "haptic: an emphasis below the envelope": (
        "haptic",
        lambda d: emphasised(d).update(amplitude=0.9),
    ),
    "haptic: an emphasis without a pitch": (
        "haptic",
        lambda d: emphasised(d)["emphasis"].pop("frequency"),
    ),
    "haptic: a pitch after the end": ("haptic", lambda d: pitches(d)[-1].update(time=60.0)),
    "haptic: a misspelt key": ("haptic", lambda d: points(d)[3].update(emphasys={})),
    "haptic: not a number": ("haptic", lambda d: points(d)[3].update(amplitude=float("nan"))),
    "hjif: an old version": ("hjif", lambda d: d.update(version="2022")),
    "hjif: no date": ("hjif", lambda d: d.update(date="yesterday")),
    "hjif: another timescale": ("hjif", lambda d: d.update(timescale=48000)),
    "hjif: no syncs": ("hjif", lambda d: d.pop("syncs")),
    "hjif: an unknown profile": ("hjif", lambda d: d.update(profile="Baseline")),
    "hjif: an unknown modality": (
        "hjif",
        lambda d: perception(d).update(perception_modality="Buzz"),
    ),
    "hjif: an id twice": ("hjif", lambda d: d["perceptions"][1].update(id=0)),
    "hjif: no gain": ("hjif", lambda d: perception(d)["channels"][0].pop("gain")),
    "hjif: a device that isn't there": (
        "hjif",
        lambda d: perception(d)["channels"][0].update(reference_device_id=7),
    ),
    "hjif: resonance above the highest": (
        "hjif",
        lambda d: perception(d)["reference_devices"][0].update(resonance_frequency=900.0),
    ),
    "hjif: limits the wrong way": ("hjif", lambda d: band(d).update(upper_frequency_limit=10)),
    "hjif: an unknown band": ("hjif", lambda d: band(d).update(band_type="Wave")),
    "hjif: a broken count": ("hjif", lambda d: frames(d)[2].update(relative_position=10.5)),
    "hjif: keyframes go back": ("hjif", lambda d: swap(frames(d), "relative_position")),
    "hjif: a loud keyframe": ("hjif", lambda d: frames(d)[2].update(amplitude_modulation=1.5)),
    "hjif: a wave without a pitch": ("hjif", lambda d: frames(d)[2].pop("frequency_modulation")),
    "hjif: a silent curve": (
        "hjif",
        lambda d: friction(d)["keyframes"].__delitem__(slice(2, None)),
    ),
    "hjif: a late curve": ("hjif", lambda d: friction(d).update(position=5)),
    "android: a time is missing": ("json", lambda d: d["waveform"]["timings"].pop()),
    "android: silence in the clip": (
        "json",
        lambda d: d["waveform"]["amplitudes"].__setitem__(3, 0),
    ),
    "android: above 255": ("json", lambda d: d["waveform"]["amplitudes"].__setitem__(3, 256)),
    "android: it repeats": ("json", lambda d: d["waveform"].update(repeat=0)),
    "android: a point too short": (
        "json",
        lambda d: d["envelopeEffects"][0]["controlPoints"][0].update(durationMs=10),
    ),
    "android: too many points": (
        "json",
        lambda d: d["envelopeEffects"][0].update(
            controlPoints=d["envelopeEffects"][0]["controlPoints"] * 9
        ),
    ),
    "android: effects overlap": ("json", lambda d: d["envelopeEffects"][1].update(startMs=5)),
    "android: no pitch": (
        "json",
        lambda d: d["envelopeEffects"][0]["controlPoints"][0].update(frequencyHz=0),
    ),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_every_type_of_damage_is_reported_in_one_line(documents, tmp_path, name):
    assert len(DAMAGE) >= 31
    suffix, damage = DAMAGE[name]
    document = copy.deepcopy(documents[suffix])
    damage(document)
    path = tmp_path / "clip.json"
    path.write_text(json.dumps(document))
    faults = ov.export.check_clip(path)
    assert faults
    assert not any("\n" in fault for fault in faults)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ('amplitude="', 'amplitude="9'),
        ('durationMs="', 'durationMs="-'),
        ("waveform-entry", "entry"),
        ("vibration-effect", "vibration"),
        ("</vibration-effect>", ""),
        ("<vibration-effect>", '<!DOCTYPE x [<!ENTITY a "b">]><vibration-effect>'),
    ],
)
def test_damaged_android_xml_is_reported(written, tmp_path, before, after):
    path = tmp_path / "clip.xml"
    path.write_text(written["xml"].read_text().replace(before, after))
    assert ov.export.check_clip(path)


def test_a_file_that_is_no_clip_is_reported(tmp_path):
    path = tmp_path / "clip.json"
    path.write_text('{"a": 1}')
    assert "must be AHAP" in ov.export.check_clip(path)[0]
    path.write_text("{")
    assert "not JSON" in ov.export.check_clip(path)[0]


def test_the_command_checks_and_writes_nothing(written, documents, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = overview("presets", "import", str(written["ahap"]), "--check")
    assert (done.code, done.out.split(": ")[-1].strip()) == (0, "valid")
    document = copy.deepcopy(documents["haptic"])
    points(document)[5]["amplitude"] = 7
    (tmp_path / "bad.haptic").write_text(json.dumps(document))
    done = overview("presets", "import", "bad.haptic", "--check")
    assert done.code == 2
    assert "amplitude[5].amplitude = 7 is out of range; must be 0 to 1" in done.errors[0]
    assert [path.name for path in tmp_path.iterdir()] == ["bad.haptic"]


def haptic_clip(**more):
    return {
        "version": {"major": 1, "minor": 0, "patch": 0},
        "metadata": {"editor": "Haptics Studio", "author": "", "tags": ["hit"], "project": ""},
        "signals": {
            "continuous": {
                "envelopes": {
                    "amplitude": [{"time": 0.0, "amplitude": 0.2}, {"time": 0.4, "amplitude": 0.1}],
                    "frequency": [],
                    **more,
                }
            }
        },
    }


def parameters(intensity, sharpness):
    ids = (("HapticIntensity", intensity), ("HapticSharpness", sharpness))
    return [{"ParameterID": id_, "ParameterValue": value} for id_, value in ids]


def control(start, *points, id_="HapticIntensityControl"):
    frames = [{"Time": time, "ParameterValue": value} for time, value in points]
    curve = {"ParameterID": id_, "Time": start, "ParameterCurveControlPoints": frames}
    return {"ParameterCurve": curve}


def transient(time, sharpness=0.1):
    event = {"Time": time, "EventType": "HapticTransient"}
    return {"Event": event | {"EventParameters": parameters(1.0, sharpness)}}


def vibration(time, duration):
    event = {"Time": time, "EventType": "HapticContinuous", "EventDuration": duration}
    return {"Event": event | {"EventParameters": parameters(0.6, 0.4)}}


FOREIGN = {
    "a rumble of transients under a curve that ends after them": {
        "Version": 1.0,
        "Metadata": {"Project": "Sampler", "Created": "5 June 2019", "Description": "Rumble."},
        "Pattern": [
            *(transient(0.04 * n) for n in range(39)),
            control(0, (0, 0.3), (0.1, 1.0), (1.0, 1.0), (1.6, 0.0)),
        ],
    },
    "vibrations that overlap, each with its curve": {
        "Version": 1,
        "Pattern": [
            vibration(0.0, 0.5),
            vibration(0.25, 0.5),
            control(0.0, (0, 0.0), (0.5, 1.0)),
            control(0.25, (0, 1.0), (0.6, 0.0)),
            control(0.1, (0, -0.5), (0.8, 0.5), id_="HapticSharpnessControl"),
        ],
    },
    "a pitch that begins after the start": haptic_clip(
        frequency=[{"time": 0.01, "frequency": 0.4}, {"time": 0.4, "frequency": 0.5}]
    ),
    "an envelope without a pitch": haptic_clip(),
}


@pytest.mark.parametrize("document", FOREIGN.values(), ids=FOREIGN.keys())
def test_a_valid_clip_of_others_has_no_fault_and_can_be_imported(tmp_path, document):
    path = tmp_path / ("clip.haptic" if "signals" in document else "clip.ahap")
    path.write_text(json.dumps(document))
    assert ov.export.check_clip(path) == []
    clip = ov.export.read_clip(path)
    assert clip.level.max() > 0.0 or clip.transients


@pytest.mark.parametrize("number", ["9" * 400, "-" + "9" * 400, "1e400", "0." + "9" * 400])
@pytest.mark.parametrize("suffix", ["ahap", "haptic", "hjif", "json"])
def test_a_number_of_400_digits_is_one_line(tmp_path, documents, suffix, number):
    text = json.dumps(documents[suffix])
    first = next(
        part
        for part in text.replace("}", ",").replace("]", ",").split(": ")[1:]
        if part[0].isdigit()
    )
    path = tmp_path / f"clip.{suffix}"
    path.write_text(text.replace(f": {first.split(',')[0]}", f": {number}", 1))
    for call in (ov.export.check_clip, ov.export.read_clip):
        try:
            found = call(path)
        except ov.InputError as error:
            found = [str(error)]
        for line in found if isinstance(found, list) else ():
            assert "\n" not in line
            assert len(line) < 400
