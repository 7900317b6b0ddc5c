"""The routes of the page: static files, cases, results, and one WebSocket for jobs (schema: docs/page.md)."""

import asyncio
import contextlib
import json
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket

from gearplay.model.reading import bundled_names, load_case
from gearplay.model.toml_files import LARGEST_FILE, parse_toml
from gearplay.vocabulary.errors import GearplayError
from gearplay.vocabulary.optional import load_optional
from gearplay.vocabulary.version import VERSION
from gearplay.web.bundle import script_of
from gearplay.web.description import bundled_description, description
from gearplay.web.downloads import file_of
from gearplay.web.first_page import FirstPage
from gearplay.web.pool import Job, JobError, Pool, QueueFullError
from gearplay.web.session import FULL, LARGEST_BODY, Wire
from gearplay.web.store import Store

STATIC = Path(__file__).parent / "static"
MOST_DISCARDED = 64 * LARGEST_BODY
LARGEST_MEASUREMENT = 64 * 1024**2
NO_CASE = "case: must be JSON with toml or case."
FORMS = {"nc": "application/x-netcdf", "csv": "text/csv", "toml": "application/toml"}


def plotly_file() -> Path:
    """Return the browser file of plotly.js, as the Python package plotly ships it."""
    return Path(str(load_optional("plotly", "web").__file__)).parent / "package_data" / "plotly.min.js"


def make_app(folder: Path, pool: Pool) -> Starlette:
    """Return the application; it starts and ends the pool, and keeps results in a folder."""
    store, first = Store(folder), FirstPage()
    plotly = plotly_file()

    @contextlib.asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        await pool.start()
        running = asyncio.create_task(first.run(pool, store))
        yield
        running.cancel()
        await pool.close()

    async def page(_: Request) -> Response:
        return HTMLResponse(await first.html(), headers={"cache-control": "no-cache"})

    async def script(_: Request) -> Response:
        return Response(
            script_of("main"), media_type="text/javascript", headers={"cache-control": "no-cache"}
        )

    async def plots(_: Request) -> Response:
        return FileResponse(plotly, media_type="text/javascript", headers={"cache-control": "max-age=86400"})

    async def about(_: Request) -> Response:
        return JSONResponse({"version": VERSION, "cases": bundled_names()})

    async def bundled(request: Request) -> Response:
        name = request.path_params["name"]
        if name not in bundled_names():
            raise RefusedError("case: there is no bundled case of this name.", 404)
        return JSONResponse(bundled_description(name))

    async def given(request: Request) -> Response:
        body = await _body(request, LARGEST_BODY, f"case: a file may have at most {LARGEST_FILE} bytes.")
        sent = _parsed(body, NO_CASE)
        if isinstance(sent.get("toml"), str):
            case = load_case(parse_toml(sent["toml"], "upload"))
            return JSONResponse(description(case, source=sent["toml"]))
        if isinstance(sent.get("case"), dict):
            return JSONResponse(description(load_case(sent["case"])))
        raise RefusedError(NO_CASE)

    async def results(_: Request) -> Response:
        return JSONResponse(await asyncio.to_thread(store.listed))

    async def stored(request: Request) -> bytes:
        frame = await asyncio.to_thread(store.load, request.path_params["key"])
        if frame is None:
            raise RefusedError("result: it is no longer kept. Run it again.", 404)
        return frame

    async def result(request: Request) -> Response:
        return Response(await stored(request), media_type="application/octet-stream")

    async def result_file(request: Request) -> Response:
        form, frame = request.path_params["form"], await stored(request)
        try:
            return _file(await asyncio.to_thread(file_of, frame, form), form)
        except (GearplayError, KeyError, ValueError) as error:
            raise RefusedError(f"result: it cannot be saved. {error}") from None

    async def export(request: Request) -> Response:
        form = request.path_params["form"]
        body = await _body(request, LARGEST_BODY, f"export: a case may have at most {LARGEST_BODY} bytes.")
        if form not in FORMS:
            raise RefusedError("export: must be nc, csv or toml of a case.")
        sent = _parsed(body, "export: must be JSON with a case.")
        job = {"kind": "export", "form": form} | {
            name: sent.get(name) for name in ("case", "source", "changes")
        }
        return _file(await _unless_gone(request, pool, pool.submit(job, _ignore)), form)

    async def measurement(request: Request) -> Response:
        limit = f"measurement: a file may have at most {LARGEST_MEASUREMENT // 1024**2} MB."
        body = await _body(request, LARGEST_MEASUREMENT, limit)
        given = request.query_params.get("name", "")
        name = "".join(c if c.isalnum() or c in " ._-+()" else "_" for c in given)[-100:].strip(" .")
        unit = request.query_params.get("unit", "")
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder) / (name or "measurement")
            await asyncio.to_thread(place.write_bytes, body)
            job = {"kind": "measured", "path": str(place), "name": given[-100:], "unit": unit[:20]}
            frame = await _unless_gone(request, pool, pool.submit(job, _ignore))
        return Response(frame, media_type="application/octet-stream")

    async def wire(socket: WebSocket) -> None:
        await socket.accept()
        await Wire(socket, pool, store).serve()

    return Starlette(
        routes=[
            Route("/", page),
            Route("/page.js", script),
            Route("/plotly.js", plots),
            Route("/api/about", about),
            Route("/api/cases/{name}", bundled),
            Route("/api/case", given, methods=["POST"]),
            Route("/api/results", results),
            Route("/api/results/{key}", result),
            Route("/api/results/{key}/{form}", result_file),
            Route("/api/export/{form}", export, methods=["POST"]),
            Route("/api/measurement", measurement, methods=["POST"]),
            WebSocketRoute("/wire", wire),
            Mount("/static", StaticFiles(directory=STATIC)),
        ],
        lifespan=lifespan,
        exception_handlers=dict.fromkeys((RefusedError, QueueFullError, JobError, GearplayError), _refusal),
    )


class RefusedError(Exception):
    """A request that is refused with a message and an HTTP status."""

    def __init__(self, words: str, status: int = 400) -> None:
        super().__init__(words)
        self.status = status


async def _refusal(_: Request, error: Exception) -> Response:
    """Return the response to an error of the user, of a job or of the queue."""
    if isinstance(error, QueueFullError):
        return JSONResponse({"error": FULL}, status_code=503)
    return JSONResponse({"error": str(error)}, status_code=getattr(error, "status", 400))


def _file(data: bytes, form: str) -> Response:
    """Return a file to save."""
    name = f'attachment; filename="gearplay.{form}"'
    return Response(data, media_type=FORMS[form], headers={"content-disposition": name})


async def _unless_gone(request: Request, pool: Pool, job: Job) -> bytes:
    """Return the result of a job; cancel it when its client disconnects."""
    try:
        while not job.done.done():
            if await request.is_disconnected():
                raise asyncio.CancelledError
            await asyncio.wait([job.done], timeout=0.5)
        return job.done.result()
    except asyncio.CancelledError:
        await pool.cancel(job)
        raise JobError("Cancelled.", cancelled=True) from None


def _ignore(_: dict[str, Any]) -> None:
    """Ignore the progress of a job."""


async def _body(request: Request, most: int, limit: str) -> bytes:
    """Return the body of a request; `RefusedError` with the text of the ``limit`` if it is longer than ``most`` [bytes].

    The rest of a long body is read and dropped, as closing the connection before its end would hide the message.
    """
    parts, size = [], 0
    async for part in request.stream():
        size += len(part)
        if size <= most:
            parts.append(part)
        elif size > max(MOST_DISCARDED, 2 * most):
            break
    if size > most:
        raise RefusedError(f"{limit} Shorten it.", 413)
    return b"".join(parts)


def _parsed(body: bytes, rule: str) -> dict[str, Any]:
    """Return the JSON object in a body; `RefusedError` with the ``rule`` for anything else."""
    try:
        sent = json.loads(body)
    except (ValueError, RecursionError):
        sent = None
    if not isinstance(sent, dict):
        raise RefusedError(rule)
    return sent
