"""A bicycle of tubes and rings. Built in the plane z = 0, mm, the ground at y = 0, the front wheel at +x."""

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.scenery.builtin.building_parts import joined, torus, tube
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.mesh import Mesh

REAR, FRONT, CRANK = np.array([-500.0, 335.0, 0.0]), np.array([510.0, 335.0, 0.0]), np.array([-75.0, 285.0, 0.0])
SEAT, HEAD, FORK = np.array([-215.0, 770.0, 0.0]), np.array([345.0, 800.0, 0.0]), np.array([378.0, 660.0, 0.0])
WHEEL, SPOKES = 318.0, 28
BEAM = (558.0, 730.0, 0.0)      # middle of the head light


def bicycle(turn: float, place: ArrayLike, paint: Material) -> list[Mesh]:
    """A bicycle turned about y (radians), its wheels below the middle at `place` (mm)."""
    steel, rubber = Material((0.80, 0.81, 0.83), "metal"), Material((0.022, 0.022, 0.024))
    leather = Material((0.16, 0.07, 0.03))
    side = np.array([0.0, 0.0, 1.0])

    def pipe(points: list, radius: float, material: Material, end: float = 1.0) -> Mesh:
        return tube(np.array(points), radius, material, end, sides=10, name="bicycle")

    parts = [pipe([SEAT, HEAD - [0.0, 12.0, 0.0]], 14.0, paint), pipe([CRANK, FORK], 16.0, paint),
             pipe([CRANK, SEAT], 15.0, paint), pipe([HEAD + [-8.0, 34.0, 0.0], FORK + [4.0, -18.0, 0.0]], 18.0, paint)]
    for s in (-1.0, 1.0):
        out = s * 62.0 * side
        parts += [pipe([CRANK + 0.4 * out, REAR + out], 9.0, paint, 0.8),
                  pipe([SEAT + 0.3 * out, REAR + out], 8.0, paint, 0.8)]
        t = np.linspace(0.0, 1.0, 9)[:, None]
        bow = FORK + (FRONT - FORK) * t + [0.0, -40.0, 0.0] * (t * (1.0 - t)) + out * np.minimum(0.5 + t, 1.0)
        parts.append(pipe(list(bow + np.array([-52.0, 0.0, 0.0]) * t * (1.0 - t)), 12.0, paint, 0.7))
        # Handlebar: out from the stem, back to the grip
        t = np.linspace(0.0, 1.0, 14)[:, None]
        bar = (HEAD + [30.0, 105.0, 0.0] + s * 290.0 * side * np.sin(np.minimum(t * 1.5, 1.0) * np.pi / 2.0)
               + np.array([-185.0, 25.0, 0.0]) * np.maximum(t - 0.35, 0.0) ** 1.5 * 1.7)
        parts += [pipe(list(bar), 11.0, steel), pipe(list(bar[-5:] + [0.0, 1.0, 0.0]), 16.0, leather)]
        # Crank arm and pedal
        arm = CRANK + s * 70.0 * side
        foot = arm + s * np.array([150.0, -75.0, 0.0])
        far, along = foot + s * 30.0 * side, np.array([42.0, 0.0, 0.0])
        parts += [pipe([CRANK, arm], 12.0, steel), pipe([arm, foot], 10.0, steel),
                  pipe([foot, far], 6.0, steel),
                  pipe([far - along, far + along], 15.0, rubber)]
    for hub in (REAR, FRONT):
        parts += [torus(hub, WHEEL, 17.0, rubber), torus(hub, WHEEL - 20.0, 8.0, steel),
                  pipe([hub - 66.0 * side, hub + 66.0 * side], 15.0, steel)]
        for k in range(SPOKES):
            at, across = 2.0 * np.pi * k / SPOKES, (22.0 if k % 2 else -22.0) * side
            lean = at + (0.9 if k // 2 % 2 else -0.9)
            parts.append(tube(np.stack([hub + across + 24.0 * np.array([np.cos(lean), np.sin(lean), 0.0]),
                                        hub + (WHEEL - 22.0) * np.array([np.cos(at), np.sin(at), 0.0])]), 1.6, steel,
                              1.0, 4, "bicycle"))
        # Mudguard
        low, high = (0.15, 1.05) if hub is REAR else (0.18, 0.72)
        turns = np.pi * np.linspace(low, high, 20)[:, None]
        parts.append(pipe(list(hub + (WHEEL + 32.0) * np.concatenate([np.cos(turns), np.sin(turns), 0.0 * turns], 1)),
                          14.0, steel))
    # Drive: chain wheel, chain; saddle on its post; stem; lamp
    parts += [torus(CRANK + 46.0 * side, 88.0, 5.0, steel), torus(CRANK + 46.0 * side, 52.0, 4.0, steel),
              torus(REAR + 46.0 * side, 38.0, 5.0, steel),
              *(pipe([CRANK + [0.0, s * 86.0, 46.0], REAR + [0.0, s * 37.0, 46.0]], 4.0, rubber) for s in (-1.0, 1.0)),
              pipe([SEAT, SEAT + [-38.0, 125.0, 0.0]], 12.0, steel),
              pipe([HEAD + [-8.0, 30.0, 0.0], HEAD + [-18.0, 95.0, 0.0], HEAD + [30.0, 105.0, 0.0]], 12.0, steel),
              pipe([SEAT + [-170.0, 150.0, 0.0], SEAT + [-150.0, 152.0, 0.0], SEAT + [-60.0, 146.0, 0.0],
                    SEAT + [60.0, 140.0, 0.0], SEAT + [105.0, 132.0, 0.0]], 62.0, leather, 0.25),
              pipe([HEAD + [40.0, 40.0, 0.0], np.array(BEAM) - [75.0, -10.0, 0.0]], 7.0, steel),
              pipe([np.array(BEAM) - [x, 0.0, 0.0] for x in (80.0, 40.0, 4.0)], 30.0, steel, 1.6)]
    return joined(parts, turn, place, "bicycle")
