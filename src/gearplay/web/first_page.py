"""The page at its address: HTML with the first case and its motion in it, so that a picture needs no further request."""

import asyncio
import base64
import contextlib
import json
from typing import Any

from gearplay.model.reading import bundled_names
from gearplay.vocabulary.errors import InputError
from gearplay.web.bundle import static_text
from gearplay.web.description import bundled_description
from gearplay.web.pool import JobError, Pool, QueueFullError
from gearplay.web.store import Store

FIRST_CASE = "han2021"
PLACE = '<script id="start" type="application/json"></script>'
"""Where the data of the first case go in ``index.html``."""


class FirstPage:
    """The HTML page; ``result`` is the result of its first case and the key of that in the store, once it is computed."""

    def __init__(self) -> None:
        self.result: dict[str, str] | None = None

    async def html(self) -> str:
        """Return the page; names of the bundled cases, first case and result are data of its script."""
        described = await asyncio.to_thread(bundled_description, FIRST_CASE)
        start = {
            "cases": bundled_names(), "name": FIRST_CASE, "described": described, "result": self.result
        }  # fmt: skip
        data = json.dumps(start, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
        return static_text("index.html").replace(PLACE, PLACE.replace("><", f">{data}<"))

    async def run(self, pool: Pool, store: Store) -> None:
        """Run the first case once a worker is ready; where that fails, the page requests it and shows the reason."""
        described = await asyncio.to_thread(bundled_description, FIRST_CASE)
        await pool.ready.wait()
        models = [described["case"]["backlash_model"]]
        words: dict[str, Any] = {"kind": "run", "case": described["case"], "models": models, "note": ""}
        with contextlib.suppress(JobError, QueueFullError, InputError, OSError):
            frame = await pool.submit(words, lambda _: None).done
            key = store.key_of(words)
            await asyncio.to_thread(store.save, key, frame)
            self.result = {"key": key, "frame": base64.b64encode(frame).decode("ascii")}
