"""After people took part, or before, with simulated ones: simulate, analyse, export."""

from __future__ import annotations

from typing import Any

import click

from overview_dsp.cli.extensions import announce_compile, note, progress_bar, show

TO = ("psych-ds", "bids", "csv", "r", "psignifit", "psychopy", "takes", "wav")


def _effects(context: Any, option: Any, given: tuple[str, ...]) -> dict[tuple[str, Any], float]:
    """FACTOR.LEVEL=NUMBER, several."""
    found: dict[tuple[str, Any], float] = {}
    for text in given:
        named, equals, number = text.rpartition("=")
        factor, point, level = named.partition(".")
        try:
            found[factor, level] = float(number)
        except ValueError:
            equals = ""
        if not (equals and point and level):
            raise click.UsageError(f"--effect {text}: it is FACTOR.LEVEL=NUMBER (of d')")
    return found


@click.command(
    name="simulate",
    epilog="Example: overview study simulate folder -n 24 --d-prime 1.5 -o simulated.sqlite",
)
@click.argument("folder")
@click.option("-n", "count", type=click.IntRange(1, 10_000), help="Observers.  [default: planned]")
@click.option("--d-prime", type=click.FloatRange(0.05, 10.0), default=1.5, show_default=True,
              help="Their sensitivity.")  # fmt: skip
@click.option("--d-prime-sd", "spread", type=click.FloatRange(0.0, 10.0), default=0.3,
              show_default=True, help="Standard deviation of it between them.")  # fmt: skip
@click.option("--lapse", type=click.FloatRange(0.0, 1.0), default=0.02, show_default=True,
              help="Part of the trials that they answer blindly.")  # fmt: skip
@click.option("--effect", "effects", multiple=True, callback=_effects, metavar="FACTOR.LEVEL=D",
              help="What a level adds to d': mapping.static=-0.5.")  # fmt: skip
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of chance.")
@click.option(
    "-o", "--output", "out", metavar="FILE", help="Keep their answers, as a server would."
)
@click.option("--power-runs", "power", type=click.IntRange(2, 10_000), metavar="RUNS",
              help="Run the whole study so often: how often is each effect found?")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def simulate(
    folder: str,
    count: int | None,
    d_prime: float,
    spread: float,
    lapse: float,
    effects: dict[tuple[str, Any], float],
    seed: int,
    out: str | None,
    power: int | None,
    as_json: bool,
) -> None:
    """Let observers of known ability do the study in FOLDER (of `overview study build`)."""
    from overview_dsp.errors import InputError
    from overview_studies.analysis import analyse as analysed
    from overview_studies.folder import read_study
    from overview_studies.observers import Observers, simulated, store_simulated
    from overview_studies.power import power_lines, power_of
    from overview_studies.report import summary
    from overview_studies.store import Store

    study, listed = read_study(folder)
    lists = {one["list"]: one for one in listed}
    factors = study["factors"].items()
    known = {(name, str(level)): (name, level) for name, one in factors for level in one["levels"]}
    for name in effects:
        if name not in known:
            levels = ", ".join(".".join(one) for one in known)
            raise InputError(f"--effect {'.'.join(name)}: no such level; there are {levels}")
    typed = {known[name]: value for name, value in effects.items()}
    observers = Observers(d_prime, spread, lapse, typed)
    people = count or study["participants"]
    if power is not None:
        with progress_bar(f"running the study {power} times") as bar:
            found = power_of(study, lists, observers, people, power, seed, bar)
        show(as_json, found, *power_lines(found))
        return
    answers = simulated(study, lists, observers, people, seed)
    if out is not None:
        if people > len(lists):
            raise InputError(f"-n {people}: the study has {len(lists)} lists to store answers to")
        store = Store(out, study, listed)
        try:
            store_simulated(store, answers)
        finally:
            store.close()
        note(f"{out}: {people} simulated sessions")
    analysis = analysed(answers)
    show(as_json, analysis.as_json(), *summary(analysis))


@click.command(name="analyse", epilog="Example: overview study analyse responses.sqlite -o report")
@click.argument("answers", nargs=-1, required=True)
@click.option("--study", "folder", metavar="FOLDER",
              help="The built folder, for the CSVs of offline pages.")  # fmt: skip
@click.option(
    "-o", "--output", "out", metavar="DIR", help="A report: pictures, methods.txt, tables."
)
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def analyse(answers: tuple[str, ...], folder: str | None, out: str | None, as_json: bool) -> None:
    """Estimate what ANSWERS (SQLite files, offline CSVs) say, with intervals, and report it."""
    from overview_studies.analysis import analyse as analysed
    from overview_studies.answers import read_answers
    from overview_studies.report import summary, write_report

    analysis = analysed(read_answers(answers, folder))
    if out is not None:
        note(f"{out}: {', '.join(write_report(analysis, out))}")
    for code, why in analysis.excluded.items():
        note(f"left out: {code}: {why}")
    show(as_json, analysis.as_json(), *summary(analysis))


@click.command(name="export", epilog="Example: overview study export responses.sqlite -o dataset")
@click.argument("answers", nargs=-1)
@click.option("--to", type=click.Choice(TO), default=TO[0], show_default=True, help="The format.")
@click.option(
    "-o", "--output", "out", required=True, metavar="DIR", help="The folder it is written to."
)
@click.option("--study", metavar="STUDY", help="The study's file, for psychopy, takes and wav; its "
              "built folder, for the CSVs of offline pages.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def export(answers: tuple[str, ...], to: str, out: str, study: str | None, as_json: bool) -> None:
    """Write ANSWERS (SQLite files, offline CSVs) for other tools.

    psych-ds and bids are datasets to publish; csv, r and psignifit tables to analyse; psychopy is
    the lists with sounds; takes and wav are what each hand did, and felt, in a trial.
    """
    from overview_dsp.errors import InputError
    from overview_studies.answers import read_answers
    from overview_studies.design import load_design

    file = study if study is not None and study.endswith(".toml") else None
    if to in ("psychopy", "takes", "wav") and file is None:
        raise InputError(f"--to {to} needs the study's file: --study study.toml")
    if to == "psychopy":
        from overview_studies.psychopy import export_psychopy

        if answers:
            raise InputError("--to psychopy writes lists, not answers; leave the answers out")
        announce_compile()
        with progress_bar("making sounds") as bar:
            count = export_psychopy(load_design(str(file)), out, bar)
        show(as_json, {"folder": out, "sounds": count}, f"{out}: {count} sounds")
        return
    if not answers:
        raise InputError(f"--to {to} needs answers: responses.sqlite, or offline CSVs")
    found = read_answers(answers, None if file else study)
    if to in ("takes", "wav"):
        from overview_studies.replay import export_takes

        with progress_bar("playing takes") as bar:
            count = export_takes(found, load_design(str(file)), out, to == "wav", bar)
        show(as_json, {"folder": out, "takes": count}, f"{out}: {count} takes")
        return
    from overview_studies.exporting import export_answers

    names = export_answers(found, to, out)
    show(as_json, {"folder": out, "files": names}, f"{out}: {len(names)} files")
