"""The command group `overview plugin`."""

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


@cli_command(
    "plugin build match.json --to clap -o ~/.clap",
    group=command,
    first="presets to target output name window zoom_to as_json",
)
def build(
    timelines: tuple[str, ...] = argument(metavar="[TIMELINE]..."),
    *,
    presets: tuple[str, ...] = option("--preset"),
    to: str = option(required=True, type=click.Choice(_FORMATS)),
    target: str | None = option(type=click.Choice(_TARGETS)),
    output: str = option(default="."),
    name: str | None = option(),
    seed: int = SEED,
    as_json: bool = JSON,
    reading: Reading,
    window: Window,
) -> None:
    """Compile timelines to an audio plugin, with a C compiler.

    Its samples are those of overview render. The host can switch between several TIMELINEs, and
    between presets. Without TIMELINE, the plugin has all bundled timelines and presets.
    """
    from overview_dsp.data.readers import BUNDLED

    data = {
        Path(timeline).stem: open_window(timeline, reading, window)
        for timeline in timelines or tuple(BUNDLED)
    }
    if len(data) < len(timelines):
        raise InputError("two timelines have the same name; rename one")
    everything = not presets and not timelines
    if everything:
        presets = ov.bundled_presets()
    if not presets:
        presets = tuple(dict.fromkeys(preset_for(timeline, None) for timeline in data.values()))
    chosen = [ov.load_preset(preset) for preset in presets]
    title = name or (Path(timelines[0]).stem if timelines else _ALL_BUNDLED)
    if target:
        note(f"compiling for {target}; the first time takes ziglang a minute or more")
    with warnings.catch_warnings():
        if everything:
            # not every bundled preset has all kinds of a bundled timeline
            warnings.simplefilter("ignore", OverviewWarning)
        built = ov.export.build_plugin(
            data, chosen, to, output, name=title, seed=seed, target=target
        )
    names = [preset.name for preset in chosen]
    report = {"format": to, "file": str(built), "timelines": list(data), "presets": names}
    report |= {"target": target} if target else {}
    of_timelines = f"{', '.join(data)} in " if len(data) > 1 else ""
    line = f"{built}: {of_timelines}{', '.join(names)}; clicks on output 1, the tactor on output 2"
    show(as_json, report, line)
