"""The firmware of the kit, built, run in emulators on a pseudo-terminal, and played."""

from __future__ import annotations

import itertools
import json
import math
import os
import platform
import re
import select
import subprocess
import sys
import time
import tty
from pathlib import Path

import pytest

import overview_dsp as ov
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.source import SensorSource
from overview_dsp.devices.sensors.touch_detection import TouchRules
from tests.devices.force_feedback.board_frames import all_frames
from tests.firmware import boards
from tests.firmware.boards import FIRMWARE, HERE, MICROBIT, needs, run, sketch
from tests.live.priority import urgently

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs a pseudo-terminal")
GUIDES = boards.ROOT / "docs" / "guide"
PLAY = [sys.executable, "-m", "overview_dsp", "play", "world-cup-final-2018", "--device", "none"]
KITS = {
    "pot": ("pot",),
    "encoder": ("encoder",),
    "imu": ("mpu6050", "mpu6500", "mpu9250", "icm20689", "clone72", "lsm6ds3", "bno055"),
}


@pytest.fixture(scope="module")
def core(tmp_path_factory):
    """The Uno's core."""
    boards.needs_arduino()
    return boards.arduino_core(tmp_path_factory.mktemp("core"))


@pytest.fixture(scope="module")
def uno(tmp_path_factory):
    """The emulated Uno."""
    boards.needs_simavr()
    return boards.emulated_uno(tmp_path_factory.mktemp("uno"))


@pytest.mark.parametrize("name", KITS)
def test_each_sketch_of_the_kit_is_built_for_an_uno(core, tmp_path, name):
    built = sketch(core, FIRMWARE / name / f"{name}.ino", tmp_path / "board.elf")
    _, sizes = run("avr-size", built).stdout.splitlines()
    text, data, bss = map(int, sizes.split()[:3])
    assert text + data < 32_256
    assert data + bss < 1_500


@pytest.mark.parametrize("name", KITS)
def test_the_ready_program_for_an_uno_is_that_of_the_sketch(core, tmp_path, name):
    version = run("avr-gcc", "-dumpversion").stdout.strip()
    if version != "5.4.0":
        pytest.skip(f"needs avr-gcc 5.4.0, which made them; here is {version}")
    same = (FIRMWARE / name / "uno.hex").read_text() == boards.ready(core, name, tmp_path)
    assert same, "run python -m tests.firmware.boards"


def test_the_sketch_of_the_guide_is_built_for_an_uno(core, tmp_path):
    (text,) = re.findall(r"```cpp\n(.*?)```", (GUIDES / "sensors.md").read_text("utf-8"), re.S)
    source = tmp_path / "guide.ino"
    source.write_text(text + "int16_t at[6];\nvoid setup() {}\nvoid loop() { sendSample(at); }\n")
    sketch(core, source, tmp_path / "board.elf")


SENSORS = [(name, one) for name, all in KITS.items() for one in all]
OFF_DEG = {"pot": 0.6, "encoder": 4.6, "imu": 1.0}
"""How far theta2 may be from the hand: a step of the encoder has 4.5."""


@pytest.mark.parametrize(("name", "sensor"), SENSORS)
def test_what_an_emulated_uno_sends_is_understood_and_followed(core, uno, tmp_path, name, sensor):
    """In the emulator's own time."""
    if name == "imu":
        pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
    source = FIRMWARE / name / f"{name}.ino"
    built = sketch(core, source, tmp_path / "board.elf")
    sent = emulated(uno, built, sensor)
    first = b"".join(byte for *_, byte in sent[:200]).split(b"\r\n")[0].decode()
    chip = {"lsm6ds3": "LSM6DS3", "bno055": "BNO055"}.get(sensor, "MPU-6050")
    assert first == reset_line(source).replace("MPU-6050", chip)
    reader, off = followed(sent, 175.0 if name == "imu" else 180.0)
    counters = reader.counters
    print(sensor, len(off), max(off), counters)
    assert len(off) > 1700
    assert (counters.damaged, counters.lost, counters.implausible) == (0, 0, 0)
    assert max(off) < OFF_DEG[name]


def emulated(uno, built, sensor):
    """What a board sends in 11 s: time (s), the hand's turn (0 to 1), and a byte."""
    said = run(uno, built, "-", 11, sensor, 2, timeout=240).stdout
    return [
        (float(time_s), float(turned), bytes.fromhex(byte))
        for time_s, turned, byte in re.findall(r"^([\d.]+) ([\d.]+) ([0-9a-f]{2})$", said, re.M)
    ]


def followed(sent, whole):
    """A source that reads it, and how far its theta2 is from the hand (deg) at each sample."""
    reader = SensorSource(Sensor(), TouchRules.of(ov.load_preset("football")))
    off = []
    data, since = b"", 0.0
    for (time_s, turned, byte), (then, *_) in itertools.pairwise(sent):
        data, since = data + byte, since if data else turned
        if then - time_s < 5e-4:  # the same sample goes on
            continue
        before = reader.angle
        reader.feed(data, time_s)
        data = b""
        if reader.angle is not before:
            off.append(abs(math.degrees(reader.angle.theta2) - since * whole))
    return reader, off


@pytest.mark.parametrize(
    ("sensor", "line"),
    [("mpu6050", "writeRegister(0x6B, 0x01);"), ("icm20689", "writeRegister(0x6B, 0x01);"),
     ("mpu6500", "writeRegister(0x1C, 0x18);"), ("lsm6ds3", "writeRegister(0x10, 0x54);"),
     ("bno055", "writeRegister(0x3D, 0x05);")],
)  # fmt: skip
def test_a_sketch_that_leaves_a_chip_asleep_or_in_another_range_is_not_followed(
    core, uno, tmp_path, sensor, line
):
    pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
    text = (FIRMWARE / "imu" / "imu.ino").read_text("utf-8")
    assert line in text
    (tmp_path / "imu.ino").write_text(text.replace(line, ""))
    (tmp_path / "frame.h").write_text((FIRMWARE / "imu" / "frame.h").read_text("utf-8"))
    built = sketch(core, tmp_path / "imu.ino", tmp_path / "board.elf")
    reader, off = followed(emulated(uno, built, sensor), 175.0)
    assert not off
    assert any("gravity" in said for said in reader.take_messages())


def reset_line(path):
    """The line that a sketch's head says it prints on reset."""
    return re.search(r"^ +(# overview .*?)\s*$", path.read_text("utf-8"), re.M).group(1)


@pytest.mark.realtime
@pytest.mark.parametrize(("name", "sensor"), [("pot", "pot"), ("imu", "mpu6050")])
def test_an_emulated_uno_is_played_over_a_pseudo_terminal(core, uno, tmp_path, name, sensor):
    if name == "imu":
        pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
    built = sketch(core, FIRMWARE / name / f"{name}.ino", tmp_path / "board.elf")
    link = tmp_path / "board"
    board = subprocess.Popen(
        [uno, built, link, "60", sensor, "8"], stdout=subprocess.PIPE, text=True,
        preexec_fn=urgently,
    )  # fmt: skip
    try:
        assert f"serial:{link}\n" in iter(board.stdout.readline, "")  # after simavr's own lines
        lines = played(link, 20.0)
    finally:
        board.terminate()
        said = json.loads(board.communicate(timeout=20)[0].splitlines()[-1])
    report = lines[-1]["summary"]["input"]
    print(sensor, report, said)
    assert report["format"] == ("binary frames" if name == "imu" else "lines of pot")
    assert report["readings"] > 2000
    assert (report["damaged"], report["lost"], report["implausible"]) == (0, 0, 0)
    check_followed(lines[:-1], 175.0 if name == "imu" else 180.0)


def played(link, seconds, *more):
    done = subprocess.run(
        [*PLAY, "--input", f"serial:{link}", "--seconds", str(seconds), *more],
        capture_output=True, text=True, timeout=240,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(boards.ROOT), *sys.path])},
        preexec_fn=urgently,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def check_followed(lines, degrees):
    """The disk went with the hand: to its far end and back."""
    cursors = [line["cursor"] for line in lines]
    assert max(cursors) == pytest.approx(degrees / 180.0, abs=0.03)
    # of the first time: a second turn may go a hair further, and not be over
    far = next(n for n, one in enumerate(cursors) if one > max(cursors) - 0.03)
    assert min(cursors[:far]) < 0.2
    assert min(cursors[far:], default=0.0) < 0.3


# --- the core of a motor knob's firmware, the same bits on each -----------------------------------

STEPS = {65: 1000, 8193: 4000}
"""Points of the table, and how many torques are compared."""


def data_header(points, folder):
    """`data.h` for `bits.c`: what a host sends, and a hand's angles."""
    import numpy as np

    from overview_dsp.devices.force_feedback.board_loop import BoardLoop
    from overview_dsp.devices.sensors.profile import load_sensor

    football = ov.load_preset("football")
    surface = ov.build_surface(ov.load_timeline("world-cup-final-2018"), football)
    loop = BoardLoop(load_sensor("simplefoc"), 1_000_000)
    loop.render(surface, football.values)
    frames = b"".join(all_frames(loop, points))
    frames += b"\x05damaged\x00"
    dice = np.random.default_rng(1)
    n = np.arange(STEPS[points])
    hand = 9000.0 * n / len(n) + 300.0 * np.sin(n / 40.0) + dice.integers(-1, 2, len(n))
    counts = np.rint(hand).astype(int)
    (folder / "data.h").write_text(
        f"static const uint8_t FRAMES[] FAR = {{{','.join(map(str, frames))}}};\n"
        f"static const int16_t COUNTS[] FAR = {{{','.join(map(str, counts))}}};\n"
    )
    return ["-std=c99", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror",
            f"-DKNOB_POINTS={points}", f"-I{FIRMWARE / 'knob'}", f"-I{folder}",
            HERE / "bits.c"]  # fmt: skip


def bits_here(points, folder, level="-O2"):
    needs("gcc", "gcc")
    flags = data_header(points, folder)
    run("gcc", level, *flags, "-o", folder / "here")
    lines = run(folder / "here").stdout.split()
    assert len(lines) == STEPS[points] + 1
    assert lines.pop() == "00000001"  # the damaged frame, and no other
    assert len(set(lines)) > len(lines) // 2  # it is felt
    return lines


def test_the_bits_are_the_same_at_every_optimisation(tmp_path):
    assert bits_here(8193, tmp_path, "-O0") == bits_here(8193, tmp_path, "-O3")


@pytest.mark.skipif(platform.machine() != "x86_64", reason="needs a processor with FMA (x86-64)")
def test_the_bits_are_the_same_where_products_and_sums_could_be_one(tmp_path):
    """By the file's own pragma: who flashes a board sets no flags."""
    flags = Path("/proc/cpuinfo")
    if not flags.is_file() or " fma " not in flags.read_text():
        pytest.skip("needs a processor with FMA")
    plain = bits_here(8193, tmp_path)
    header = [one for one in data_header(8193, tmp_path) if one != "-ffp-contract=off"]
    run("gcc", "-O3", "-mfma", "-ffp-contract=fast", *header, "-o", tmp_path / "fused")
    assert run(tmp_path / "fused").stdout.split()[:-1] == plain


CORES = {
    "an385": ("cortex-m3", "soft", "auto"),
    "an386": ("cortex-m4", "hard", "fpv4-sp-d16"),
    "an500": ("cortex-m7", "hard", "fpv5-d16"),
}


@pytest.mark.parametrize("machine", CORES)
def test_the_bits_are_the_same_on_an_arm_core(tmp_path, machine):
    needs("gcc-arm-none-eabi libnewlib-arm-none-eabi", "arm-none-eabi-gcc")
    needs("qemu-system-arm", "qemu-system-arm")
    here = bits_here(8193, tmp_path)
    cpu, abi, fpu = CORES[machine]
    built = tmp_path / "board.elf"
    run("arm-none-eabi-gcc", "-O2", *data_header(8193, tmp_path), f"-mcpu={cpu}", "-mthumb",
        f"-mfloat-abi={abi}", *([] if abi == "soft" else [f"-mfpu={fpu}"]),
        "--specs=rdimon.specs", "-nostartfiles", "-T", HERE / "arm.ld", "-o", built)  # fmt: skip
    there = run("qemu-system-arm", "-M", f"mps2-{machine}", "-nographic", "-monitor", "none",
                "-serial", "none", "-semihosting-config", "enable=on,target=native",
                "-kernel", built, timeout=120)  # fmt: skip
    said = there.stdout + there.stderr
    assert said.split()[:-1] == here


def test_the_bits_are_the_same_on_an_avr(tmp_path):
    needs("gcc-avr avr-libc", "avr-gcc")
    needs("simavr", "simavr")
    here = bits_here(65, tmp_path)
    built = tmp_path / "board.elf"
    run("avr-gcc", "-mmcu=atmega328p", "-DF_CPU=16000000UL", "-Os", *data_header(65, tmp_path),
        "-o", built)  # fmt: skip
    there = run("simavr", "-m", "atmega328p", "-f", "16000000", built, timeout=120)
    said = re.findall(r"([0-9a-f]{8})\.", there.stdout + there.stderr)  # with colours
    assert said[:-1] == here


# --- MicroPython ----------------------------------------------------------------------------------

MADE_UP = """
def made_up(state=[0]):
    state[0] += 1
    t = max(0, state[0] / 80 - 8) % 11
    part = min(1, t / 3) if t < 6 else max(0, (9 - t) / 3)
    return "%.2f" % (175 * part * part * (3 - 2 * part))
run("made up", "roll_deg", made_up)
"""


@pytest.mark.realtime
def test_micropython_on_an_emulated_microbit_is_played(tmp_path):
    needs("firmware-microbit-micropython", MICROBIT)
    needs("qemu-system-arm", "qemu-system-arm")
    text = (FIRMWARE / "micropython" / "main.py").read_text("utf-8")
    program, last = text.rsplit("\n\n\n", 1)
    assert last == "run(*found())\n"
    # a file is read line by line, but what is pasted is kept, and there are 10 kB for all
    program = re.sub(r"^ *#.*\n", "", program, flags=re.M)
    ours, theirs = os.openpty()
    tty.setraw(ours)
    tty.setraw(theirs)
    board = subprocess.Popen(
        ["qemu-system-arm", "-M", "microbit", "-nographic", "-monitor", "none", "-serial", "stdio",
         "-device", f"loader,file={MICROBIT}"], stdin=theirs, stdout=theirs, preexec_fn=urgently,
    )  # fmt: skip
    try:
        paste(ours, program + MADE_UP)
        os.close(theirs)
        # `play` opens what the board writes to: a second terminal, joined to the first
        lines = relayed(ours, tmp_path / "board", 20.0)
    finally:
        board.kill()
        board.wait()
        os.close(ours)
    report = lines[-1]["summary"]["input"]
    print(report)
    assert report["format"] == "lines of roll_deg"
    assert report["readings"] > 500
    assert report["implausible"] == 0
    check_followed(lines[:-1], 175.0)


def paste(port, program):
    """A program into the raw REPL, in pieces that its buffer holds."""
    wait_for(port, b">>> ")
    os.write(port, b"\x01")
    wait_for(port, b"raw REPL")
    wait_for(port, b">")
    for at in range(0, len(program), 32):
        os.write(port, program[at : at + 32].encode())
        time.sleep(0.03)
    os.write(port, b"\x04")
    wait_for(port, b"OK")


def wait_for(port, said):
    """Read until it is said."""
    data, until = b"", time.monotonic() + 60.0
    while said not in data:
        assert time.monotonic() < until, data
        if select.select([port], [], [], 0.1)[0]:
            data += os.read(port, 1)


def relayed(ours, link, seconds):
    """Play a second pseudo-terminal that gets what `ours` says."""
    import threading

    play, port = os.openpty()
    tty.setraw(port)
    link.symlink_to(os.ttyname(port))
    over = threading.Event()

    def relay():
        while not over.is_set():
            if select.select([ours], [], [], 0.1)[0]:
                os.write(play, os.read(ours, 4096))

    thread = threading.Thread(target=relay)
    thread.start()
    try:
        return played(link, seconds)
    finally:
        over.set()
        thread.join()
        os.close(play)
        os.close(port)
