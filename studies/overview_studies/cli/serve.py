"""Command `overview study serve`: assign lists and store answers."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import click

from overview_dsp.cli.extensions import (
    SECONDS,
    Server,
    cli_command,
    ended_by_signals,
    exit_if_stopped,
    note,
    open_server,
    option,
    require_server,
    show,
    wait_for_end,
)


@cli_command("study serve folder --db responses.sqlite --host 0.0.0.0")
def serve(
    folder: str,
    *,
    database: str = option(
        "--db",
        default="responses.sqlite",
        metavar="FILE",
        help="SQLite file for answers; resumed if it exists.",
    ),
    reissue: int | None = option(
        type=click.IntRange(1, 999),
        metavar="LIST",
        help="Release an abandoned list for another participant, then exit.",
    ),
    seconds: float | None = SECONDS,
    as_json: bool = option("--json", help="Report the address as one line of JSON."),
    server: Server,
) -> None:
    """Serve the study in FOLDER (of `overview study build`) until Ctrl-C.

    Each session gets the next list. The server writes an answer to storage before it confirms it.
    Reloaded pages and restarted servers resume the session. Anyone with the printed address can
    take part. Its token is stored in FILE.token beside the answers, or in --token-file, so that
    open pages reconnect after a restart.
    """
    require_server()
    from overview_studies.folder import read_study
    from overview_studies.routes import public_files, study_routes
    from overview_studies.store import Store

    study, lists = read_study(folder)
    store = Store(database, study, lists)
    try:
        if reissue is not None:
            code = store.abandon(reissue)
            report = {"list": reissue, "was": code}
            show(as_json, report, f"list {reissue}, previously used by {code}, is available again")
            return
        root = Path(folder)
        server = replace(server, token_file=server.token_file or f"{database}.token")
        with (
            ended_by_signals() as received,
            open_server(
                server, None, study_routes(root, store), crowd=True, public=public_files(root)
            ) as opened,
        ):
            begun = len(store.sessions())
            note(f"{begun} of {study['lists']} lists are in use; answers are stored in {database}")
            if as_json:
                print(json.dumps({"address": opened.address}), flush=True)
            wait_for_end(received, seconds)
    finally:
        store.close()
    exit_if_stopped(received)
