"""What the picture of a scene shows otherwise than the scene says."""

import lensbench as lb
from lensbench.optics.finding import Finding, Kind
from lensbench.scenery.scene_steps import is_rough


def scene_findings(scene: lb.Scene) -> tuple[Finding, ...]:
    """Approximations that a picture of this scene makes and another renderer would not; see docs/scenes.md."""
    if isinstance(scene.sky, lb.ImageSky) and not scene.enclosed and is_rough(scene):
        return (Finding(Kind.SAMPLING, None, "coats of a gloss below 1 mirror the nearest sky of three colours, and "
                                             "not the picture of the sky"),)
    return ()
