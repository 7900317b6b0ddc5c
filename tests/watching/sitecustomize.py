"""Looks at the figures of commands that tests start, as `conftest.watched` does at those of the tests: Python runs this first.

What is wrong with a figure goes as a file into the folder that `GEARPLAY_TESTS_WATCHED` names.
"""

import importlib.abc
import importlib.machinery
import os
import sys
import uuid
from pathlib import Path
from typing import Any

FOLDER = os.environ.get("GEARPLAY_TESTS_WATCHED")
CANVAS = "gearplay.pictures.canvas"


class _Watching(importlib.abc.Loader):
    """Loads the canvas, with a look at each figure that leaves by it."""

    def __init__(self, own: Any) -> None:
        self.own = own

    def create_module(self, spec: Any) -> Any:
        return self.own.create_module(spec)

    def exec_module(self, module: Any) -> None:
        self.own.exec_module(module)
        draw = module.to_bytes

        def look(figure: Any, form: str) -> bytes:
            sys.path.append(str(Path(__file__).parents[1]))
            try:
                from pictures import looked_at
            finally:
                sys.path.pop()
            drawn, found = looked_at(draw, figure, form)
            if found:
                (Path(FOLDER or "") / uuid.uuid4().hex).write_text("\n".join(found), encoding="utf-8")
            return drawn

        module.to_bytes = look


class _Finder(importlib.abc.MetaPathFinder):
    def find_spec(self, name: str, path: Any, target: Any = None) -> Any:
        if name != CANVAS:
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        if spec is not None and spec.loader is not None:
            spec.loader = _Watching(spec.loader)
        return spec


if FOLDER:
    sys.meta_path.insert(0, _Finder())
