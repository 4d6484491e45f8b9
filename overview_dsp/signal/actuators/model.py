"""An actuator: its resonance, what it may be given, and how it is to be driven.

Everything a file may say stands in `parameters.toml`, as with presets.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from overview_dsp.design.presets.parameter import Parameter, Value, read_parameters
from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.public import short

MAX_CALIBRATION_DB = 30.0
LN_9 = 2.1972245773362196  # from 10 to 90 % of an exponential rise, in time constants

ACTUATOR_PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    read_parameters(Path(__file__).with_name("parameters.toml"))
)
"""Everything a profile may say, by id."""

_Q = ACTUATOR_PARAMETERS["resonance.q"]
LOWEST_Q = _Q.low

ONE_OF = ("resonance.q", "resonance.bandwidth_hz", "resonance.rise_ms")
_OPTIONAL = (*ONE_OF, "drive.full_scale")


@dataclass(frozen=True)
class Actuator:
    """What a device can do and may be given.

    Parameters
    ----------
    name, title, description : str
        What it is called (its file's name), in a few words, and what it is.
    values : mapping of str to float, bool or str
        By id, those of `ov.actuators.PARAMETERS` that are said; what is left out gets its default.
    source : str
        Its file.
    gain_db : float
        Of its calibration for a person, -30 to 30 dB.

    Raises
    ------
    InputError
        A value that can't be, or not with another; the line begins with the key.

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
        """InputError, which begins with the key, for a value that can't be, or not with another."""
        object.__setattr__(self, "values", _checked(self.values))
        given = [id for id in ONE_OF if id in self.values]
        if len(given) != 1:
            what = "more than one" if given else "none"
            raise InputError(
                f"resonance.frequency_hz: give one of {', '.join(ONE_OF)} with it, not {what}"
            )
        if not LOWEST_Q <= self.q <= _Q.high:
            raise InputError(
                f"{given[0]} = {self.number(given[0]):g} makes a q of {self.q:.3g} at "
                f"{self.resonance_hz:g} Hz; it is {_Q.allowed}"
            )
        if self.number("drive.peak") < self.number("drive.rated_rms"):
            raise InputError("drive.peak is below drive.rated_rms; it is the larger of the two")
        if not abs(self.gain_db) <= MAX_CALIBRATION_DB:
            raise InputError(
                f"calibration {self.gain_db:g} dB is out of range; it is "
                f"-{MAX_CALIBRATION_DB:g} to {MAX_CALIBRATION_DB:g} dB"
            )

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
        """Where it moves most, Hz."""
        return self.number("resonance.frequency_hz")

    @property
    def q(self) -> float:
        """Quality of the resonance, however it was given."""
        if "resonance.q" in self.values:
            return self.number("resonance.q")
        if "resonance.bandwidth_hz" in self.values:
            return self.resonance_hz / self.number("resonance.bandwidth_hz")
        return math.pi * self.resonance_hz * self.number("resonance.rise_ms") * 1e-3 / LN_9

    @property
    def rise_ms(self) -> float:
        """10 to 90 % rise of its vibration when a tone of its resonance begins, ms."""
        return 1e3 * LN_9 * self.q / (math.pi * self.resonance_hz)

    @property
    def full_scale(self) -> float:
        """What a sample of 1 puts on it, in the drive's unit."""
        given = self.values.get("drive.full_scale")
        return float(given) if isinstance(given, float) else self.number("drive.peak")

    @property
    def peak(self) -> float:
        """The highest sample it may be given, of full scale; at most 1."""
        return min(1.0, self.number("drive.peak") / self.full_scale)

    @property
    def nominal(self) -> float:
        """Amplitude of a tone of the rated drive, of full scale; at most the peak."""
        return min(self.peak, math.sqrt(2.0) * self.number("drive.rated_rms") / self.full_scale)

    @property
    def mean_square(self) -> float:
        """What the mean square of the drive may not pass over `window_s`, of full scale squared."""
        rated = self.number("drive.rated_rms") / self.full_scale
        return min(1.0, self.number("drive.duty") * rated * rated)

    @property
    def window_s(self) -> float:
        """Over how long that mean is taken, s."""
        return self.number("drive.burst_ms") * 1e-3 / self.number("drive.duty")

    @property
    def unshaped(self) -> Actuator:
        """The same, driven as it is: not sharpened, not weighted, not calibrated."""
        plain = {"shaping.sharpen": 1.0, "shaping.equal_sensation": False}
        return replace(self, values={**self.values, **plain}, gain_db=0.0)

    def response_db(self, frequency_hz: float) -> float:
        """Find out how much it moves at a frequency.

        Parameters
        ----------
        frequency_hz : float
            Hz.

        Returns
        -------
        float
            In dB of what it does at its resonance.

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


def _checked(given: Mapping[str, object]) -> dict[str, Value]:
    for id in given:
        if id not in ACTUATOR_PARAMETERS:
            raise InputError(f"{id}: unknown key{did_you_mean(id, ACTUATOR_PARAMETERS)}")
    values: dict[str, Value] = {}
    for known in ACTUATOR_PARAMETERS.values():
        if known.id in given:
            values[known.id] = known.check(given[known.id])
        elif known.default is not None:
            values[known.id] = known.default
        elif known.id not in _OPTIONAL:
            raise InputError(f"{known.id} is missing; it is {known.allowed}")
    return values
