"""Public names for commands in other distributions, each imported when it is first used."""

from overview_dsp.batch.grid import PROGRAM as PROGRAM, Keys as Keys
from overview_dsp.batch.grid import RenderGrid as RenderGrid
from overview_dsp.batch.jobs_file import (
    KEYS as KEYS,
    JobsTable as JobsTable,
    read_grid as read_grid,
)
from overview_dsp.cli.common import (
    announce_compile as announce_compile,
    note as note,
    progress_bar as progress_bar,
    show as show,
)
from overview_dsp.cli.live_session import SECONDS as SECONDS
from overview_dsp.cli.options.declaring import cli_command as cli_command, option as option
from overview_dsp.cli.options.server import (
    Server as Server,
    open_server as open_server,
    require_server as require_server,
)
from overview_dsp.cli.signals import (
    ended_by_signals as ended_by_signals,
    exit_if_stopped as exit_if_stopped,
    wait_for_end as wait_for_end,
)
from overview_dsp.design.gestures.model import SOURCES as SOURCES
from overview_dsp.design.presets.parameter import Value as Value
from overview_dsp.files.atomic import atomic_folder as atomic_folder, write_file as write_file
from overview_dsp.files.json_table import read_table as read_table, write_table as write_table
from overview_dsp.files.sound import sound_bytes as sound_bytes
from overview_dsp.files.toml import (
    faults_at_their_line as faults_at_their_line,
    parse_toml as parse_toml,
    read_text as read_text,
)
from overview_dsp.kernels.layout import CLICK as CLICK, TACTOR as TACTOR
from overview_dsp.live.output.settings import resolve_output as resolve_output
from overview_dsp.measure.perceived_level import stroke_feel as stroke_feel
from overview_dsp.offline.plots import style
from overview_dsp.offline.plots.style import save_figure as save_figure
from overview_dsp.signal.surface.angle_map import AngleMap as AngleMap
from overview_dsp.web.assets import (
    START as START,
    TYPES as TYPES,
    other_page_files as other_page_files,
)
from overview_dsp.web.messages import json_object as json_object
from overview_dsp.web.security.middleware import threaded_endpoint as threaded_endpoint
from overview_dsp.web.site_content import RATES as RATES
from overview_dsp.web.site_data import kind_styles as kind_styles, window_json as window_json
from overview_dsp.web.sound_data import make_patch as make_patch, whole_bytes as whole_bytes

plot_style = style
