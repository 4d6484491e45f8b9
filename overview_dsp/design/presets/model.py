"""Presets: parameters of surface and sound, and the kinds of events on it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from overview_dsp import validation
from overview_dsp.design.presets.notebook import preset_page
from overview_dsp.design.presets.parameter import Value
from overview_dsp.design.presets.parameters import (
    KIND_PARAMETERS,
    MAX_ALIASES,
    MAX_POINTS,
    MODE_PARAMETERS,
    PARAMETERS,
    parameter,
)
from overview_dsp.errors import InputError
from overview_dsp.kernels.layout import MAX_KINDS, MAX_MODES
from overview_dsp.public import changed_fields, counted, plot_with, short

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DEFAULT_KIND = "default"

ROUTING = "routing"  # key in the metadata of fields that only choose among tactors


def _default(key: str) -> float:
    value = KIND_PARAMETERS[key].default
    assert isinstance(value, float)
    return value


@dataclass(frozen=True)
class ClickMode:
    """A modal resonator of a click.

    Parameters
    ----------
    frequency_hz : float
        Hz, 20 to 20 000.
    decay_ms : float
        Time to fall by 60 dB, ms, 1 to 5000.
    gain_db : float
        Level, dB, -60 to 0.

    Examples
    --------
    >>> ov.ClickMode(1180.0, 45.0, gain_db=-2.0)
    ClickMode(frequency_hz=1180.0, decay_ms=45.0, gain_db=-2.0)
    """

    frequency_hz: float
    decay_ms: float
    gain_db: float = 0.0


@dataclass(frozen=True)
class EventKind:
    """Friction profile and click of one kind of event.

    Exactly one of the two widths must be set. Without `modes`, the click is made from `material`,
    `pitch_hz` and `decay_scale`.

    Parameters
    ----------
    height : float
        Height of the profile, as a multiple of `surface.friction`.
    width_percent : float or None
        Width at half height, % of the timeline.
    width_ms : float or None
        Width at half height, in ms of the data's time.
    shape : str
        Shape of the friction profile.
    points : tuple of float
        Profile of 2 to 256 numbers, 0 to 1, over two widths, which replaces the shape.
    spacing_percent : float
        Smallest mean distance of the kind's events, %; denser ones are omitted until a zoom.
    gain_db : float
        Level of the click, dB.
    modes : tuple of ClickMode
        Resonators of the click.
    aliases : tuple of str
        Names of other event kinds that use this one.
    model : {"viscous", "bristle", "detent", "end_stop"}
        Friction model.
    stiffness, damping, static_ratio, stribeck_speed, break_away : float
        Parameters of bristles or end stop; units and ranges are in `ov.presets.KIND_PARAMETERS`.
    material : {"none", "glass", "wood", "metal", "plastic", "card"}
        Material of the click, without `modes`.
    pitch_hz : float
        Lowest mode of the material, Hz.
    decay_scale : float
        Ratio of the decay times to those of the free material.
    tactor : str
        Number of the tactor, "1" to "8", or "all".

    Raises
    ------
    InputError
        A value is out of range, or not exactly one width is set.

    Examples
    --------
    >>> ov.EventKind(height=40.0, width_percent=0.5, material="wood")
    EventKind(height=40.0, width_percent=0.5, material='wood')
    """

    height: float
    width_percent: float | None = None
    width_ms: float | None = None
    shape: str = "gaussian"
    points: tuple[float, ...] = ()
    spacing_percent: float = 0.0
    gain_db: float = 0.0
    modes: tuple[ClickMode, ...] = ()
    aliases: tuple[str, ...] = ()
    model: str = "viscous"
    stiffness: float = _default("stiffness")
    damping: float = _default("damping")
    static_ratio: float = _default("static_ratio")
    stribeck_speed: float = _default("stribeck_speed")
    break_away: float = _default("break_away")
    material: str = "none"
    pitch_hz: float = _default("pitch_hz")
    decay_scale: float = _default("decay_scale")
    tactor: str = field(default="all", metadata={ROUTING: True})

    def __post_init__(self) -> None:
        if (self.width_percent is None) == (self.width_ms is None):
            raise InputError("exactly one of width_percent and width_ms must be set")
        for key, known in KIND_PARAMETERS.items():
            value = getattr(self, key)
            if value is not None or not key.startswith("width_"):
                object.__setattr__(self, key, known.check(value))
        if len(self.modes) > MAX_MODES:
            raise InputError(f"modes has {len(self.modes)} entries; must be at most {MAX_MODES}")
        for index, mode in enumerate(self.modes):
            for key, known in MODE_PARAMETERS.items():
                replace(known, id=f"modes.{index}.{key}").check(getattr(mode, key))
        object.__setattr__(self, "modes", tuple(self.modes))
        object.__setattr__(self, "aliases", tuple(self.aliases))
        if not all(isinstance(name, str) and name for name in self.aliases):
            raise InputError("aliases must be a list of event kinds")
        if len(self.aliases) > MAX_ALIASES:
            raise InputError(
                f"aliases has {len(self.aliases)} names; must be at most {MAX_ALIASES}"
            )
        object.__setattr__(self, "points", _checked_points(self.points))
        if self.points and not any(self.points):
            raise InputError("points must be 0 to 1, and not all of them 0")

    def __repr__(self) -> str:
        return changed_fields(self, modes=f"<{len(self.modes)}>")


def _checked_points(points: Iterable[float]) -> tuple[float, ...]:
    """Return the points of a profile or an intensity map; InputError if they are not valid."""
    found = tuple(float(point) for point in points)
    if found and not 2 <= len(found) <= MAX_POINTS:
        raise InputError(f"points has {len(found)} numbers; must be 2 to {MAX_POINTS}")
    # NaN fails too
    if not all(0.0 <= point <= 1.0 for point in found):
        raise InputError("points must be 0 to 1")
    return found


TAG_SCALES = ("energy", "roughness", "tempo", "pleasantness")
"""Scales of a preset's feel, 1 to 5 (after VibViz: Seifi, Zhang and MacLean 2015)."""


DATA_TYPES = ("events", "series", "recordings")


@dataclass(frozen=True)
class Tags:
    """Ratings of a preset's feel, 1 (low) to 5 (high) or None, its uses and its data.

    Parameters
    ----------
    energy, roughness, tempo, pleasantness : float or None
        1 to 5.
    usage : tuple of str
        Words for its uses.
    data : tuple of {"events", "series", "recordings"}
        Data for which it is chosen: events of its kinds, curves, or curves of loudness.

    Raises
    ------
    InputError
        A number is out of range, or a type of data is unknown.

    Examples
    --------
    >>> ov.load_preset("football").tags.usage
    ('football', 'matches')
    """

    energy: float | None = None
    roughness: float | None = None
    tempo: float | None = None
    pleasantness: float | None = None
    usage: tuple[str, ...] = ()
    data: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in TAG_SCALES:
            value = getattr(self, name)
            if value is not None and not 1.0 <= value <= 5.0:
                raise InputError(f"tags.{name} = {value:g} is out of range; allowed: 1 to 5")
        object.__setattr__(self, "usage", tuple(self.usage))
        object.__setattr__(self, "data", tuple(self.data))
        for name in self.data:
            if name not in DATA_TYPES:
                raise InputError(f"tags.data has {name!r}; allowed: {', '.join(DATA_TYPES)}")


@dataclass(frozen=True)
class Preset:
    """Immutable named set of parameter values and event kinds.

    Parameters
    ----------
    name, title, description : str
        Name (of its file), title and a sentence on its feel.
    values : mapping of str to float, bool or str
        Values by parameter id; other parameters have their defaults.
    kinds : mapping of str to EventKind
        Event kinds by name, with `default` for all kinds that are not named.
    tags : Tags
        Ratings and uses.
    authors : tuple of str
        Names of the authors.
    points : tuple of float
        Intensity map: felt share, 0 to 1, at 2 to 256 even steps of the intensity curve; default:
        a straight line.

    Raises
    ------
    InputError
        An unknown parameter, a value out of range, too many kinds, or no `default`.

    See Also
    --------
    load_preset : Reads a preset.

    Examples
    --------
    >>> loud = football.with_changes({"surface.friction": 6e-4})
    >>> loud.values["surface.friction"], football == loud
    (0.0006, False)
    """

    name: str
    title: str
    description: str
    values: Mapping[str, Value]
    kinds: Mapping[str, EventKind] = field(default_factory=dict)
    tags: Tags = field(default_factory=Tags)
    authors: tuple[str, ...] = ()
    points: tuple[float, ...] = ()
    _served: Mapping[str, str] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        values: dict[str, Value] = {}
        for id, known in PARAMETERS.items():
            assert known.default is not None
            values[id] = known.default
        for id, value in self.values.items():
            values[id] = parameter(id).check(value)
        if len(self.kinds) > MAX_KINDS:
            raise InputError(
                f"preset {self.name!r} has {len(self.kinds)} event kinds; "
                f"must be at most {MAX_KINDS}"
            )
        if DEFAULT_KIND not in self.kinds:
            raise InputError(
                f"preset {self.name!r} has no kinds.{DEFAULT_KIND}; "
                "add it for events of other kinds"
            )
        object.__setattr__(self, "values", MappingProxyType(values))
        object.__setattr__(self, "kinds", MappingProxyType(dict(self.kinds)))
        object.__setattr__(self, "authors", tuple(self.authors))
        object.__setattr__(self, "points", _checked_points(self.points))
        served = {name: kind for kind, members in self.kinds.items() for name in members.aliases}
        for kind, members in self.kinds.items():
            for name in members.aliases:
                if served[name] != kind:
                    raise InputError(
                        f"preset {self.name!r}: {name!r} is in kinds.{kind}.aliases and in "
                        f"kinds.{served[name]}.aliases; remove one"
                    )
        # a kind of that name has priority over aliases
        object.__setattr__(self, "_served", served | {name: name for name in self.kinds})

    def kind_for(self, event_kind: str) -> str | None:
        """Return the entry of `kinds` that applies to a kind of event.

        Parameters
        ----------
        event_kind : str
            Kind of an event.

        Returns
        -------
        str or None
            Name of an entry; None if only `default` applies.

        Examples
        --------
        >>> football.kind_for("goal"), football.kind_for("heartbeat")
        ('goal', None)
        """
        return self._served.get(event_kind)

    def number(self, id: str) -> float:
        """Look up a numeric parameter.

        Parameters
        ----------
        id : str
            Parameter id, such as `tactor.frequency_hz`.

        Returns
        -------
        float
            Value in the parameter's unit.

        Examples
        --------
        >>> ov.load_preset("football").number("tactor.frequency_hz")
        250.0
        """
        value = self.values[id]
        assert isinstance(value, float)
        return value

    def with_values(self, **changes: Value) -> Preset:
        """Return a copy with other values, by parameter id with `__` for the dot.

        Parameters
        ----------
        **changes : float, bool or str
            Values in the parameters' units.

        Returns
        -------
        Preset
            Copy with these values.

        Raises
        ------
        InputError
            An unknown parameter, or a value that is not allowed.

        Examples
        --------
        >>> football.with_values(tactor__gain_db=-6.0).number("tactor.gain_db")
        -6.0
        """
        return self.with_changes({id.replace("__", "."): value for id, value in changes.items()})

    def with_changes(self, changes: Mapping[str, Value]) -> Preset:
        """Return a copy with other values, by parameter id.

        Parameters
        ----------
        changes : mapping of str to float, bool or str
            Values in the parameters' units.

        Returns
        -------
        Preset
            Copy with these values.

        Raises
        ------
        InputError
            An unknown parameter, or a value that is not allowed.

        Examples
        --------
        >>> football.with_changes({"tactor.gain_db": -6.0}).number("tactor.gain_db")
        -6.0
        """
        return replace(self, values={**self.values, **changes})

    def with_value(self, id: str, value: object) -> Preset:
        """Return a copy with another value of a parameter or of an event kind.

        Parameters
        ----------
        id : str
            Id, such as `tactor.gain_db` or `kinds.goal.height`.
        value : float, bool or str
            In the parameter's unit.

        Returns
        -------
        Preset
            Copy with this value.

        Raises
        ------
        InputError
            An unknown parameter, or a value that is not allowed.

        Examples
        --------
        >>> football.with_value("kinds.goal.height", 90.0).kinds["goal"].height
        90.0
        """
        validation.instance(id, str, "a parameter's id", "tactor.gain_db is one")
        if not id.startswith("kinds."):
            return self.with_changes({id: parameter(id).check(value)})
        parts = id.split(".")
        if len(parts) != 3 or parts[1] not in self.kinds:
            raise InputError(
                f"no parameter is called {id!r}; use kinds.KIND.KEY, "
                f"with KIND one of {', '.join(self.kinds)}"
            )
        _, name, key = parts
        if key not in KIND_PARAMETERS:
            raise InputError(
                f"no parameter is called {id!r}; an event kind has {', '.join(KIND_PARAMETERS)}"
            )
        changes: dict[str, Any] = {key: replace(KIND_PARAMETERS[key], id=id).check(value)}
        if key.startswith("width_"):
            changes = {"width_percent": None, "width_ms": None, **changes}
        return replace(self, kinds={**self.kinds, name: replace(self.kinds[name], **changes)})

    def plot(self) -> Figure:
        """Plot click and vibration of each kind of event in a rendered sweep.

        Returns
        -------
        matplotlib.figure.Figure
            Click and vibration over time.

        Examples
        --------
        >>> ov.load_preset("plain").plot().savefig("plain.png")
        """
        return plot_with("measure.pictures", "plot_preset", self)

    def _repr_html_(self) -> str:
        """Return HTML with the description and the kinds, for notebooks."""
        return preset_page(self)

    def __reduce__(self) -> tuple[Any, ...]:
        # a mappingproxy can't be pickled
        values = (getattr(self, one.name) for one in fields(self) if one.init)
        return Preset, tuple(dict(one) if isinstance(one, Mapping) else one for one in values)

    def __repr__(self) -> str:
        changed = sum(value != PARAMETERS[id].default for id, value in self.values.items())
        return (
            f"<Preset {short(self.name)}: {counted(len(self.kinds), 'kind')}, "
            f"{counted(changed, 'value')} other than the default>"
        )
