"""The table of docs/lens-files.md: results of reading the lens files in a folder, by format.

python -m tests.lenses.outcome FOLDER
"""

import sys
from pathlib import Path

from lensbench import lenses

FORMATS = {".zmx": "Zemax `.zmx`", ".seq": "CODE V `.seq`", ".len": "OSLO `.len`", ".txt": "Optical Bench `.txt`",
           ".json": "Optiland `.json`", ".roa": "rayoptics `.roa`"}


def outcome(path):
    """Whether a file was read, and the cells of its row."""
    try:
        lens = lenses.load(path)
    except lenses.LensFileError as error:
        position = f"line {error.line}: " if error.line else ""
        return False, ("refused", position + error.reason.partition(" An AGF file")[0])
    size = f"{len(lens.surfaces)} surfaces"
    if lens.positions is not None:
        size += f", {len(lens.positions.zoom_stations) * len(lens.positions.focus_stations)} positions"
    return True, (size, "; ".join(map(str, lens.findings)))


def tables(folder):
    """The lines of the summary, and of a table for each format; SystemExit where there are no lens files."""
    if not Path(folder).is_dir():
        raise SystemExit(f"{folder}: there is no such folder")
    lines, summary, total = [], [], [0, 0]
    for suffix, name in FORMATS.items():
        files = sorted((path for path in Path(folder).rglob("*") if path.suffix.lower() == suffix),
                       key=lambda path: path.name.lower())
        if not files:
            continue
        rows = [(path.name, *outcome(path)) for path in files]
        read = sum(row[1] for row in rows)
        total = [total[0] + len(rows), total[1] + read]
        summary.append(f"| {name} | {len(rows)} | {read} | {len(rows) - read} |")
        lines += ["", f"### {name}", "", "| file | outcome | findings |", "|---|---|---|"]
        lines += [f"| {file} | {' | '.join(cells)} |" for file, _, cells in rows]
    if not summary:
        raise SystemExit(f"{folder}: this folder holds no lens files ({', '.join(FORMATS)})")
    return ["| format | files | read | refused |", "|---|---|---|---|", *summary,
            f"| all | {total[0]} | {total[1]} | {total[0] - total[1]} |", *lines]


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("usage: python -m tests.lenses.outcome FOLDER")
    print("\n".join(tables(sys.argv[1])))
