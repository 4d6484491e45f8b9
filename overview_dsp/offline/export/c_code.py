"""C export of a voice for programs without Python.

`kernel.c` and `overview.h` are the Python kernels, translated by `tools/build_c.py`. The folder
also has an image of the timeline and the preset, an example and two build files. Plugins contain
the same sources.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib import resources
from pathlib import Path

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import OverviewError
from overview_dsp.files.atomic import make_folder, write_file
from overview_dsp.kernels.sources import sources_digest
from overview_dsp.offline.export.browser_memory import encode_engine
from overview_dsp.signal.engine.engine import Engine

IMAGE = "timeline.image"
_FILES = ("kernel.c", "operations.h", "overview.h", "example.c", "Makefile", "CMakeLists.txt")
_IMAGE_RATE = 48_000.0  # arbitrary: `overview_prepare` sets the rate of a voice


def export_c(
    timeline: Timeline, preset: Preset, folder: str | os.PathLike[str], *, seed: int = 0
) -> list[Path]:
    """Write C source with an image of a timeline and a preset.

    Compiled with any C99 or C++ compiler, it is bit-identical to `render` at any sample rate.

    Parameters
    ----------
    timeline : Timeline
        Data of the voice.
    preset : Preset
        Parameters of feel and sound.
    folder : str or path
        Folder, created if missing; existing files are overwritten.
    seed : int
        Seed of the texture noise.

    Returns
    -------
    list of Path
        Written files.

    Raises
    ------
    InputError
        The folder can't be written.
    OverviewError
        `kernel.c` is older than the kernels.

    Examples
    --------
    >>> [path.name for path in ov.export.export_c(match, football, "voice")]
    ['kernel.c', 'operations.h', 'overview.h', 'example.c', 'Makefile', 'CMakeLists.txt', \
'timeline.image']
    """
    contents = c_sources(*_FILES)
    contents[IMAGE] = encode_engine(prepared_engine(timeline, preset, seed))
    return write_files(folder, contents)


def prepared_engine(timeline: Timeline, preset: Preset, seed: int) -> Engine:
    """Return an engine whose memory is the initial image of a voice."""
    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(_IMAGE_RATE)
    return engine


def write_files(folder: str | os.PathLike[str], contents: Mapping[str, bytes]) -> list[Path]:
    """Write files by their paths in a folder, each completely; return the paths."""
    written = [Path(folder, path) for path in contents]
    for path, content in zip(written, contents.values(), strict=True):
        make_folder(path.parent)
        write_file(path, content)
    return written


def c_sources(*names: str) -> dict[str, bytes]:
    """Return files of the package's C folder by name; OverviewError if kernel.c is outdated."""
    source = resources.files("overview_dsp.offline.export") / "c"
    contents = {name: (source / name).read_bytes() for name in names}
    if f"kernels {sources_digest()}\n".encode() not in contents["kernel.c"][:1000]:
        raise OverviewError("kernel.c is older than the kernels: run python tools/build_c.py")
    return contents
