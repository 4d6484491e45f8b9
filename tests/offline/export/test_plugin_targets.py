"""Plugins for other machines: what they are, and how they sound under wine and qemu."""

from __future__ import annotations

import importlib.util
import os
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.cli.plugin import _TARGETS
from overview_dsp.offline.export.plugins import TARGETS
from tests.offline.export.plugin_playing import (
    EARLIER,
    HEADERS,
    HERE,
    PRESETS,
    VALUE,
    Host,
    natively,
    preset_named,
    score,
)

pytestmark = [
    pytest.mark.soak,  # each is compiled anew
    pytest.mark.skipif(
        importlib.util.find_spec("ziglang") is None, reason="needs ziglang: pip install ziglang"
    ),
]

MACHINES = {"x86_64-linux": 62, "aarch64-linux": 183}  # of an ELF file
PROCESSORS = {"x86_64-macos": 0x01000007, "aarch64-macos": 0x0100000C}  # of a Mach-O file
ENTRY = {"clap": b"clap_entry", "vst3": b"GetPluginFactory", "lv2": b"lv2_descriptor"}
INSIDE = {
    "x86_64-linux": "Contents/x86_64-linux/film.so",
    "aarch64-linux": "Contents/aarch64-linux/film.so",
    "x86_64-windows": "Contents/x86_64-win/film.vst3",
    "x86_64-macos": "Contents/MacOS/film",
    "aarch64-macos": "Contents/MacOS/film",
}


def test_the_command_names_the_targets_there_are():
    assert _TARGETS == TARGETS


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("to", ENTRY)
def test_a_library_is_of_its_machine_and_where_hosts_look_for_it(
    match, football, tmp_path, to, target
):
    made = ov.export.build_plugin(match, football, to, tmp_path, name="film", target=target)
    assert made == tmp_path / f"film.{to}"
    mac = target.endswith("macos")
    if to == "vst3" or (to == "clap" and mac):
        path = made / INSIDE[target]
    elif to == "clap":
        path = made
    else:
        (path,) = (path for path in made.iterdir() if path.suffix != ".ttl")
        assert f"<{path.name}>" in (made / "manifest.ttl").read_text()
    library = path.read_bytes()
    assert ENTRY[to] in library
    if target in MACHINES:
        assert library[:5] == b"\x7fELF\x02"
        assert struct.unpack_from("<H", library, 18) == (MACHINES[target],)
    elif mac:
        assert struct.unpack_from("<II", library) == (0xFEEDFACF, PROCESSORS[target])
        assert to == "lv2" or (made / "Contents" / "Info.plist").is_file()
    else:
        (header,) = struct.unpack_from("<I", library, 60)
        assert library[header : header + 6] == b"PE\0\0\x64\x86"


def test_a_bundle_holds_libraries_of_several_systems(match, football, tmp_path):
    for target in ("x86_64-linux", "x86_64-windows"):
        made = ov.export.build_plugin(match, football, "vst3", tmp_path, name="film", target=target)
        assert (made / INSIDE[target]).is_file()
    assert (made / INSIDE["x86_64-linux"]).is_file()


def wine(folder):
    program = shutil.which("wine64") or "/usr/lib/wine/wine64"
    if not Path(program).exists():
        pytest.skip("needs wine: apt-get install wine64")
    # else it asks for more of itself
    env = {"WINEPREFIX": str(folder / "prefix"), "WINEDEBUG": "-all"}
    env["WINEDLLOVERRIDES"] = "mscoree,mshtml="
    subprocess.run([program, "wineboot", "-i"], env={**os.environ, **env}, check=True, timeout=1200)
    return ("env", *(f"{name}={value}" for name, value in env.items()), program)


def qemu(folder):
    libraries = Path("/usr/aarch64-linux-gnu")
    if not shutil.which("qemu-aarch64") or not (libraries / "lib").is_dir():
        pytest.skip("needs qemu and a C library: apt-get install qemu-user libc6-arm64-cross")
    return ("qemu-aarch64", "-L", str(libraries))


RUNNERS = {
    "x86_64-windows": (wine, "x86_64-windows-gnu", ()),
    "aarch64-linux": (qemu, "aarch64-linux-gnu.2.17", ("-rdynamic", "-ldl", "-lm")),
}


@pytest.fixture(scope="module", params=RUNNERS)
def elsewhere(request, tmp_path_factory):
    """Another machine: its target, how its programs are run here, and how they are compiled."""
    runner, target, libraries = RUNNERS[request.param]
    run = runner(tmp_path_factory.mktemp("machine"))
    zig = (sys.executable, "-m", "ziglang", "cc", "-target", target, "-O1", "-std=gnu11")
    return request.param, run, (*zig, f"-I{HEADERS}"), libraries


@pytest.mark.parametrize("to", ["clap", "vst3"])
def test_a_plugin_for_another_machine_plays_the_engines_bits(match, elsewhere, tmp_path, to):
    target, run, compiler, libraries = elsewhere
    program = tmp_path / "host.exe"
    command = [*compiler, str(HERE / f"{to}_host.c"), *libraries, "-o", str(program)]
    subprocess.run(command, check=True, timeout=1800)
    presets = {name: preset_named(name) for name in PRESETS}
    made = ov.export.build_plugin(
        match, [*presets.values()], to, tmp_path, name="film", seed=3, target=target
    )
    library = made / INSIDE[target] if to == "vst3" else made
    host = Host(to, (*run, str(program)), library)
    for number, (name, preset) in enumerate(presets.items()):
        for rate in (44_100, 48_000, 96_000, 12_345.678):
            events = [(VALUE, "preset", EARLIER, float(number)), *score()]
            heard, _ = host.play(tmp_path, events, rate=rate)
            expected = natively(match, preset, rate, host.heard(score(), preset))
            assert np.array_equal(heard, expected), (name, rate)
