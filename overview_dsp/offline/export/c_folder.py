"""The voice as C, for programs without Python: a folder to compile as it is.

`kernel.c` and `overview.h` are the Python kernels, translated by `tools/build_c.py`; beside them
lie an image of the timeline and the preset, an example and two ways to build it.
"""

from __future__ import annotations

import os
from importlib import resources
from pathlib import Path

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import OverviewError
from overview_dsp.files.atomic import make_folder, whole_file
from overview_dsp.kernels.compiling import sources_digest
from overview_dsp.offline.export.browser_memory import encode_engine
from overview_dsp.signal.engine.engine import Engine

IMAGE = "timeline.image"
_FILES = ("kernel.c", "operations.h", "overview.h", "example.c", "Makefile", "CMakeLists.txt")
_IMAGE_RATE = 48_000.0  # of no consequence: a voice goes to its own when it is prepared


def export_c(
    timeline: Timeline, preset: Preset, folder: str | os.PathLike[str], *, seed: int = 0
) -> list[Path]:
    """Write a timeline and a preset as C source, with the image that it plays.

    Any C99 or C++ compiler makes the samples of `render` of it, bit for bit, at any sample rate.

    Parameters
    ----------
    timeline : Timeline
        The data under the hand.
    preset : Preset
        How it is felt and heard.
    folder : str or path
        Made, if need be; files of these names in it are overwritten.
    seed : int
        Of the surface's grain.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    InputError
        A folder that can't be written to.
    OverviewError
        `kernel.c` is of other kernels than these: built before the last change.

    Examples
    --------
    >>> [path.name for path in ov.export.export_c(match, football, "voice")]
    ['kernel.c', 'operations.h', 'overview.h', 'example.c', 'Makefile', 'CMakeLists.txt', \
'timeline.image']
    """
    contents = c_sources(*_FILES)
    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(_IMAGE_RATE)
    contents[IMAGE] = encode_engine(engine)
    made = make_folder(folder)
    for name, content in contents.items():
        with whole_file(made / name) as path:
            path.write_bytes(content)
    return [made / name for name in contents]


def c_sources(*names: str) -> dict[str, bytes]:
    """Files of the package's C folder, by name, kernel.c checked: OverviewError if it is old."""
    source = resources.files("overview_dsp.offline.export") / "c"
    contents = {name: (source / name).read_bytes() for name in names}
    if f"kernels {sources_digest()}\n".encode() not in contents["kernel.c"][:1000]:
        raise OverviewError("kernel.c is older than the kernels: run python tools/build_c.py")
    return contents
