"""Export of gestures to haptic formats, and of engines to browsers, C and plugins.

`ov.export` writes renders for other devices, and reads haptic clips. Each name is
imported when it is first used.

Examples
--------
>>> import overview_dsp as ov
>>> match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
>>> result = ov.render(match, preset, ov.sweep(0.5), sample_rate=8000, tail="none")
>>> [path.name for path in ov.export.export(result, "haptic", "match.haptic").files]
['match.haptic']
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from overview_dsp.public import lazy_names

if TYPE_CHECKING:
    from overview_dsp.offline.export.browser_memory import encode_engine
    from overview_dsp.offline.export.c_code import export_c
    from overview_dsp.offline.export.clip import PerceptualError, Transient
    from overview_dsp.offline.export.plugins import build_plugin
    from overview_dsp.offline.export.reading import DecodedClip, check_clip, read_clip
    from overview_dsp.offline.export.writing import ExportResult, export, formats

__all__ = [
    "DecodedClip",
    "ExportResult",
    "PerceptualError",
    "Transient",
    "build_plugin",
    "check_clip",
    "encode_engine",
    "export",
    "export_c",
    "formats",
    "read_clip",
]

if not TYPE_CHECKING:  # a type checker knows the names above, and no others
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "ExportResult": "writing",
            "PerceptualError": "clip",
            "DecodedClip": "reading",
            "Transient": "clip",
            "build_plugin": "plugins",
            "check_clip": "reading",
            "encode_engine": "browser_memory",
            "export": "writing",
            "export_c": "c_code",
            "formats": "writing",
            "read_clip": "reading",
        },
    )
