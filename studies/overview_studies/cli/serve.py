"""`overview study serve`: hand out lists and keep answers."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import click

from overview_dsp.cli.extensions import (
    ended_by_signals,
    exit_if_stopped,
    note,
    open_server,
    require_server,
    seconds_given,
    server_options,
    show,
)

LOOK_EVERY_S = 0.1


@click.command(
    name="serve",
    epilog="Example: overview study serve folder --db responses.sqlite --host 0.0.0.0",
)
@click.argument("folder")
@click.option("--db", "database", default="responses.sqlite", show_default=True, metavar="FILE",
              help="Where answers are kept; it goes on where it was.")  # fmt: skip
@click.option("--give-again", type=click.IntRange(1, 999), metavar="LIST",
              help="Hand out an abandoned list again; then end.")  # fmt: skip
@click.option("--seconds", type=float, callback=seconds_given, help="Stop after so long.")
@click.option("--json", "as_json", is_flag=True, help="The address as a line of JSON.")
@server_options
def serve(
    folder: str,
    database: str,
    give_again: int | None,
    seconds: float | None,
    as_json: bool,
    server: dict[str, Any],
) -> None:
    """Serve the study in FOLDER (of `overview study build`) until Ctrl-C.

    Each session gets the next list. An answer is on the disk before the page is told so; a page
    that is reloaded, and a server that was stopped, go on where they were. Whoever has the printed
    address may take part; its token is kept in FILE.token beside the answers, or in --token-file,
    so that pages that are open when the server is started anew go on.
    """
    require_server()
    from overview_studies.folder import read_study
    from overview_studies.routes import public_files, study_routes
    from overview_studies.store import Store

    study, lists = read_study(folder)
    store = Store(database, study, lists)
    try:
        if give_again is not None:
            code = store.abandon(give_again)
            report = {"list": give_again, "was": code}
            show(as_json, report, f"list {give_again}, which {code} had, is handed out again")
            return
        root = Path(folder)
        server["token_file"] = server["token_file"] or f"{database}.token"
        with (
            ended_by_signals() as received,
            open_server(
                server, None, study_routes(root, store), crowd=True, public=public_files(root)
            ) as opened,
        ):
            begun = len(store.sessions())
            note(f"{begun} of {study['lists']} lists are handed out; answers go to {database}")
            if as_json:
                print(json.dumps({"address": opened.address}), flush=True)
            until = None if seconds is None else time.monotonic() + seconds
            while not received and (until is None or time.monotonic() < until):
                time.sleep(LOOK_EVERY_S)
    finally:
        store.close()
    exit_if_stopped(received)
