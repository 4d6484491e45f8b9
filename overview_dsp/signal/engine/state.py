"""The engine's saved state: parameters, event kinds and seed as bytes, and back."""

from __future__ import annotations

import json

from overview_dsp.design.presets.dicts import preset_from_dict, preset_to_dict
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError


def encode_state(preset: Preset, seed: int) -> bytes:
    """The state as UTF-8 JSON; the same values give the same bytes."""
    state = {"overview_state": 1, **preset_to_dict(preset), "seed": seed}
    return json.dumps(state, indent=1, ensure_ascii=False).encode()


def decode_state(state: bytes) -> tuple[Preset, int]:
    """Preset and seed of a saved state; InputError if it isn't one."""
    try:
        data = json.loads(state.decode())
        if data["overview_state"] != 1:
            raise InputError(f"a state of version {data['overview_state']!r}; this reads 1")
        preset = preset_from_dict(data)
        seed = int(data["seed"])
    except InputError:
        raise
    except (ValueError, OverflowError, RecursionError) as error:
        raise InputError(f"not a saved state: {error}") from None
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(f"not a saved state: {type(error).__name__} {error}") from None
    return preset, seed
