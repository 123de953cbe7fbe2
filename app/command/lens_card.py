"""What `lensbench info` says of a lens beside its figures: provenance, elements, glasses, estimates and its check."""

from dataclasses import asdict
from itertools import pairwise
from typing import Any

from lensbench.core.optics.prescription import Lens
from lensbench.core.text import fixed, significant

WIDTH = 46              # of the labels
# Figures of `lensbench info` that follow from what is estimated, by a word of the estimates; and their labels
ESTIMATED = {"close position": ("nearest_focus",), "stop": ("f_number", "t_number"), "year": ("year",)}
LABELS = {"Nearest focus, from the film": "nearest_focus", "f-number": "f_number", "T-number": "t_number",
          "year": "year"}


def lens_card(lens: Lens) -> dict[str, Any]:
    """Provenance, counts, glasses and findings of a lens as read, for JSON; lengths in mm.

    lens: at any position, wide open: a lens that is stopped down contradicts its stated f-number. `glasses` has a row
    for each medium other than air, with the surface before it; `estimated` the keys of the values that follow from
    `estimates`; `system` the system data, `designed` the same in words; `check` the findings of `lenses.check`.
    """
    from lensbench import lenses
    from lensbench.lenses.tables.counts import counts
    from lensbench.lenses.tables.system_text import system_rows

    return {"maker": lens.maker, "designer": lens.designer, "patent": lens.patent, "film_size": lens.film_size,
            "notes": lens.notes, **asdict(counts(lens)), "estimates": lens.estimates,
            "system": asdict(lens.system), "designed": dict(system_rows(lens.system)),
            "estimated": [key for word, keys in ESTIMATED.items() if word in lens.estimates for key in keys],
            "glasses": [{"surface": i, "name": front.glass.name, "n_d": front.glass.n_d, "v_d": front.glass.v_d,
                         "thickness": front.thickness, "semi_diameter": max(front.semi_diameter, back.semi_diameter)}
                        for i, (front, back) in enumerate(pairwise(lens.surfaces)) if front.glass.n_d != 1.0],
            "check": [asdict(finding) for finding in lenses.check(lens)]}


def card_lines(card: dict[str, Any], source: str) -> list[str]:
    """Lines for people: provenance first, what is not known left out."""
    film = card["film_size"]
    rows = [("Maker", card["maker"]), ("Designer", card["designer"]), ("Patent", card["patent"]),
            ("Source", source if source != card["patent"] else ""),
            ("Made for", f"{significant(film[0])} × {significant(film[1])} mm" if film else ""),
            *card["designed"].items(), ("Elements", _elements(card)),
            ("Estimated (marked *)", card["estimates"]), ("Notes", card["notes"]), ("Check", _check(card["check"]))]
    return [f"{label:{WIDTH}}{text}" for label, text in rows if text]


def star(card: dict[str, Any], label: str) -> str:
    """A star behind a figure that follows from what is estimated, by its label; "" behind others."""
    return "*" if LABELS.get(label) in card["estimated"] else ""


def _elements(card: dict[str, Any]) -> str:
    def some(count: int, what: str) -> str:
        return f"{count} {what}{'' if count == 1 else 's'}"

    text = f"{card['elements']} in {some(card['groups'], 'group')}"
    more = [some(card[key], what) for key, what in (("aspheres", "asphere"), ("focus_groups", "focus group"))
            if card[key]]
    return ", ".join([text, *more])


def _check(findings: list[dict[str, Any]]) -> str:
    """The result of the check: the gravest finding, and the number of the others."""
    from lensbench.lenses import Severity

    doubts = [finding for finding in findings if finding["severity"] is Severity.WARNING]
    if not findings:
        return "nothing found"
    first = (doubts or findings)[0]
    place = "" if first["surface"] is None else f"surface {first['surface']}: "
    others = len(findings) - 1
    return f"{'' if doubts else 'no doubts; '}{place}{first['message']}" + (
        f" (and {others} more: `lensbench check`)" if others else "")


def glass_lines(card: dict[str, Any]) -> list[str]:
    """A table of the glasses; the name of a glass is that of the source."""
    if not card["glasses"]:
        return []
    rows = [("Glass behind surface", "n_d", "V_d", "Thickness", "Diameter", "")]
    rows += [(str(glass["surface"]), fixed(glass["n_d"], 5), fixed(glass["v_d"], 2) if glass["v_d"] else "not known",
              fixed(glass["thickness"], 2), fixed(2.0 * glass["semi_diameter"], 1) + ("*" if "rims" in card["estimates"]
                                                                                       else ""),
              glass["name"]) for glass in card["glasses"]]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    return ["  ".join([text.rjust(width) for text, width in zip(row[:5], widths, strict=True)] + [row[5]]).rstrip()
            for row in rows]
