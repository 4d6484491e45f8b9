"""The one parameter table: id, unit, range, default and a sentence for everything a person sets.

Files, command line, page, engine and tests all read this table, so none of them can disagree.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.presets.parameter import Parameter, flag, number

MAX_POINTS = 256
"""Points of a kind's own course."""

MAX_ALSO = 64
"""Other kinds that are felt as one."""

PATTERNS = ("none", "waves", "ridges", "teeth", "grains")
SURFACE_MODELS = ("viscous", "bristle", "detent")
KIND_MODELS = ("viscous", "bristle", "detent", "end_stop")
MATERIALS = ("none", "glass", "wood", "metal", "plastic", "card")


def _material(section: str, doc: str) -> tuple[Parameter, ...]:
    """What is struck: of the bare surface, or of an event kind."""
    return (
        Parameter(section + "material", "none", doc=doc, choices=MATERIALS, surface=True),
        number(
            section + "pitch_hz",
            800.0,
            40.0,
            8000.0,
            "Hz",
            "Lowest mode of the material: higher is smaller.",
            "log",
            surface=True,
        ),
        number(
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
        number(
            section + "stiffness",
            100.0,
            0.1,
            1e6,
            "N·m/rad",
            "Of stuck bristles: more holds the disk closer to where it stopped.",
            "log",
            surface=True,
        ),
        number(
            section + "damping",
            1e-3,
            0.0,
            1.0,
            "N·m·s/rad",
            damping,
            surface=True,
        ),
        number(
            section + "static_ratio",
            2.0,
            1.0,
            20.0,
            "x",
            "Torque that breaks the disk loose over the torque that goes on braking it: more creaks"
            " more, 1 slides.",
            surface=True,
        ),
        number(
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
        number(
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
            number(
                "disk.inertia",
                2e-5,
                1e-6,
                1e-2,
                "kg·m²",
                "Moment of inertia of disk 1: more makes it slower, and freer between events.",
                "log",
            ),
            number(
                "disk.k1",
                1.5e-3,
                1e-5,
                1.0,
                "N·m/rad",
                "Stiffness of shaft 1, to the ground: more makes it recoil faster.",
                "log",
            ),
            number(
                "disk.k2",
                4.3e-3,
                1e-5,
                10.0,
                "N·m/rad",
                "Stiffness of shaft 2, to the finger: more makes the disk follow more closely.",
                "log",
            ),
            number(
                "disk.catch_up",
                0.0,
                0.0,
                10.0,
                "x",
                "Slip clutch: how fast the disk may follow, of the hand's own pace, where an event "
                "held it back; 0 = a rigid shaft, which throws it.",
            ),
            number(
                "disk.unfold_s",
                0.0,
                0.0,
                10.0,
                "s",
                "Slip clutch: how long a tap takes to run over the whole timeline; 0 = at once.",
            ),
            Parameter(
                "disk.release",
                "recoil",
                doc="What letting go does: shaft 2 lets go too and disk 1 recoils, or it stays and "
                "the finger's angle returns to 0.",
                choices=("recoil", "return"),
            ),
            number(
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
            number(
                "twist.rest_deg",
                4.0,
                0.5,
                60.0,
                "deg",
                "Within this of face up the device is at rest.",
            ),
            number(
                "twist.turn_deg",
                6.0,
                0.5,
                60.0,
                "deg",
                "Turned so far beyond that it takes hold.",
            ),
            number(
                "twist.rest_ms",
                200.0,
                0.0,
                5000.0,
                "ms",
                "How long it must be at rest to let go.",
            ),
            number(
                "twist.join_ms",
                150.0,
                0.0,
                2000.0,
                "ms",
                "How long theta2 takes from where the disk is to the device's own angle.",
            ),
            # --- the surface ------------------------------------------------------------------
            number(
                "surface.friction",
                3.1e-4,
                1e-6,
                1e-1,
                "N·m·s/rad",
                "Friction of the bare surface (the paper's B where nothing happens).",
                "log",
                surface=True,
            ),
            number(
                "surface.ambience",
                0.6,
                0.0,
                20.0,
                "x",
                "Friction added where the intensity curve is at its top, in bare surfaces; equal "
                "steps of the curve on the way there are equal ratios of friction.",
                surface=True,
            ),
            Parameter(
                "surface.pattern",
                "none",
                doc="What the bare surface is made of: flat, or waves, ridges, teeth, grains.",
                choices=PATTERNS,
                surface=True,
            ),
            number(
                "surface.pattern_height",
                1.0,
                0.0,
                100.0,
                "x",
                "Friction that the pattern adds at its top, in bare surfaces.",
                surface=True,
            ),
            number(
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
                "bristles that stick, break loose and slide, or detents, detents the disk clicks "
                "into, where the pattern has its troughs.",
                choices=SURFACE_MODELS,
                surface=True,
            ),
            number(
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
            number(
                "surface.end_stiffness",
                0.0,
                0.0,
                1000.0,
                "N·m/rad",
                "Of the stops at both ends, which an overshooting disk meets; 0 is no stop.",
                surface=True,
            ),
            number(
                "surface.end_damping",
                0.01,
                0.0,
                1.0,
                "N·m·s/rad",
                "Of the stops at both ends: more makes the disk bounce less.",
                surface=True,
            ),
            number(
                "surface.gain_db",
                0.0,
                -60.0,
                12.0,
                "dB",
                "Level of the bare surface's own clicks.",
                surface=True,
            ),
            number(
                "surface.gap_height",
                1.8,
                0.3,
                20.0,
                "x",
                "Friction of the ribs where data is missing, in bare surfaces; their grooves have "
                "a tenth of one.",
                surface=True,
            ),
            number(
                "surface.gap_period_percent",
                2.0,
                0.2,
                10.0,
                "%",
                "From rib to rib where data is missing, of the surface: the same feel at any zoom.",
                surface=True,
            ),
            # --- the tactor -------------------------------------------------------------------
            number(
                "tactor.frequency_hz",
                250.0,
                40.0,
                1000.0,
                "Hz",
                "Carrier frequency of the vibration; a C2 tactor's resonance is at 250 Hz.",
                "log",
            ),
            number("tactor.gain_db", 0.0, -60.0, 12.0, "dB", "Level of the vibration."),
            flag("tactor.mute", "Silences the vibration."),
            number(
                "tactor.full_torque_mnm",
                90.0,
                0.1,
                10_000.0,
                "mN·m",
                "Torque that is felt as full vibration.",
                "log",
            ),
            number(
                "tactor.compression",
                0.72,
                0.3,
                1.0,
                "",
                "Exponent from torque to amplitude: 1 is faithful, less brings weak torque nearer.",
            ),
            number(
                "tactor.threshold_db",
                -80.0,
                -140.0,
                -30.0,
                "dB",
                "Torque below which nothing vibrates, against the full torque.",
            ),
            number(
                "tactor.rise_ms",
                1.8,
                0.2,
                20.0,
                "ms",
                "Time constant of each of the two poles that round the vibration's edges.",
                "log",
            ),
            number(
                "tactor.decay_ms",
                9.0,
                1.0,
                200.0,
                "ms",
                "Time constant with which a spike of torque dies away on the skin.",
                "log",
            ),
            # --- the clicks -------------------------------------------------------------------
            number("click.gain_db", -4.0, -60.0, 12.0, "dB", "Level of the clicks and texture."),
            flag("click.mute", "Silences the clicks and texture."),
            number(
                "click.full_torque_mnm",
                90.0,
                0.1,
                10_000.0,
                "mN·m",
                "Torque released by an event that is heard as a full strike (6 dB below the top).",
                "log",
            ),
            number(
                "click.compression",
                0.5,
                0.3,
                1.0,
                "",
                "Exponent from released torque to the strike's amplitude.",
            ),
            number(
                "texture.gain_db",
                -50.0,
                -90.0,
                12.0,
                "dB",
                "Level of the surface's grain at a friction power of 1 mW.",
            ),
            number(
                "texture.brightness_hz",
                1500.0,
                50.0,
                20_000.0,
                "Hz",
                "Cutoff of the grain at 1 rad/s of disk 1; it follows the speed.",
                "log",
            ),
            # --- the output -------------------------------------------------------------------
            number(
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
            number(
                "height",
                4.0,
                0.0,
                1000.0,
                "x",
                "Friction at the event's top, in bare surfaces.",
                surface=True,
            ),
            number(
                "width_percent",
                None,
                0.01,
                20.0,
                "%",
                "Width at half height, of the whole timeline: the same feel at any zoom.",
                "log",
                surface=True,
            ),
            number(
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
            number(
                "spacing_percent",
                0.0,
                0.0,
                100.0,
                "%",
                "Mean distance the kind's events need: denser ones are left out until a zoom "
                "spreads them.",
                surface=True,
            ),
            number("gain_db", 0.0, -60.0, 12.0, "dB", "Level of the kind's click.", surface=True),
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
            number(
                "frequency_hz", None, 20.0, 20_000.0, "Hz", "Frequency of the mode.", "log", True
            ),
            number("decay_ms", None, 1.0, 5000.0, "ms", "Time to fall by 60 dB.", "log", True),
            number("gain_db", 0.0, -60.0, 0.0, "dB", "Level of the mode.", surface=True),
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
