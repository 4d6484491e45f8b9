"""Every public name: what the reference shows, found by the faces' `__all__`."""

from __future__ import annotations

import functools
import inspect

import overview_dsp as ov

FACES = {
    "overview_dsp": ov,
    **{
        f"overview_dsp.{name}": getattr(ov, name)
        for name in ("actuators", "export", "live", "measure", "presets")
    },
}


def public_objects():
    """Functions and classes by the name a program uses (`ov.presets.morph`), each once."""
    found = {}
    for prefix, face in FACES.items():
        for name in face.__all__:
            value = getattr(face, name)
            if (inspect.isclass(value) or inspect.isfunction(value)) and value not in found:
                found[value] = f"{prefix}.{name}".replace("overview_dsp", "ov")
    return {name: value for value, name in found.items()}


def members(cls):
    """The public methods and properties that a class itself, or a base of this package, defines."""
    found = {}
    for base in reversed(cls.__mro__):
        if not base.__module__.startswith("overview_dsp"):
            continue
        for name, value in vars(base).items():
            if name.startswith("_"):
                continue
            if isinstance(value, classmethod | staticmethod):
                value = value.__func__
            if inspect.isfunction(value) or isinstance(value, property | functools.cached_property):
                found[name] = value
    return found


def listed():
    """Every public name, one a line, as `tests/public_names.txt` keeps them."""
    return "".join(
        f"{prefix}.{name}\n" for prefix, face in FACES.items() for name in sorted(face.__all__)
    )


if __name__ == "__main__":
    print(listed(), end="")
