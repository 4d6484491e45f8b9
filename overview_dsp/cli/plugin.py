"""`overview plugin`: a timeline as an instrument of a digital audio workstation."""

from __future__ import annotations

import warnings
from pathlib import Path

import click

import overview_dsp as ov
from overview_dsp.cli.common import note, show
from overview_dsp.cli.live_session import SEED
from overview_dsp.cli.options.declaring import JSON, argument, cli_command, option
from overview_dsp.cli.options.reading import Reading, Window, open_window, preset_for
from overview_dsp.errors import InputError, OverviewWarning

_FORMATS = ("clap", "vst3", "lv2")
_TARGETS = ("x86_64-linux", "aarch64-linux", "x86_64-windows", "x86_64-macos", "aarch64-macos")
_ALL_BUNDLED = "overView DSP"


@click.group(name="plugin", epilog="Example: overview plugin build match.json --to clap -o plugins")
def command() -> None:
    """Build audio plugins that play a timeline without Python."""


@cli_command("plugin build match.json --to clap -o ~/.clap", group=command)
def build(
    timelines: tuple[str, ...] = argument(metavar="[TIMELINE]..."),
    *,
    presets: tuple[str, ...] = option(
        "Name or .toml file; of several, one is chosen in the host.  "
        "[default: those that fit the data; without TIMELINE, every bundled one]",
        "--preset",
    ),
    to: str = option("Format of the plugin.", required=True, type=click.Choice(_FORMATS)),
    target: str | None = option(
        "Machine it is for; needs ziglang (pip install ziglang).  [default: this one]",
        type=click.Choice(_TARGETS),
    ),
    output: str = option("Folder for the plugin.", default="."),
    name: str | None = option("Name of the plugin.  [default: the first TIMELINE's]"),
    seed: int = SEED,
    as_json: bool = JSON,
    reading: Reading,
    window: Window,
) -> None:
    """Compile timelines to a plugin, with the samples of `render`; it needs a C compiler.

    Of several TIMELINEs, one is chosen in the host, as are presets. Without any it is a plugin of
    everything that is bundled: the timelines, each in every preset.
    """
    from overview_dsp.data.readers import BUNDLED

    data = {
        Path(timeline).stem: open_window(timeline, reading, window)
        for timeline in timelines or tuple(BUNDLED)
    }
    if len(data) < len(timelines):
        raise InputError("two timelines of a plugin have the same name: name each once")
    everything = not presets and not timelines
    if everything:
        presets = ov.bundled_presets()
    fitting = dict.fromkeys(preset_for(timeline, None) for timeline in data.values())
    chosen = [ov.load_preset(preset) for preset in presets or fitting]
    called = name or (Path(timelines[0]).stem if timelines else _ALL_BUNDLED)
    if target:
        note(f"compiling for {target}; ziglang's first time for a machine takes a minute or more")
    with warnings.catch_warnings():
        if everything:
            # that not every bundled preset names what a bundled timeline holds was nobody's choice
            warnings.simplefilter("ignore", OverviewWarning)
        built = ov.export.build_plugin(
            data, chosen, to, output, name=called, seed=seed, target=target
        )
    names = [preset.name for preset in chosen]
    report = {"format": to, "file": str(built), "timelines": list(data), "presets": names}
    report |= {"target": target} if target else {}
    timed = f"{', '.join(data)} in " if len(data) > 1 else ""
    line = f"{built}: {timed}{', '.join(names)}; clicks on output 1, the tactor on output 2"
    show(as_json, report, line)
