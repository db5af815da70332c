# SPDX-License-Identifier: BSD-3-Clause
"""Pictures that scripts/map has drawn of a run, for its page."""

import base64
import html
from pathlib import Path

SHOWN = {"depth": "depth at the end", "max_depth": "largest depth"}


def map_section(folder: Path, problems: list[str]) -> str:
    """Section with the maps of the results in a folder; empty: there are no maps, or older ones than the last frame,
    which is said."""
    paths = {name: folder / "map" / f"{name}.png" for name in SHOWN}
    found = {name: path for name, path in paths.items() if path.is_file()}
    if not found:
        return ""
    frames = folder / "mpm" / "soil.xdmf"
    if frames.exists() and min(path.stat().st_mtime for path in found.values()) < frames.stat().st_mtime:
        problems.append("Left out: the maps are older than the last frame; scripts/map draws them again.")
        return ""
    images = [f'<img alt="{html.escape(SHOWN[name])}" src="data:image/png;base64,'
              f'{base64.b64encode(path.read_bytes()).decode("ascii")}">' for name, path in found.items()]
    return "\n".join(['<section id="map">', "<h2>Map</h2>", *images, "</section>"])
