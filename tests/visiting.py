"""What tests of the page do on it: fields by path, sliders, what the page holds."""

from collections.abc import Callable
from typing import Any

from serving import Visit

Open = Callable[..., Visit]

SPEED, CLEARANCE = "rotors.pinion.drive.speed", "sleeves.ring.radial_clearance"

BACKLASH = "meshes.0.backlash"

WITHOUT_AVERAGES = """() => {
  const { wire } = window.gearplay.state, submit = wire.submit.bind(wire);
  wire.submit = (kind, ...rest) => (kind === "average" ? new Promise(() => {}) : submit(kind, ...rest));
}"""
"""They redraw the spectrum when they come, on a wider scale."""


UNFOLD = "(each) => { for (let at = each.closest('details'); at; at = at.parentElement.closest('details')) at.open = true; }"


def field(visit: Visit, path: str) -> Any:
    return unfolded(visit, f'input[data-path="{path}"]')


def slider(visit: Visit, path: str) -> Any:
    return unfolded(visit, f'input[data-slider="{path}"]')


def unfolded(visit: Visit, selector: str) -> Any:
    """Return a control after opening what it is folded in."""
    found = visit.page.locator(selector)
    found.evaluate(UNFOLD)
    return found


def fill(visit: Visit, path: str, value: str) -> None:
    def act() -> None:
        field(visit, path).fill(value)
        field(visit, path).press("Tab")

    visit.after(act)


def open_run(visit: Visit) -> None:
    """Open the fields of the run."""
    visit.page.locator("details[data-group=Run]").evaluate("(each) => { each.open = true; }")


def shown(visit: Visit, expression: str) -> Any:
    return visit.page.evaluate(f"window.gearplay.state.{expression}")


def brief(made: Visit) -> None:
    for path, value in (("run.duration", "0.05"), ("run.transient", "0")):
        open_run(made)
        fill(made, path, value)


def cells(made: Visit, columns: int, rows: int) -> None:
    """Make the map that is asked for a short one."""
    values = {"columns": columns, "rows": rows, "members": 2, "duration": 0.05, "transient": 0}
    for name, value in values.items():
        made.page.fill(f"#map-form [name={name}]", str(value))


def small_map(made: Visit) -> None:
    made.page.click("#tab-map")
    cells(made, 3, 2)
    made.page.click("#map-form button")
    made.until("document.getElementById('map').data?.[0].z.length === 2")
