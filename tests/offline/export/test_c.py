"""The voice in C gives the kernels' bits, whoever compiles it, for whatever machine."""

from __future__ import annotations

import importlib.util
import platform
import re
import shutil
import subprocess
import sys
from importlib import metadata, resources
from pathlib import Path

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.design.gestures import SOURCES
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.errors import OverviewError
from overview_dsp.kernels import layout
from tests.cli.running import MATCH, overview
from tests.parameters import first_in_gate
from tests.web.surfaces import preset_of

ROOT = Path(__file__).resolve().parents[3]
RUNNER = Path(__file__).with_name("c_runner.c")
RATE = 48_000
GESTURE = ov.sweep(0.7) + ov.pause(0.1) + ov.tap(0.95, 0.2) + ov.pause(0.2)
PRESETS = {
    "viscous": lambda: ov.load_preset("football"),
    "bristles": lambda: preset_of("door"),
    "wells": lambda: preset_of("dial"),
}
EVENT = np.dtype([(name, np.int64) for name in ("kind", "which", "sample", "touching")])
EVENT = np.dtype([*EVENT.descr, ("value", np.float64), ("at", np.int64)])
CHANGES = {9_000: ("tactor.gain_db", -7.5), 20_000: ("disk.k2", 6e-3), 30_000: ("click.mute", 1.0)}

ZIG = (sys.executable, "-m", "ziglang")
COMPILERS = {
    "gcc-fma": ("gcc", "-std=gnu99", "-O3", "-march=x86-64-v3"),
    "g++": ("g++", "-x", "c++", "-O2"),
    "clang-fma": (*ZIG, "cc", "-O3", "-march=x86_64_v3"),
    "tcc": ("tcc",),
}
FOREIGN = {
    "aarch64": ("qemu-aarch64", "aarch64-linux-musl"),
    "arm": ("qemu-arm", "arm-linux-musleabihf"),
    "riscv64": ("qemu-riscv64", "riscv64-linux-musl"),
}

REFUSED_FLAGS = (
    "-Ofast", "-ffast-math", "-funsafe-math-optimizations",
    "-fassociative-math -fno-signed-zeros -fno-trapping-math", "-freciprocal-math",
    "-fno-signed-zeros", "-ffinite-math-only", "-fsingle-precision-constant",
    "-mfpmath=387", "-mfpmath=sse,387",
)  # fmt: skip
# no macro tells of these: the self-test must, unless the bits are right
UNSEEN_FLAGS = {
    "gcc": (
        "gcc", "-O2", "-funsafe-math-optimizations", "-U__ASSOCIATIVE_MATH__",
        "-U__RECIPROCAL_MATH__", "-U__NO_SIGNED_ZEROS__", "-Wno-builtin-macro-redefined",
    ),
    "gcc-contract": ("gcc", "-O3", "-march=x86-64-v3", "-ffp-contract=fast"),
    "clang-unsafe": (*ZIG, "cc", "-O2", "-funsafe-math-optimizations"),
    "clang-reciprocal": (*ZIG, "cc", "-O2", "-freciprocal-math"),
    "clang-zeros": (*ZIG, "cc", "-O2", "-fno-signed-zeros"),
    "clang-contract": (*ZIG, "cc", "-O3", "-march=x86_64_v3", "-ffp-contract=fast"),
    "clang-model": (*ZIG, "cc", "-O2", "-ffp-model=fast"),
}  # fmt: skip
RIGHT = {"gcc-contract", "clang-zeros"}


def available(command):
    if command[:3] == ZIG:
        return importlib.util.find_spec("ziglang") is not None
    return shutil.which(command[0]) is not None


def built(folder, compiler, target):
    if not available(compiler):
        pytest.skip(f"needs {' '.join(compiler[:3])}")
    command = [*compiler, f"-I{folder}", str(RUNNER), str(folder / "kernel.c"), "-o", str(target)]
    subprocess.run([*command, "-lm"], check=True, cwd=folder, timeout=1200)
    return target


@pytest.fixture(scope="module")
def folders(match, tmp_path_factory):
    """The exported C of each kind of friction."""
    made = {}
    for name, preset in PRESETS.items():
        made[name] = tmp_path_factory.mktemp(name)
        ov.export.export_c(match, preset(), made[name], seed=3)
    return made


@pytest.fixture(scope="module")
def gcc(folders, tmp_path_factory):
    return (
        str(
            built(folders["viscous"], COMPILERS["gcc-fma"], tmp_path_factory.mktemp("gcc") / "run")
        ),
    )


def events_of(rate):
    hands = np.zeros(len(GESTURE.theta2), EVENT)
    hands["which"] = GESTURE.source
    hands["sample"] = hands["at"] = GESTURE.stamps(rate)
    hands["touching"], hands["value"] = GESTURE.touching, GESTURE.theta2
    columns = sorted(name for name in vars(layout) if name.startswith("PARAM_"))
    columns.sort(key=lambda name: getattr(layout, name))
    numbers = {name.removeprefix("PARAM_"): i for i, name in enumerate(columns)}
    rows = [
        (1, numbers[id.upper().replace(".", "_")], at, 0, value, at)
        for at, (id, value) in CHANGES.items()
    ]
    together = np.concatenate([hands, np.array(rows, EVENT)])
    return together[np.argsort(together["at"], kind="stable")]


def natively(preset, match, rate):
    engine = ov.Engine(preset, match, seed=3)
    frames = round(GESTURE.duration_s * rate)
    engine.prepare(rate, frames)
    engine.control_all(GESTURE.theta2, GESTURE.touching, GESTURE.stamps(rate), GESTURE.source)
    for at, (id, value) in CHANGES.items():
        engine.set(id, bool(value) if id.endswith("mute") else value, sample_time=at)
    out = np.zeros((frames, 2), np.float32)
    engine.process(out)
    return out


def in_c(program, folder, rate, block, frames):
    events, out = folder / "events", folder / "out"
    events.write_bytes(events_of(rate).tobytes())
    arguments = [folder / "timeline.image", rate, block, frames, events, out]
    subprocess.run([*program, *map(str, arguments)], check=True, timeout=1200)
    return np.fromfile(out, np.float32).reshape(-1, 2)


@pytest.fixture(scope="module")
def native(match):
    made = {}

    def of(kind, rate=RATE):
        if (kind, rate) not in made:
            made[kind, rate] = natively(PRESETS[kind](), match, rate)
        return made[kind, rate]

    return of


@pytest.mark.parametrize("kind", PRESETS)
@pytest.mark.parametrize("block", [1, 17, 64, 4096])
def test_no_block_size_changes_a_bit(folders, gcc, native, kind, block):
    expected = native(kind)
    assert np.abs(expected).max(axis=0).min() > 0.05
    assert np.array_equal(in_c(gcc, folders[kind], RATE, block, len(expected)), expected)


@pytest.mark.parametrize("rate", [8_000, 12_345.678, 44_100, 96_000])
@pytest.mark.parametrize("kind", PRESETS)
def test_one_image_serves_every_sample_rate(folders, gcc, native, kind, rate):
    expected = native(kind, rate)
    assert np.array_equal(in_c(gcc, folders[kind], rate, 512, len(expected)), expected)


@pytest.mark.parametrize(
    "name", ["tcc", *(pytest.param(name, marks=pytest.mark.soak) for name in ("g++", "clang-fma"))]
)
def test_every_compiler_gives_the_same_bits(folders, native, tmp_path, name):
    program = (str(built(folders["viscous"], COMPILERS[name], tmp_path / "run")),)
    for kind in PRESETS:
        assert np.array_equal(
            in_c(program, folders[kind], RATE, 256, len(native(kind))), native(kind)
        ), kind


@pytest.mark.soak
@pytest.mark.parametrize("name", FOREIGN)
def test_every_processor_gives_the_same_bits(folders, native, tmp_path, name):
    emulator, target = FOREIGN[name]
    if not shutil.which(emulator):
        pytest.skip(f"needs {emulator}: apt-get install qemu-user")
    compiler = (*ZIG, "cc", "-target", target, "-static", "-O2")
    program = emulator, str(built(folders["viscous"], compiler, tmp_path / "run"))
    for kind in PRESETS:
        assert np.array_equal(
            in_c(program, folders[kind], RATE, 256, len(native(kind))), native(kind)
        ), kind


@pytest.mark.parametrize("flags", REFUSED_FLAGS)
def test_options_that_change_the_arithmetic_do_not_compile(folders, tmp_path, flags):
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    if "mfpmath" in flags and platform.machine() != "x86_64":
        pytest.skip("needs an x86-64 processor")
    command = ["gcc", "-O1", *flags.split(), "-c", str(folders["viscous"] / "kernel.c")]
    done = subprocess.run(
        [*command, "-o", str(tmp_path / "kernel.o")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "overview" in next(line for line in done.stderr.splitlines() if "error" in line).lower()


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name == "gcc" else pytest.mark.soak) for name in UNSEEN_FLAGS],
)
def test_a_miscompiled_voice_reports_it_or_has_the_right_bits(folders, native, tmp_path, name):
    program = built(folders["viscous"], UNSEEN_FLAGS[name], tmp_path / "run")
    for kind in PRESETS:
        if name in RIGHT:
            expected = native(kind)
            assert np.array_equal(
                in_c((str(program),), folders[kind], RATE, 256, len(expected)), expected
            ), kind
        else:
            image = folders[kind] / "timeline.image"
            command = [program, image, RATE, 256, 256, image, tmp_path / "out"]
            done = subprocess.run(
                list(map(str, command)), capture_output=True, text=True, check=False, timeout=600
            )
            assert done.returncode == 4
            assert "compile it without -ffast-math" in done.stderr
            assert not (tmp_path / "out").exists()


BUGS = {
    "ov_prepare": "v1 *= 1.0000000001;",
    "ov_control": "v3 *= 1.0000000001;",
    "ov_change": "v2 *= 1.0000000001;",
    "ov_reset": "if (v0) return 0;",
    "ov_process": "v2 -= v2 > 1;",
}
"""A line that makes a function of kernel.c a little wrong."""


@pytest.fixture(scope="module", params=BUGS)
def wrong_library(request, folders, tmp_path_factory):
    """A voice with one wrong function, compiled."""
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    folder = tmp_path_factory.mktemp("wrong")
    source = (folders["viscous"] / "kernel.c").read_text(encoding="utf-8")
    begin = re.search(rf"^static \w+ {request.param}\(.*\) {{$", source, re.M)
    source = source[: begin.end()] + "\n" + BUGS[request.param] + source[begin.end() :]
    (folder / "wrong.c").write_text(source, encoding="utf-8")
    command = ["gcc", "-O0", "-fPIC", "-shared", f"-I{folders['viscous']}", "wrong.c"]
    subprocess.run([*command, "-o", "voice.so", "-lm"], check=True, cwd=folder)
    return folder / "voice.so"


def test_a_wrong_function_is_found_at_once_and_refused_from_then_on(folders, wrong_library):
    import ctypes

    image = (folders["viscous"] / "timeline.image").read_bytes()
    for _ in range(2):
        said, memory = in_memory(folders, wrong_library, image)
        assert (said, memory.any()) == (-2, False)
    voice = ctypes.CDLL(str(wrong_library))
    m, out = ctypes.c_void_p(memory.ctypes.data), np.ones(8, np.float32)
    now, number = ctypes.c_int64(-1), ctypes.c_double(48_000.0)
    results = (
        voice.overview_prepare(m, number),
        voice.overview_reset(m),
        voice.overview_control(m, 0, now, ctypes.c_double(1.0), 1),
        voice.overview_change(m, 0, ctypes.c_double(1e-5), now),
        voice.overview_process(m, ctypes.c_void_p(out.ctypes.data), ctypes.c_int64(4), 2),
    )
    assert results == (-2,) * 5
    assert not memory.any()
    assert (out == 1.0).all()


ATOMICS = {
    "builtins": (),
    "fences": ("-U__GCC_ATOMIC_LLONG_LOCK_FREE",),
    "C11": ("-U__GCC_ATOMIC_LLONG_LOCK_FREE", "-U__GCC_ATOMIC_INT_LOCK_FREE", "-std=c11"),
    "none": ("-U__GCC_ATOMIC_LLONG_LOCK_FREE", "-U__GCC_ATOMIC_INT_LOCK_FREE", "-std=gnu99"),
}
"""Options of gcc for each way in which `operations.h` orders the queues of threads."""


@pytest.mark.parametrize("name", first_in_gate(list(ATOMICS)[1:]))
def test_every_kind_of_atomic_access_gives_the_same_bits(folders, native, tmp_path, name):
    options = ("-Wno-builtin-macro-redefined", *ATOMICS[name])
    program = (str(built(folders["viscous"], ("gcc", "-O1", *options), tmp_path / "run")),)
    for kind in PRESETS:
        assert np.array_equal(
            in_c(program, folders[kind], RATE, 256, len(native(kind))), native(kind)
        ), kind


# the sanitizer cannot follow fences, and without atomics one thread alone is allowed
@pytest.mark.parametrize("name", ["builtins", "C11"])
def test_no_thread_races_with_another(folders, tmp_path, name):
    """One thread processes, one controls, one changes parameters, as `overview.h` allows."""
    program = tmp_path / "races"
    command = ["gcc", "-O1", "-fsanitize=thread", f"-I{folders['viscous']}"]
    command += ["-D_GNU_SOURCE", "-Wno-builtin-macro-redefined", *ATOMICS[name]]
    sources = [RUNNER.with_name("races.c"), folders["viscous"] / "kernel.c"]
    empty = tmp_path / "empty.c"
    empty.write_text("int main(void) { return 0; }\n", encoding="utf-8")
    # with random addresses ThreadSanitizer does not start on every Linux
    fixed = [*(("setarch", "-R") if shutil.which("setarch") else ()), str(program)]
    try:
        subprocess.run([*command, str(empty), "-o", str(program)], check=True, capture_output=True)
        subprocess.run(fixed, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("needs gcc with ThreadSanitizer: apt-get install gcc libtsan2")
    subprocess.run(
        [*command, *map(str, sources), "-o", str(program), "-lm", "-lpthread"], check=True
    )
    image = str(folders["viscous"] / "timeline.image")
    done = subprocess.run([*fixed, image], capture_output=True, text=True, check=False, timeout=600)
    assert "ThreadSanitizer" not in done.stderr
    assert done.returncode == 0
    assert "strikes" in done.stdout


def test_the_example_is_a_sweep_as_the_engine_plays_it(match, football, tmp_path):
    done = overview("export", MATCH, "--to", "c", "-o", tmp_path / "voice")
    assert done.code == 0, done.err
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    program = tmp_path / "voice" / "example"
    sources = [program.with_name(name) for name in ("example.c", "kernel.c")]
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Wno-unused-label", "-Werror"]
    subprocess.run(["gcc", *flags, *map(str, sources), "-o", str(program), "-lm"], check=True)
    wav = tmp_path / "out.wav"
    image = program.with_name("timeline.image")
    subprocess.run([str(program), str(image), str(wav), "44100"], check=True)
    samples, rate = soundfile.read(wav, dtype="float32")
    engine = ov.Engine(football, match)
    engine.prepare(rate, len(samples))
    for event in range(401):
        engine.control(np.pi * event / 400, event < 400, event * rate // 100)
    expected = np.zeros_like(samples)
    engine.process(expected)
    assert rate == 44_100
    assert np.array_equal(samples, expected)


def in_memory(folder, library, image):
    """What `overview_load` says of bytes, and whether it wrote any."""
    import ctypes

    voice = ctypes.CDLL(str(library))
    voice.overview_load.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int64]
    memory = np.zeros(layout.TOTAL)
    said = voice.overview_load(memory.ctypes.data, image, len(image))
    return said, memory


@pytest.fixture(scope="module")
def library(folders, tmp_path_factory):
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    target = tmp_path_factory.mktemp("library") / "voice.so"
    command = ["gcc", "-O2", "-fPIC", "-shared", str(folders["viscous"] / "kernel.c")]
    subprocess.run([*command, "-o", str(target), "-lm"], check=True)
    return target


@pytest.mark.parametrize("kind", PRESETS)
def test_an_image_is_the_engines_memory(folders, library, match, kind):
    engine = ov.Engine(PRESETS[kind](), match, seed=3)
    engine.prepare(RATE)
    ov.export.encode_engine(engine)  # connects it
    said, memory = in_memory(
        folders[kind], library, (folders[kind] / "timeline.image").read_bytes()
    )
    assert said == 0
    assert np.array_equal(memory.view(np.int64), engine.memory.view(np.int64))


def test_what_c_would_ignore_is_refused(tmp_path):
    for option in (
        ("--gesture", "tap:0.5"),
        ("--zoom-levels", "1"),
        ("--actuator", "c2"),
        ("--to", "web"),
    ):
        done = overview("export", MATCH, "--to", "c", "-o", tmp_path / "voice", *option)
        assert done.code == 2
        assert "--to c" in done.err
    assert not (tmp_path / "voice").exists()


def test_damaged_images_are_refused(folders, library):
    image = (folders["bristles"] / "timeline.image").read_bytes()
    random = np.random.default_rng(1)
    damaged = [image[:n] for n in (0, 8, 40, 4096, len(image) // 16 * 8, len(image) - 8)]
    damaged += [image + bytes(8), image[:-3], bytes(len(image))]
    damaged += [b"\0" * 8 + image[8:]]  # of another layout
    damaged += [random.bytes(len(image)), image[:40] + random.bytes(1 << 16)]
    for bytes_ in damaged:
        said, memory = in_memory(folders, library, bytes_)
        assert said == -1
        assert not memory.any()


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("SLOT_EVENTS", layout.MAX_EVENTS + 1),
        ("SLOT_LOWER_EVENT", -1),
        ("SLOT_UPPER_EVENT", 1 << 40),
        ("SLOT_KIND", layout.BANKS),
        ("SLOT_OWNER", 1 << 50),
        ("KIND_CLICK", layout.MAX_MODES + 1),
        ("SLOT_TABLE", np.float64(-1.0).view(np.int64)),
        ("SLOT_TABLE", np.float64(np.nan).view(np.int64)),
    ],
)
def test_an_image_that_would_lead_elsewhere_is_refused(match, library, column, value):
    engine = ov.Engine(PRESETS["bristles"](), match)
    engine.prepare(RATE)
    engine.memory.view(np.int64)[layout.SURFACES + getattr(layout, column)] = value
    said, memory = in_memory(None, library, ov.export.encode_engine(engine))
    assert said == -1
    assert not memory.any()


def test_invalid_values_are_refused_without_effect(folders, library):
    import ctypes

    voice = ctypes.CDLL(str(library))
    for name in ("overview_control", "overview_change", "overview_prepare"):
        getattr(voice, name).restype = ctypes.c_int32
    at, number = ctypes.c_void_p, ctypes.c_double
    _, memory = in_memory(None, library, (folders["viscous"] / "timeline.image").read_bytes())
    m = at(memory.ctypes.data)
    for rate in (0.0, 999.0, 768_001.0, np.nan, np.inf, -48_000.0):
        assert voice.overview_prepare(m, number(rate)) == -1
    assert voice.overview_prepare(m, number(48_000.0)) == 0
    before = memory.copy()
    now = ctypes.c_int64(-1)
    for source in (-1, len(SOURCES)):
        assert voice.overview_control(m, source, now, number(1.0), 1) == -1
    gain = layout.PARAM_TACTOR_GAIN_DB - layout.PARAMS
    top = PARAMETERS["tactor.gain_db"].high
    for which, value in ((-1, 0.0), (layout.PARAMETERS, 0.0), (gain, np.nan), (gain, top + 1.0)):
        assert voice.overview_change(m, which, number(value), now) == -1
    out = np.ones(8, np.float32)
    assert voice.overview_process(m, at(out.ctypes.data), ctypes.c_int64(4), 1) == -1
    assert np.array_equal(memory.view(np.int64), before.view(np.int64))
    for _ in range(layout.RING):
        assert voice.overview_control(m, 0, now, number(1.0), 1) == 0
    assert voice.overview_control(m, 0, now, number(1.0), 1) == -1


def test_source_of_other_kernels_is_refused(monkeypatch, match, football, tmp_path):
    monkeypatch.setattr("overview_dsp.offline.export.c_code.sources_digest", lambda: "0" * 16)
    with pytest.raises(OverviewError, match=r"run python tools/build_c\.py"):
        ov.export.export_c(match, football, tmp_path)


@pytest.mark.soak
def test_the_source_built_anew_is_the_one_in_the_package(tmp_path):
    shipped = resources.files("overview_dsp.offline.export") / "c"
    head = (shipped / "kernel.c").read_text(encoding="utf-8").splitlines()[:3]
    for part in head[2].removesuffix(" */").split(","):
        name, version = part.split()
        if metadata.version(name) != version:
            pytest.skip(f"the same bytes need the same tool-chain: pip install {name}=={version}")
    subprocess.run([sys.executable, str(ROOT / "tools" / "build_c.py"), str(tmp_path)], check=True)
    for name in ("kernel.c", "overview.h"):
        assert (tmp_path / name).read_bytes() == (shipped / name).read_bytes(), name


def test_the_header_names_every_parameter_with_its_range(folders, library):
    import ctypes

    class Row(ctypes.Structure):
        _fields_ = [
            ("id", ctypes.c_char_p), ("unit", ctypes.c_char_p),
            ("lowest", ctypes.c_double), ("highest", ctypes.c_double),
        ]  # fmt: skip

    rows = (Row * layout.PARAMETERS).in_dll(ctypes.CDLL(str(library)), "overview_parameters")
    for row in rows:
        known = PARAMETERS[row.id.decode()]
        assert row.unit.decode() == known.unit
        if isinstance(known.default, float):
            assert (row.lowest, row.highest) == (known.low, known.high)
        else:
            assert (row.lowest, row.highest) == (0.0, 1.0)
