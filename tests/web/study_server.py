"""Serve a study's folder until killed: FOLDER ANSWERS PORT TOKEN."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from starlette.routing import Router

from overview_dsp.studies.folder import read_study
from overview_dsp.studies.routes import public_files, study_routes
from overview_dsp.studies.store import Store
from overview_dsp.web.security.auth_token import Access
from overview_dsp.web.security.middleware import Guard
from overview_dsp.web.server import WebServer, listen


def main(folder: str, answers: str, port: str, token: str) -> None:
    study, lists = read_study(folder)
    routes = study_routes(Path(folder), Store(answers, study, lists))
    app = Guard(Router(routes), Access(token=token), (), public_files(Path(folder)), print)
    WebServer(app, [listen("127.0.0.1", int(port))], None, print)
    while True:
        time.sleep(60.0)


if __name__ == "__main__":
    main(*sys.argv[1:])
