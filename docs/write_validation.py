"""The table of published numbers of docs/validation.md, from `gearplay.validate`."""

import gearplay as gp


def table() -> str:
    """Return the table as Markdown, a heading for each topic; `RuntimeError` where a number is beyond its tolerance."""
    found = gp.validate()
    if not found.passed:
        raise RuntimeError(found.message)
    lines, topic, title = [], "", ""
    for row in found.numbers():
        if row["topic"] != topic:
            topic = row["topic"]
            lines += [
                "",
                f"### {topic}",
                "",
                "| number | published | ours | deviation | tolerance |",
                "|---|---:|---:|---:|---:|",
            ]
        if row["title"] != title:
            title = row["title"]
            lines.append(f"| **{title}**; {row['source']} | | | | |")
        unit = "" if row["unit"] == "1" else f" {row['unit']}"
        values = (
            f"{row['published']:.10g}{unit}",
            f"{row['computed']:.9g}",
            f"{row['deviation']:+.1e}",
            f"{row['tolerance']:.1e}",
        )
        lines.append(f"| {row['name']} | {' | '.join(values)} |")
    return "\n".join([*lines, "", found.message])


if __name__ == "__main__":
    print(table())
