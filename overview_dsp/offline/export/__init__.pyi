"""Public names of `ov.export`, each imported when it is first used."""

from overview_dsp.offline.export.board_code import export_board as export_board
from overview_dsp.offline.export.browser_memory import encode_engine as encode_engine
from overview_dsp.offline.export.c_code import export_c as export_c
from overview_dsp.offline.export.clip import (
    PerceptualError as PerceptualError,
    Transient as Transient,
)
from overview_dsp.offline.export.plugins import build_plugin as build_plugin
from overview_dsp.offline.export.reading import (
    DecodedClip as DecodedClip,
    check_clip as check_clip,
    read_clip as read_clip,
)
from overview_dsp.offline.export.writing import (
    ExportResult as ExportResult,
    export as export,
    formats as formats,
)
