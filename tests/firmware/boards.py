"""Compilers and emulators of boards, where they are installed."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FIRMWARE = ROOT / "firmware"
HERE = Path(__file__).resolve().parent
ARDUINO = Path("/usr/share/arduino/hardware/arduino/avr")
MICROBIT = Path("/usr/share/firmware-microbit-micropython/firmware.hex")

SIMPLE_FOC = """
struct { void setClock(uint32_t) {} } Wire;
enum { AS5048_I2C };
enum class MotionControlType { torque, velocity };
struct MagneticSensorI2C { MagneticSensorI2C(int) {} void init() {} };
struct BLDCDriver3PWM {
  float voltage_power_supply;
  BLDCDriver3PWM(int, int, int, int) {}
  void init() {}
};
struct BLDCMotor {
  float voltage_limit = 0;
  MotionControlType controller = MotionControlType::velocity;
  BLDCMotor(int) {}
  template <class T> void linkSensor(T *) {}
  template <class T> void linkDriver(T *) {}
  void init() {} void initFOC() {} void loopFOC() { loop_foc(); }
  float shaftAngle() { return angle; }
  void move(float target) { volts = target; }
};
"""
"""Stand-in for SimpleFOC: its motor has `angle` and `volts`, and runs `loop_foc`."""

UNO = (
    "-mmcu=atmega328p", "-DF_CPU=16000000UL", "-DARDUINO=10807", "-DARDUINO_AVR_UNO",
    "-DARDUINO_ARCH_AVR", f"-I{ARDUINO}/cores/arduino", f"-I{ARDUINO}/variants/standard",
    f"-I{ARDUINO}/libraries/Wire/src", "-Os", "-ffunction-sections", "-fdata-sections",
    # Debian's compiler is 5.4, which lacks it
    "-DDECIMAL_DIG=__DECIMAL_DIG__",
)  # fmt: skip
CPP = ("-flto", "-std=gnu++11", "-fpermissive", "-fno-exceptions", "-fno-threadsafe-statics", "-w")


def needs(packages: str, *found: object) -> None:
    """Skip unless each of `found` (programs, files) is there."""
    for one in found:
        there = one.exists() if isinstance(one, Path) else shutil.which(str(one)) is not None
        if not there:
            pytest.skip(f"needs {one} (Debian: apt install {packages})")


def run(*command: object, **options: object) -> subprocess.CompletedProcess:
    """A command that must succeed; what it said is in the failure."""
    done = subprocess.run(
        [str(one) for one in command], text=True, capture_output=True, check=False, **options
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done


def needs_arduino() -> None:
    needs("gcc-avr avr-libc arduino-core-avr", "avr-gcc", "avr-g++", ARDUINO / "cores")


def needs_simavr() -> None:
    needs("gcc libsimavr-dev libelf-dev", "gcc", Path("/usr/include/simavr/sim_avr.h"))


def arduino_core(folder: Path) -> Path:
    """The Uno's core and its Wire library, compiled."""
    wire = ARDUINO / "libraries" / "Wire" / "src"
    core = ARDUINO / "cores" / "arduino"
    c = [*core.glob("*.c"), *(wire / "utility").glob("*.c")]
    run("avr-gcc", *UNO, "-flto", "-std=gnu11", "-w", "-c", *c, cwd=folder)
    run("avr-gcc", *UNO, "-x", "assembler-with-cpp", "-c", *core.glob("*.S"), cwd=folder)
    run("avr-g++", *UNO, *CPP, "-c", *core.glob("*.cpp"), *wire.glob("*.cpp"), cwd=folder)
    run("avr-gcc-ar", "rcs", "core.a", *folder.glob("*.o"), cwd=folder)
    return folder / "core.a"


def sketch(core: Path, source: Path, built: Path) -> Path:
    """A sketch, compiled and linked as the Arduino IDE does."""
    run("avr-g++", *UNO, *CPP, "-fuse-linker-plugin", "-Wl,--gc-sections", "-include", "Arduino.h",
        f"-I{source.parent}", "-x", "c++", source, "-x", "none", core, "-lm",
        "-o", built)  # fmt: skip
    return built


KITS = ("pot", "encoder", "imu")


def ready(core: Path, name: str, folder: Path) -> str:
    """The program of a sketch for an Uno or a Nano, as it is uploaded (Intel HEX)."""
    built = sketch(core, FIRMWARE / name / f"{name}.ino", folder / f"{name}.elf")
    run("avr-objcopy", "-O", "ihex", "-R", ".eeprom", built, folder / f"{name}.hex")
    return (folder / f"{name}.hex").read_text().replace("\r\n", "\n")


def emulated_uno(folder: Path) -> Path:
    """`uno.c`, compiled."""
    program = folder / "uno"
    run("gcc", "-O2", "-Wall", HERE / "uno.c", "-o", program, "-I/usr/include/simavr", "-lsimavr",
        "-lelf", "-lm", "-lutil")  # fmt: skip
    return program


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as made:
        built_core = arduino_core(Path(made))
        for kit in KITS:
            (FIRMWARE / kit / "uno.hex").write_text(ready(built_core, kit, Path(made)))
