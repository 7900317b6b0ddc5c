"""What all report pages share: the templates' environment and pictures within the page."""

import base64
from collections.abc import Callable, Mapping
from typing import Any


def render_page(
    template: str, *, filters: Mapping[str, Callable[..., Any]] | None = None, **values: Any
) -> str:
    """Return a page from one of the package's templates; values are escaped, a missing one is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("gearplay.pictures", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
    )
    environment.filters.update(filters or {})
    return environment.get_template(template).render(**values)


def data_uri(png: bytes) -> str:
    """Return a PNG as an address that holds it, so that a page needs no other file.

    >>> data_uri(b"abc")
    'data:image/png;base64,YWJj'
    """
    return "data:image/png;base64," + base64.b64encode(png).decode()
