"""A plugin is built by a command or a call, and what can't be built is one line."""

from __future__ import annotations

import plistlib
import re
import warnings
from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.offline.export.plugin_bundle import bundle_of, host_id, parameter_ids
from overview_dsp.offline.export.plugins import Machine, contents_of, machine_of
from tests.cli.running import MATCH, overview
from tests.offline.export.plugin_playing import (
    EARLIER,
    VALUE,
    Host,
    built_host,
    library_of,
    natively,
    number_of,
    score,
)

pytestmark = pytest.mark.usefixtures("unoptimised", "without_tails")


def test_the_command_builds_one_of_several_timelines(tmp_path):
    timelines = (MATCH, "made-up-share")
    given = ("--preset", "gravel", "--to", "vst3", "-o", tmp_path, "--name", "Two")
    done = overview("plugin", "build", *timelines, *given)
    assert done.code == 0, done.err
    assert done.out.startswith(f"{tmp_path / 'two'}.vst3: {', '.join(timelines)} in gravel;")
    library = library_of(tmp_path / "two.vst3")
    host = Host("vst3", built_host("vst3", tmp_path), library)
    listed = host.run("list")
    assert listed.startswith("Instrument|Synth\tTwo\n")
    row = next(line.split("\t") for line in listed.splitlines() if "\tTimeline\t" in line)
    assert (row[4], row[-1].strip()) == ("1", MATCH)


def test_a_note_comes_once_with_the_timelines_and_the_preset_it_is_of(match, football):
    halves = {"first": match.window(0, 2700), "second": match.window(2700, 5600)}
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        bundle_of("both", halves, [football, ov.load_preset("stocks")], 0)
    said = [str(note.message) for note in notes]
    assert all(note.category is ov.OverviewWarning for note in notes)
    assert len(said) == len(set(said)) > 0
    assert all(
        re.match("(first|second|first, second) in stocks: preset 'stocks'", it) for it in said
    )
    # the same of both is one
    again = {"first": halves["first"], "once more": halves["first"]}
    with pytest.warns(ov.OverviewWarning, match="^first, once more in stocks: ") as one:
        bundle_of("both", again, [ov.load_preset("stocks")], 0)
    assert len(one) == 1


def test_a_bundle_of_macos_names_its_library_whatever_the_plugin_is_called(match, football):
    bundle = bundle_of("Tom & <Jerry>", {"m": match}, [football], 0)
    files = contents_of("vst3", bundle, machine_of("aarch64-macos"), b"library")
    described = plistlib.loads(files["tom-jerry.vst3/Contents/Info.plist"])
    assert described["CFBundleName"] == "Tom & <Jerry>"
    assert described["CFBundleIdentifier"] == bundle.id
    assert f"tom-jerry.vst3/Contents/MacOS/{described['CFBundleExecutable']}" in files
    odd = replace(bundle, name="Tom\x00 \x1b&\n\x7f J\u00e9rry")
    files = contents_of("clap", odd, machine_of("x86_64-macos"), b"library")
    described = plistlib.loads(files[f"{odd.slug}.clap/Contents/Info.plist"])
    assert described["CFBundleName"] == "Tom   &   J\u00e9rry"


def test_a_vst3_folder_names_processors_as_hosts_look_for_them(match, football):
    bundle = bundle_of("film", {"m": match}, [football], 0)
    folders = {("x86_64", "linux"): "x86_64-linux", ("aarch64", "linux"): "aarch64-linux"}
    folders |= {("x86_64", "windows"): "x86_64-win", ("aarch64", "windows"): "arm64-win"}
    for named, folder in folders.items():
        (path,) = contents_of("vst3", bundle, Machine(*named), b"library")
        assert path.startswith(f"film.vst3/Contents/{folder}/film.")


def test_hosts_keep_the_first_id_of_a_parameter_that_was_renamed():
    kept = [host_id(id) for id in parameter_ids()]
    assert len(set(kept)) == len(kept)
    assert {"tactor.full_torque_mnm", "click.full_torque_mnm", "tactor.gain_db"} <= set(kept)


def test_a_name_of_any_letters_is_a_file_of_its_own(match, football):
    def slug(name):
        return bundle_of(name, {"match": match}, [football], 0).slug

    assert slug("Zürich & Genève") == "zurich-geneve"
    assert slug("決勝") != slug("準決勝")
    assert slug("決勝").startswith("timeline-")


def test_plugins_of_different_names_have_different_ids(match, football):
    bundle = bundle_of("match", {"match": match}, [football], 0)
    others = [replace(bundle, name=name) for name in ("Match", "Match!", "m\u00e4tch", "match-")]
    assert {other.slug for other in others} == {bundle.slug} == {"match"}
    assert len({one.id for one in (bundle, *others)}) == 5
    assert len({one.uri(0) for one in (bundle, *others)}) == 5
    # a name that is its own file name has the id of earlier versions
    assert bundle.id == "org.overview-dsp.match"
    assert bundle.uri(0) == "urn:overview-dsp:match:football"
    assert others[0].id == "org.overview-dsp.match.03c0e806"


@pytest.mark.soak
def test_without_a_timeline_it_is_all_that_is_bundled(tmp_path):
    given = ("--to", "clap", "--seed", "3", "-o", tmp_path)
    done = overview("plugin", "build", *given)
    assert done.code == 0, done.err
    host = Host("clap", built_host("clap", tmp_path), tmp_path / "overview-dsp.clap")
    timelines = [ov.load_timeline(name) for name in (MATCH, "made-up-share")]
    names = ov.bundled_presets()
    assert f": {MATCH}, made-up-share in {', '.join(names)};" in done.out
    # that a preset for hearts names no goal is nothing to be told of
    assert done.err == ""
    for second, timeline in enumerate(timelines):
        for number, name in enumerate(names):
            chosen = [(VALUE, "timeline", EARLIER, second), (VALUE, "preset", EARLIER, number)]
            heard, _ = host.play(tmp_path, [*chosen, *score()], frames=15_000)
            preset = ov.load_preset(name)
            events = host.heard(score(), preset)  # values on logarithmic ranges are rounded
            expected = natively(timeline, preset, 48_000, events, 15_000)
            assert np.array_equal(heard, expected), (second, name)


def test_an_invalid_plugin_is_an_error_of_one_line(match, football, tmp_path, monkeypatch):
    build = ov.export.build_plugin
    with pytest.raises(InputError, match="to is 'au'; must be clap or lv2 or vst3"):
        build(match, football, "au", tmp_path)
    with pytest.raises(InputError, match="there are 0 presets; must be 1 to 64"):
        build(match, [], "clap", tmp_path)
    with pytest.raises(InputError, match="there are 0 timelines; must be 1 to 64"):
        build({}, football, "clap", tmp_path)
    with pytest.raises(InputError, match="the same name"):
        build(match, [football, football], "clap", tmp_path)
    with pytest.raises(InputError, match="target is 'amiga'; must be one of x86_64-linux, "):
        build(match, football, "clap", tmp_path, target="amiga")
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(OverviewError, match="CC is 'no-such-compiler', which is not installed"):
        build(match, football, "clap", tmp_path)
    monkeypatch.setenv("CC", "false")
    with pytest.raises(OverviewError, match="the C compiler false failed"):
        build(match, football, "clap", tmp_path)
    monkeypatch.setenv("CC", "")
    monkeypatch.setattr("shutil.which", lambda name: None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(OverviewError, match="apt install gcc"):
        build(match, football, "clap", tmp_path)
    with pytest.raises(OverviewError, match="for aarch64-macos needs ziglang"):
        build(match, football, "clap", tmp_path, target="aarch64-macos")
    assert not [*tmp_path.iterdir()]
    same = overview("plugin", "build", f"a/{MATCH}", f"b/{MATCH}", "--to", "clap")
    assert same.code == 2


def test_an_angle_of_a_timeline_with_a_calendar_is_told_as_a_date(tmp_path):
    share, gravel = ov.load_timeline("made-up-share"), ov.load_preset("gravel")
    plugin = ov.export.build_plugin(share, gravel, "clap", tmp_path, name="Share")
    host = Host("clap", built_host("clap", tmp_path), library_of(plugin))
    surface = ov.build_surface(share, gravel)
    places = [*(n / 37 for n in range(38))]
    said = host.run("texts", "-", number_of("theta2"), *places).splitlines()
    for place, line in zip(places, said, strict=True):
        moment = share.moment_text(float(surface.time_at(place)))
        assert line.partition("\t")[2] == f"{place:.9g} ({moment})"


@pytest.mark.parametrize("to", ["clap", "vst3"])
def test_a_name_without_room_ends_with_a_whole_character(match, football, tmp_path, to):
    short, long = "x" + "\u00e9" * 39, "\u00e9" * 200
    halves = {"first": match.window(0, 2700), long: match.window(2700, 5600)}
    plugin = ov.export.build_plugin(halves, football, to, tmp_path, name=short)
    host = Host(to, built_host(to, tmp_path), library_of(plugin))
    name = host.run("list").splitlines()[0].partition("\t")[2]
    assert name == {"clap": short, "vst3": short[:32]}[to]
    number = number_of("timeline") & {"clap": 2**32 - 1, "vst3": 2**31 - 1}[to]
    (said,) = host.run("texts", "-", number, 1).splitlines()
    assert said == "1\t" + "\u00e9" * {"clap": 127, "vst3": 126}[to]
    host.play(tmp_path, [], frames=1, saved=tmp_path / "state")
    lost = "x" + "\u00e9" * 127  # as a state has a longer one
    named = (tmp_path / "state").read_bytes().replace(b"first".ljust(255, b"\0"), lost.encode())
    (tmp_path / "state").write_bytes(named)
    (said,) = host.run("texts", tmp_path / "state", number, 0).splitlines()
    assert said == f"0\tfirst (in place of {lost[:50]})"
