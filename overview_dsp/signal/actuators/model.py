"""Actuator model: resonance, limits of the drive, and shaping.

`parameters.toml` defines all keys of a profile, as for presets.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from overview_dsp import validation
from overview_dsp.design.presets.parameter import Parameter, Value, read_parameters
from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.public import short

MAX_CALIBRATION_DB = 30.0
LN_9 = 2.1972245773362196  # from 10 to 90 % of an exponential rise, in time constants

ACTUATOR_PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    read_parameters(Path(__file__).with_name("parameters.toml"))
)
"""All parameters of a profile, by id."""

_Q = ACTUATOR_PARAMETERS["resonance.q"]
LOWEST_Q = _Q.low
LOWEST_DRIVEN_Q = 1.5  # of overdrive: with a lower one, the motion overshoots more than without

ONE_OF = ("resonance.q", "resonance.bandwidth_hz", "resonance.rise_ms")
_OPTIONAL = (*ONE_OF, "drive.full_scale")


@dataclass(frozen=True)
class Actuator:
    """Resonance and drive limits of an output device.

    Parameters
    ----------
    name, title, description : str
        Name (that of its file), short title and a description.
    values : mapping of str to float, bool or str
        Values of `ov.actuators.PARAMETERS` by id. Missing values get their defaults.
    source : str
        Path of its file.
    gain_db : float
        Gain of the user's calibration, -30 to 30 dB.

    Raises
    ------
    InputError
        A value is out of range or contradicts another; the message begins with the key.

    See Also
    --------
    load_actuator : Reads one.

    Examples
    --------
    >>> c2 = ov.actuators.load("c2")
    >>> c2.peak <= 1.0
    True
    """

    name: str
    title: str
    description: str
    values: Mapping[str, Value]
    source: str = ""
    gain_db: float = 0.0

    def __post_init__(self) -> None:
        """Validate the values; the message of an InputError begins with the key."""
        object.__setattr__(self, "values", _checked(self.values))
        width = [id for id in ONE_OF if id in self.values]
        if len(width) != 1:
            what = "more than one" if width else "none"
            raise InputError(
                f"resonance.frequency_hz: give one of {', '.join(ONE_OF)} with it, not {what}"
            )
        if not LOWEST_Q <= self.q <= _Q.high:
            raise InputError(
                f"{width[0]} = {self.number(width[0]):g} gives a q of {self.q:.3g} at "
                f"{self.resonance_hz:g} Hz; allowed: {_Q.allowed}"
            )
        if self.number("drive.peak") < self.number("drive.rated_rms"):
            raise InputError("drive.peak is below drive.rated_rms; must be at least as large")
        limit = MAX_CALIBRATION_DB
        validation.within(self.gain_db, "gain_db", -limit, limit, " dB")

    def number(self, id: str) -> float:
        """Look up a numeric value.

        Parameters
        ----------
        id : str
            `resonance.frequency_hz`, say.

        Returns
        -------
        float
            In the parameter's unit.

        Examples
        --------
        >>> c2 = ov.actuators.load("c2")
        >>> c2.number("resonance.frequency_hz")
        250.0
        """
        value = self.values[id]
        assert not isinstance(value, str)
        return float(value)

    @property
    def resonance_hz(self) -> float:
        """Resonance frequency, Hz."""
        return self.number("resonance.frequency_hz")

    @property
    def q(self) -> float:
        """Q of the resonance, from `q`, `bandwidth_hz` or `rise_ms`."""
        if "resonance.q" in self.values:
            return self.number("resonance.q")
        if "resonance.bandwidth_hz" in self.values:
            return self.resonance_hz / self.number("resonance.bandwidth_hz")
        return math.pi * self.resonance_hz * self.number("resonance.rise_ms") * 1e-3 / LN_9

    @property
    def overdrive_q(self) -> float:
        """Q of the motion with overdrive; `q` if the resonance isn't known well enough for it."""
        if self.number("resonance.tolerance_percent") > error_limit(self.q):
            return self.q
        return max(min(self.q, LOWEST_DRIVEN_Q), self.q / self.number("shaping.overdrive"))

    @property
    def rise_ms(self) -> float:
        """10 to 90 % rise time of the vibration for a tone at the resonance, ms."""
        return 1e3 * LN_9 * self.q / (math.pi * self.resonance_hz)

    @property
    def full_scale(self) -> float:
        """Drive of a sample of 1, in the drive's unit."""
        full_scale = self.values.get("drive.full_scale")
        return full_scale if isinstance(full_scale, float) else self.number("drive.peak")

    @property
    def peak(self) -> float:
        """Highest allowed sample, relative to full scale; at most 1."""
        return min(1.0, self.number("drive.peak") / self.full_scale)

    @property
    def nominal(self) -> float:
        """Amplitude of a tone at the rated drive, relative to full scale; at most the peak."""
        return min(self.peak, math.sqrt(2.0) * self.number("drive.rated_rms") / self.full_scale)

    @property
    def mean_square(self) -> float:
        """Limit of the drive's mean square over `window_s`, relative to full scale squared."""
        rated = self.number("drive.rated_rms") / self.full_scale
        return min(1.0, self.number("drive.duty") * rated * rated)

    @property
    def window_s(self) -> float:
        """Averaging time of the mean square, s."""
        return self.number("drive.burst_ms") * 1e-3 / self.number("drive.duty")

    @property
    def unshaped(self) -> Actuator:
        """Copy without overdrive, perceptual weighting and calibration."""
        plain = {"shaping.overdrive": 1.0, "shaping.perceptual_weighting": False}
        return replace(self, values={**self.values, **plain}, gain_db=0.0)

    def response_db(self, frequency_hz: float) -> float:
        """Return the motion at a frequency, relative to the resonance.

        Parameters
        ----------
        frequency_hz : float
            Hz.

        Returns
        -------
        float
            Level relative to that at the resonance, dB.

        Examples
        --------
        >>> c2 = ov.actuators.load("c2")
        >>> c2.response_db(250.0) == 0.0, c2.response_db(125.0) < -10.0
        (True, True)
        """
        u = frequency_hz / self.resonance_hz
        return -10.0 * math.log10((self.q * (1.0 - u * u)) ** 2 + u * u)

    def __repr__(self) -> str:
        return (
            f"<Actuator {short(self.name)}: {short(self.title)}, {self.resonance_hz:g} Hz, "
            f"Q {self.q:.3g}>"
        )


def _checked(values: Mapping[str, object]) -> dict[str, Value]:
    for id in values:
        if id not in ACTUATOR_PARAMETERS:
            raise InputError(f"{id}: unknown key{did_you_mean(id, ACTUATOR_PARAMETERS)}")
    complete: dict[str, Value] = {}
    for known in ACTUATOR_PARAMETERS.values():
        if known.id in values:
            complete[known.id] = known.check(values[known.id])
        elif known.default is not None:
            complete[known.id] = known.default
        elif known.id not in _OPTIONAL:
            raise InputError(f"{known.id} is missing; allowed: {known.allowed}")
    return complete


def error_limit(q: float) -> float:
    """Return the largest error of a resonance with which overdrive is never worse than none, %.

    It is a tenth of the bandwidth. With a larger error, the motion overshoots more (measured).
    """
    return 10.0 / q


BEST_HZ = (200.0, 300.0)  # range of the skin's highest sensitivity to vibration, Hz
DB_PER_OCTAVE = 10.0


def pacinian_db(frequency_hz: float) -> float:
    """Return the skin's sensitivity at a frequency relative to 200 to 300 Hz, dB <= 0.

    It falls by 20 dB from 200 to 50 Hz (equal-sensation filter of Google's audio-to-tactile). The
    same slope is assumed above 300 Hz. Thresholds are lowest at 150 to 300 Hz (Brisben, Hsiao,
    Johnson 1999).
    """
    low, high = BEST_HZ
    beyond = max(math.log2(low / frequency_hz), math.log2(frequency_hz / high), 0.0)
    return -DB_PER_OCTAVE * beyond
