"""`gearplay serve`: the interactive page on this machine."""

import threading
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from gearplay.cli.output import print_text


def serve(
    port: Annotated[int, typer.Option("--port", help="Port; 0 for any free one.")] = 8008,
    host: Annotated[
        str, typer.Option("--host", help="Address to listen on; any but loopback requires --token.")
    ] = "127.0.0.1",
    name: Annotated[
        list[str] | None, typer.Option("--name", help="A further name of this host. May be repeated.")
    ] = None,
    token: Annotated[
        str | None, typer.Option("--token", help="Access token, required in the page's address.")
    ] = None,
    folder: Annotated[Path, typer.Option("--folder", help="Folder of finished results.")] = Path("out/serve"),
    workers: Annotated[int, typer.Option("--workers", min=1, max=64, help="Worker processes.")] = 2,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")
    ] = True,
) -> None:
    """Serve the interactive page: move sliders, watch the shaft."""
    from gearplay.web.serve import Address
    from gearplay.web.serve import serve as serve_page

    def ready(address: Address) -> None:
        print_text(f"gearplay: {address.url}  (Ctrl-C ends it; results are kept in {folder})")
        if browser:
            threading.Thread(target=webbrowser.open, args=(address.url,), daemon=True).start()

    serve_page(host, port, token, folder, names=tuple(name or ()), workers=workers, ready=ready)
