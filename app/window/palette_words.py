"""What people type into the command palette besides names: bare values, other words for its entries, uses of lenses."""

import re

from lensbench.app.session.lens_shelf import Shelf
from lensbench.app.settings.dial_scales import F_NUMBERS, ISOS
from lensbench.app.settings.text_values import NUMBER, read_length, read_number
from lensbench.core.text import significant

# The setting that a bare value is of, by its unit; # is the number
BARE = {
    "f_number": r"f\s*[/:]?\s*#", "iso": r"iso\s*#|#\s*iso", "shutter": r'1\s*/\s*#\s*s?|#\s*(?:s|ms|µs|us|″|")',
    "focus_distance": r"#\s*(?:m|cm|km|ft|feet|foot|′|'|in|inch|inches)|∞|inf|infinity",
    "exposure": r"#\s*(?:ev|stops?)|[-+−]#", "fov": r"#\s*(?:°|deg|degrees)", "focal_length": r"#\s*mm"}
BEGUN = {"f_number": r"f\s*/", "shutter": r"1\s*/", "exposure": r"[-+−]"}       # of a value, before its number
SHORTEST, LONGEST = 2.0, 3000.0             # mm: a bare number of other sizes is no focal length
FASTEST_ISO = 100.0                         # from which a bare number may be an ISO speed

# Other words of photographers, opticians and the command line, by the entry that they find first
WORDS = {
    "Panel: Bokeh": "bokeh, blur disc, blur discs, out of focus highlights, background blur",
    "Panel: MTF": "sharpness, resolution, contrast, acuity, lp/mm, analyse, analyze",
    "Panel: Illumination": "vignette, vignetting, light falloff, dark corners, corner shading",
    "Panel: Depth of field": "depth of field, dof, depth of focus, hyperfocal",
    "Panel: Circle of confusion": "blur, coc, unsharpness",
    "Panel: Seidel": "aberrations, aberration, spherical aberration, coma, astigmatism",
    "Panel: Field curves": "distortion, barrel, pincushion, field curvature, lateral colour, chromatic aberration, "
                           "colour fringes",
    "Panel: Focus shift": "focus breathing, spherical focus",
    "Panel: Sunstar": "starburst, sun star, diffraction spikes",
    "Panel: Ghosts": "flare, lens flare, reflections",
    "Panel: Tolerances": "tolerances, manufacture, monte carlo",
    "Panel: Lens card": "info, check, details, specifications, patent",
    "Panel: Pixel": "trace, follow rays",
    "Panel: Models": "chart, accuracy, polynomial",
    "Panel: Light field": "lightfield, plenoptic, refocus",
    "Panel: Surfaces": "edit, prescription, design",
    "Panel: 3-D": "3d",
    "Improve lens…": "improve, optimise, optimize, optimisation, optimization",
    "Lens browser…": "lenses, library, change lens, choose lens",
    "Save lens…": "convert",
    "Export…": "render, high resolution",
    "Contact sheet…": "contact-sheet, compare lenses",
    "Scene: Still life": "scenes",
    "Save intrinsics…": "pbrt, mitsuba, blender, calibration",
    "Save picture…": "photo, take picture",
    "Keep snapshot": "remember, bookmark",
    "Copy state as text": "share, link",
    "Keys and mouse": "help, shortcuts, hotkeys, keyboard",
    "What the terms mean": "glossary, dictionary",
    "Reset camera": "recentre, home",
    "Exposure": "brightness, exposure compensation, ev",
    "Noise": "grain, sensor noise",
    "Tilt of the film": "scheimpflug, tilt shift",
    "Rise": "perspective control, keystone",
    "Samples": "quality",
}
ENTRIES = {word: entry for entry, words in WORDS.items() for word in words.split(", ")}

# What the lens browser shows for a use, and other words for it
USES = {
    "Portrait lenses": (Shelf(use="portrait"), "portrait lens"),
    "Landscape lenses": (Shelf(use="landscape"), "wide angle, wide lens, landscape lens"),
    "Standard lenses": (Shelf(length="40–65 mm", film="Full frame"), "normal lens, nifty fifty"),
    "Street lenses": (Shelf(use="street"), "street lens, reportage lens"),
    "Wildlife lenses": (Shelf(use="wildlife"), "wildlife lens, tele lens, telephoto lens, sports lens"),
    "Macro lenses": (Shelf(use="macro"), "macro lens, close up lens"),
    "Astro lenses": (Shelf(use="astro"), "astro lens, night sky"),
    "Cinema lenses": (Shelf(use="cinema"), "cinema lens, cine lens"),
    "Fisheye lenses": (Shelf(kind="fisheye"), "fisheye lens"),
    "Phone lenses": (Shelf(use="phone"), "phone lens, phone camera"),
    "Zoom lenses": (Shelf(zooms=True), "zoom lens"),
}
ENTRIES |= {word: name for name, (_, words) in USES.items() for word in words.split(", ")}


def bare_values(query: str) -> list[tuple[str, str]]:
    """The settings that a value without a name may be of, the likeliest first, each with the text of its value.

    A number without a unit is an f-number or an ISO speed where one is engraved, a focal length, or a distance.
    """
    text = query.strip().lower()
    for name, pattern in BARE.items():
        if re.fullmatch(pattern.replace("#", NUMBER), text):
            return [(name, re.sub(r"(.*\d)\s*iso", r"\1", text))]
    try:
        number, _ = read_number("#", text, "")
    except ValueError:
        return []
    names = (("f_number", number in F_NUMBERS), ("focal_length", SHORTEST <= number <= LONGEST),
             ("iso", number >= FASTEST_ISO and number in ISOS), ("focus_distance", True))
    return [(name, text) for name, is_usual in names if is_usual]


def begun_value(query: str) -> str:
    """The setting whose value has been begun, as “f/”; "" for none."""
    return next((name for name, pattern in BEGUN.items() if re.fullmatch(pattern, query.strip().lower())), "")


def shelf_of(length: str) -> Shelf:
    """What the lens browser shows for a focal length."""
    return Shelf(search=f"{significant(read_length(length))} mm")
