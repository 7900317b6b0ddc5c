"""``gearplay check``: validate a case and list findings."""

from __future__ import annotations

from gearplay.cli.options import CaseName, Changes
from gearplay.cli.output import Json, print_json, print_text
from gearplay.vocabulary.errors import escape_controls


def check(
    case: CaseName,
    changes: Changes = None,
    json: Json = False,
) -> None:
    """Validate a case; list its warnings, ratios and frequencies."""
    from gearplay.model.check import check_case
    from gearplay.model.reading import load_case
    from gearplay.parts.mesh.check_pairs import pair_table

    loaded = load_case(case, changes or ())
    findings = check_case(loaded)
    if json:
        document = {
            "status": "done",
            "case": loaded.resolved(),
            "sha256": loaded.sha256,
            "pairs": pair_table(loaded),
            "findings": [finding.as_document() for finding in findings],
        }
        print_json(document)
        return
    for finding in findings:
        print_text(str(finding))
    warnings = sum(finding.severity == "warning" for finding in findings)
    count = {0: "no warnings", 1: "1 warning"}.get(warnings, f"{warnings} warnings")
    print_text(f"{loaded.title or escape_controls(case)}: valid, {count}.")
