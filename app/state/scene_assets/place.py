"""Where files that a scene file names may lie: beside it or below."""

from pathlib import Path

import lensbench as lb
from lensbench.kernels.quotation import excerpt


def asset_path(name: str, folder: Path, what: str, most_bytes: int) -> Path:
    """The path of a file that a scene file names; SceneError where it is none, is too large or lies elsewhere.

    folder: of the scene file, resolved. what: word for the file in messages, such as "texture".
    """
    if Path(name).is_absolute() or "\0" in name:
        raise lb.SceneError(f"{what} {excerpt(name)}: name it relative to the scene file")
    try:
        path = (folder / name).resolve(strict=True)
    except (OSError, RuntimeError) as error:
        raise lb.SceneError(f"{what} {excerpt(name)}: there is no such file") from error
    if not path.is_relative_to(folder):
        raise lb.SceneError(f"{what} {excerpt(name)} lies outside the folder of the scene: put it beside the file or "
                            "below")
    if not path.is_file():
        raise lb.SceneError(f"{what} {excerpt(name)} is not a file: it is a folder, pipe, device or socket")
    if path.stat().st_size > most_bytes:
        raise lb.SceneError(f"{what} {excerpt(name)} is larger than {most_bytes >> 20} MB")
    return path
