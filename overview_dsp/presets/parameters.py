"""The one parameter table: id, unit, range, default and a sentence for everything a person sets.

Files, command line, page, engine and tests all read this table, so none of them can disagree.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from overview_dsp.errors import InputError

Value = float | bool | str

MAX_KINDS = 32
MAX_MODES = 6
"""Event kinds of a preset and modes of a kind: what the engine has room for."""

MAX_POINTS = 256
MAX_ALSO = 64
"""Points of a kind's own course."""

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60


@dataclass(frozen=True)
class Parameter:
    """One thing a person sets.

    `choices` is empty for numbers; a flag's choices are False and True. `surface` marks what is
    part of the friction table: changing it makes a new surface.
    """

    id: str
    default: Value | None
    low: float = 0.0
    high: float = 0.0
    unit: str = ""
    doc: str = ""
    choices: tuple[Value, ...] = ()
    scale: Literal["linear", "log"] = "linear"
    surface: bool = False

    @property
    def key(self) -> str:
        """The last part of the id: the key in a preset file's section."""
        return self.id.rpartition(".")[2]

    @property
    def allowed(self) -> str:
        """What a value may be, in words."""
        if self.choices:
            return " or ".join(
                str(choice).lower() if isinstance(choice, bool) else f'"{choice}"'
                for choice in self.choices
            )
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.low:g} to {self.high:g}{unit}"

    def check(self, value: object) -> Value:
        """The value in the parameter's own type.

        Raises
        ------
        InputError
            Wrong type, not a number, or outside the range; nothing is clamped.
        """
        if self.choices:
            if not isinstance(value, bool | str) or (
                isinstance(self.choices[0], bool) != isinstance(value, bool)
                or value not in self.choices
            ):
                raise InputError(f"{self.id} = {shown(value)} is not allowed; it is {self.allowed}")
            return value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{self.id} = {shown(value)} is not a number; it is {self.allowed}")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf if value > 0 else -math.inf
        # written so that NaN fails
        if not self.low <= number <= self.high:
            raise InputError(f"{self.id} = {number:g} is out of range; it is {self.allowed}")
        return number


def _number(
    id: str,
    default: float | None,
    low: float,
    high: float,
    unit: str,
    doc: str,
    scale: Literal["linear", "log"] = "linear",
    surface: bool = False,
) -> Parameter:
    return Parameter(id, default, low, high, unit, doc, (), scale, surface)


def _flag(id: str, doc: str) -> Parameter:
    return Parameter(id, False, 0.0, 1.0, "", doc, (False, True))


PATTERNS = ("none", "waves", "ridges", "teeth", "grains")
SURFACE_MODELS = ("viscous", "bristle", "detent")
KIND_MODELS = ("viscous", "bristle", "detent", "end_stop")
MATERIALS = ("none", "glass", "wood", "metal", "plastic", "card")


def _material(section: str, doc: str) -> tuple[Parameter, ...]:
    """What is struck: of the bare surface, or of an event kind."""
    return (
        Parameter(section + "material", "none", doc=doc, choices=MATERIALS, surface=True),
        _number(
            section + "pitch_hz",
            800.0,
            40.0,
            8000.0,
            "Hz",
            "Lowest mode of the material: higher is smaller.",
            "log",
            surface=True,
        ),
        _number(
            section + "ring",
            1.0,
            0.01,
            1.0,
            "x",
            "How long the material rings, of what it does hung free: 0.1 is held.",
            "log",
            surface=True,
        ),
    )


def _bristles(section: str, damping: str) -> tuple[Parameter, ...]:
    """What bristles are like: of the bare surface, or of an event kind."""
    return (
        _number(
            section + "stiffness",
            100.0,
            0.1,
            1e6,
            "N·m/rad",
            "Of stuck bristles: more holds the disk closer to where it stopped.",
            "log",
            surface=True,
        ),
        _number(
            section + "damping",
            1e-3,
            0.0,
            1.0,
            "N·m·s/rad",
            damping,
            surface=True,
        ),
        _number(
            section + "static_ratio",
            2.0,
            1.0,
            20.0,
            "x",
            "Torque that breaks the disk loose over the torque that goes on braking it: more creaks"
            " more, 1 slides.",
            surface=True,
        ),
        _number(
            section + "stribeck_speed",
            0.3,
            0.01,
            20.0,
            "rad/s",
            "Speed by which the breaking torque has fallen to the sliding one: a disk pulled faster"
            " slides.",
            "log",
            surface=True,
        ),
        _number(
            section + "break_away",
            0.7,
            0.05,
            0.95,
            "",
            "Part of the bristles' bend that springs back; beyond it they begin to give way.",
            surface=True,
        ),
    )


PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    {
        parameter.id: parameter
        for parameter in (
            # --- the disk ---------------------------------------------------------------------
            _number(
                "disk.inertia",
                2e-5,
                1e-6,
                1e-2,
                "kg·m²",
                "Moment of inertia of disk 1: more makes it slower, and freer between events.",
                "log",
            ),
            _number(
                "disk.k1",
                1.5e-3,
                1e-5,
                1.0,
                "N·m/rad",
                "Stiffness of shaft 1, to the ground: more makes it recoil faster.",
                "log",
            ),
            _number(
                "disk.k2",
                4.3e-3,
                1e-5,
                10.0,
                "N·m/rad",
                "Stiffness of shaft 2, to the finger: more makes the disk follow more closely.",
                "log",
            ),
            Parameter(
                "disk.release",
                "recoil",
                doc="What letting go does: shaft 2 lets go too and disk 1 recoils, or it stays and "
                "the finger's angle returns to 0.",
                choices=("recoil", "return"),
            ),
            _number(
                "input.smoothing_ms",
                4.0,
                0.5,
                50.0,
                "ms",
                "Time constant of each of the input smoother's two poles; its latency is twice it.",
                "log",
            ),
            Parameter(
                "twist.release",
                "either",
                doc="What lets go of the disk where a device has no touch sensor: being back at "
                "rest, a tap-tap on it, or either.",
                choices=("rest", "tap", "either"),
            ),
            _number(
                "twist.rest_deg",
                4.0,
                0.5,
                60.0,
                "deg",
                "Within this of face up the device is at rest.",
            ),
            _number(
                "twist.turn_deg",
                6.0,
                0.5,
                60.0,
                "deg",
                "Turned so far beyond that it takes hold.",
            ),
            _number(
                "twist.rest_ms",
                200.0,
                0.0,
                5000.0,
                "ms",
                "How long it must be at rest to let go.",
            ),
            _number(
                "twist.join_ms",
                150.0,
                0.0,
                2000.0,
                "ms",
                "How long theta2 takes from where the disk is to the device's own angle.",
            ),
            # --- the surface ------------------------------------------------------------------
            _number(
                "surface.friction",
                3.1e-4,
                1e-6,
                1e-1,
                "N·m·s/rad",
                "Friction of the bare surface (the paper's B where nothing happens).",
                "log",
                surface=True,
            ),
            _number(
                "surface.ambience",
                0.6,
                0.0,
                20.0,
                "x",
                "Friction added where the intensity curve is at its top, in bare surfaces.",
                surface=True,
            ),
            Parameter(
                "surface.pattern",
                "none",
                doc="What the bare surface is made of: flat, or waves, ridges, teeth, grains.",
                choices=PATTERNS,
                surface=True,
            ),
            _number(
                "surface.pattern_height",
                1.0,
                0.0,
                100.0,
                "x",
                "Friction that the pattern adds at its top, in bare surfaces.",
                surface=True,
            ),
            _number(
                "surface.pattern_period_percent",
                2.0,
                0.05,
                50.0,
                "%",
                "From one ridge of the pattern to the next, of the surface.",
                "log",
                surface=True,
            ),
            Parameter(
                "surface.model",
                "viscous",
                doc="What the bare surface is besides viscous friction (which grows with speed): "
                "bristles that stick, break loose and slide, or detents, wells the disk clicks "
                "into, where the pattern has its troughs.",
                choices=SURFACE_MODELS,
                surface=True,
            ),
            _number(
                "surface.grip",
                3.0,
                0.0,
                10_000.0,
                "x",
                "Sliding torque of the bristles, in what the viscous surface (with ambience and "
                "pattern) has at 1 rad/s; or the detents' greatest pull (with ambience).",
                surface=True,
            ),
            *_bristles(
                "surface.", "Of bristles that are being bent: more calms the disk where it sticks."
            ),
            *_material(
                "surface.",
                "What the bare surface sounds like, struck at crests, in troughs, by slips and "
                "at the ends; none is silent.",
            ),
            _number(
                "surface.end_stiffness",
                0.0,
                0.0,
                1000.0,
                "N·m/rad",
                "Of the stops at both ends, which an overshooting disk meets; 0 is no stop.",
                surface=True,
            ),
            _number(
                "surface.end_damping",
                0.01,
                0.0,
                1.0,
                "N·m·s/rad",
                "Of the stops at both ends: more makes the disk bounce less.",
                surface=True,
            ),
            _number(
                "surface.gain_db",
                0.0,
                -60.0,
                12.0,
                "dB",
                "Level of the bare surface's own clicks.",
                surface=True,
            ),
            _number(
                "surface.gap_height",
                1.8,
                0.3,
                20.0,
                "x",
                "Friction of the ribs where data is missing, in bare surfaces; their grooves have "
                "a tenth of one.",
                surface=True,
            ),
            _number(
                "surface.gap_period_percent",
                2.0,
                0.2,
                10.0,
                "%",
                "From rib to rib where data is missing, of the surface: the same feel at any zoom.",
                surface=True,
            ),
            # --- the tactor -------------------------------------------------------------------
            _number(
                "tactor.frequency_hz",
                250.0,
                40.0,
                1000.0,
                "Hz",
                "Carrier frequency of the vibration; a C2 tactor's resonance is at 250 Hz.",
                "log",
            ),
            _number("tactor.gain_db", 0.0, -60.0, 12.0, "dB", "Level of the vibration."),
            _flag("tactor.mute", "Silences the vibration."),
            _number(
                "tactor.full_torque_mnm",
                90.0,
                0.1,
                10_000.0,
                "mN·m",
                "Torque that is felt as full vibration.",
                "log",
            ),
            _number(
                "tactor.compression",
                0.72,
                0.3,
                1.0,
                "",
                "Exponent from torque to amplitude: 1 is faithful, less brings weak torque nearer.",
            ),
            _number(
                "tactor.threshold_db",
                -80.0,
                -140.0,
                -30.0,
                "dB",
                "Torque below which nothing vibrates, against the full torque.",
            ),
            _number(
                "tactor.rise_ms",
                1.8,
                0.2,
                20.0,
                "ms",
                "Time constant of each of the two poles that round the vibration's edges.",
                "log",
            ),
            _number(
                "tactor.decay_ms",
                9.0,
                1.0,
                200.0,
                "ms",
                "Time constant with which a spike of torque dies away on the skin.",
                "log",
            ),
            # --- the clicks -------------------------------------------------------------------
            _number("click.gain_db", -4.0, -60.0, 12.0, "dB", "Level of the clicks and texture."),
            _flag("click.mute", "Silences the clicks and texture."),
            _number(
                "click.full_torque_mnm",
                90.0,
                0.1,
                10_000.0,
                "mN·m",
                "Torque released by an event that is heard as a full strike (6 dB below the top).",
                "log",
            ),
            _number(
                "click.compression",
                0.5,
                0.3,
                1.0,
                "",
                "Exponent from released torque to the strike's amplitude.",
            ),
            _number(
                "texture.gain_db",
                -50.0,
                -90.0,
                12.0,
                "dB",
                "Level of the surface's grain at a friction power of 1 mW.",
            ),
            _number(
                "texture.brightness_hz",
                1500.0,
                50.0,
                20_000.0,
                "Hz",
                "Cutoff of the grain at 1 rad/s of disk 1; it follows the speed.",
                "log",
            ),
            # --- the output -------------------------------------------------------------------
            _number(
                "output.ceiling_db",
                -1.0,
                -40.0,
                -1.0,
                "dBFS",
                "Level that no peak passes, on either channel.",
            ),
        )
    }
)
"""Every parameter of a preset that is not an event kind's, by id."""

SHAPES = ("gaussian", "raised_cosine", "ramp_up", "ramp_down", "plateau")

KIND_PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    {
        parameter.id: parameter
        for parameter in (
            _number(
                "height",
                4.0,
                0.0,
                1000.0,
                "x",
                "Friction at the event's top, in bare surfaces.",
                surface=True,
            ),
            _number(
                "width_percent",
                None,
                0.03,
                20.0,
                "%",
                "Width at half height, of the whole timeline: the same feel at any zoom.",
                "log",
                surface=True,
            ),
            _number(
                "width_ms",
                None,
                1.0,
                1e12,
                "ms",
                "Width at half height, in the data's own time: it grows as the hand zooms in.",
                "log",
                surface=True,
            ),
            Parameter(
                "shape",
                "gaussian",
                doc="The friction's course over the event.",
                choices=SHAPES,
                surface=True,
            ),
            _number(
                "spacing_percent",
                0.0,
                0.0,
                100.0,
                "%",
                "Mean distance the kind's events need: denser ones are left out until a zoom "
                "spreads them.",
                surface=True,
            ),
            _number("gain_db", 0.0, -60.0, 12.0, "dB", "Level of the kind's click.", surface=True),
            Parameter(
                "model",
                "viscous",
                doc="What the height is: viscous friction, or as much torque as that has at 1 "
                "rad/s: the sliding torque of bristles that stick and break loose, the greatest "
                "pull of a detent (a well the disk clicks into), or of an end stop (a spring over "
                "one width before the event, which lets go there and holds from behind).",
                choices=KIND_MODELS,
                surface=True,
            ),
            *_bristles(
                "",
                "Of bristles that are being bent, or of an end stop: more calms the disk there.",
            ),
            *_material(
                "",
                "What the click sounds like, where no modes are given (modes = [] drops those of a "
                "preset it extends).",
            ),
        )
    }
)
"""An event kind's parameters, by key."""

MODE_PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    {
        parameter.id: parameter
        for parameter in (
            _number(
                "frequency_hz", None, 20.0, 20_000.0, "Hz", "Frequency of the mode.", "log", True
            ),
            _number("decay_ms", None, 1.0, 5000.0, "ms", "Time to fall by 60 dB.", "log", True),
            _number("gain_db", 0.0, -60.0, 0.0, "dB", "Level of the mode.", surface=True),
        )
    }
)
"""A modal resonator's parameters, by key."""


def parameter(id: str) -> Parameter:
    """The parameter with that id; InputError with the nearest name if there is none."""
    found = PARAMETERS.get(id)
    if found is None:
        raise InputError(f"no parameter is called {id!r}{did_you_mean(id, PARAMETERS)}")
    return found


def did_you_mean(name: str, known: Mapping[str, object] | tuple[str, ...]) -> str:
    """A hint with the nearest known name, or all of them when they are few."""
    import difflib

    near = difflib.get_close_matches(name, list(known), 1, 0.6)
    if near:
        return f"; did you mean {near[0]!r}?"
    names = list(known)
    return f"; known: {', '.join(names)}" if len(names) <= 16 else ""


def shown(value: object) -> str:
    """A value as an error line shows it: short, on one line, whatever it is."""
    try:
        return _SHORT.repr(value)
    except (ValueError, RecursionError):  # an int of thousands of digits, a bottomless list
        return f"a {type(value).__name__} too large to show"


def is_close_default(parameter: Parameter, value: Value) -> bool:
    """Whether a value is the parameter's default, to rounding."""
    if isinstance(parameter.default, float) and isinstance(value, float):
        return math.isclose(parameter.default, value, rel_tol=1e-12, abs_tol=0.0)
    return parameter.default == value
