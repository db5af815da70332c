# SPDX-License-Identifier: BSD-3-Clause
"""The scene over time in few bytes: positions as 16-bit numbers, fields as 8-bit numbers."""

import base64
from typing import Any

import numpy as np

from plotting.results import Frame, Results, Series, evenly
from plotting.scene import ScenePlot, label_of, scalar

MAX_BYTES = 1_500_000  # of all frames, before they become text
MAX_FRAMES, MIN_FRAMES = 80, 12
MAX_GROUND = 12_000  # triangles
FIELDS = ("displacement", "velocity", "excess_pore_pressure", "plastic_strain", "pressure")


def text_of(array: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")


class Packer:
    """Packs the frames of one scene, seen as scripts/plot sees it."""

    def __init__(self, results: Results) -> None:
        self.scene = ScenePlot(results, most_ground=MAX_GROUND)
        self.view = self.scene.view
        self.meshes = [self._mesh(structure) for structure in self.scene.structures]
        soil = self.scene.soil
        first = soil.frame(0) if soil else None
        self.fields = [name for name in FIELDS if first and name in first.fields][:3]
        self.num_points = len(first.points) if first else 0
        a_point = 4 + len(self.fields)
        a_frame = 4 * sum(len(used) for used, _ in self.meshes)
        a_frame += sum(16 * len(segments) for segments in self.scene.rigid_walls.at(self.scene.times[0]))
        for points in (self.num_points, 4000, 2000, 1000):
            self.num_points = min(self.num_points, points)
            frames = MAX_BYTES // max(1, a_frame + a_point * self.num_points)
            if frames >= min(MIN_FRAMES, len(self.scene.times)):
                break
        count = min(MAX_FRAMES, max(2, frames), len(self.scene.times))
        self.numbers = evenly(len(self.scene.times), count)

    def _mesh(self, structure: Series) -> tuple[np.ndarray, np.ndarray]:
        """Nodes that are seen, and faces of them."""
        first = structure.frame(0)
        faces = self.view.faces(first.points, first.cells)
        used, numbers = np.unique(faces, return_inverse=True)
        return used, numbers.reshape(faces.shape)

    def _places(self, points: np.ndarray) -> str:
        span = self.scene.high - self.scene.low
        share = np.clip((self.view.project(points) - self.scene.low) / span, 0, 1)
        return text_of(np.round(65535 * share).astype("<u2"))

    def _chosen(self, frame: Frame) -> np.ndarray:
        """Numbers of the points to draw, those behind first; the same in all frames as long as none is lost."""
        count = len(frame.points)
        keep = np.sort(np.random.default_rng(1).permutation(count)[: self.num_points])
        order = self.view.order(frame.points)
        return order[np.isin(order, keep)]

    def pack(self) -> dict[str, Any]:
        times = self.scene.times[self.numbers]
        packed = {"low": self.scene.low.tolist(), "high": self.scene.high.tolist(), "labels": self.view.labels,
                  "inverted": self.view.inverted, "times": times.tolist(),
                  "fields": [], "soil": [], "structures": []}
        if self.scene.soil:
            packed |= self._soil()
        for structure, (used, faces) in zip(self.scene.structures, self.meshes):
            frames = [self._places(structure.frame(structure.nearest(time)).points[used]) for time in times]
            packed["structures"].append({"corners": faces.shape[1], "faces": text_of(faces.astype("<u4")),
                                         "frames": frames})
        return packed | self._walls(times) | self._ground()

    def _ground(self) -> dict[str, Any]:
        """Triangles of the ground, those behind first: x, y of each corner, brightness of each triangle."""
        triangles, bright = self.scene.ground
        if not len(triangles):
            return {}
        span = self.scene.high - self.scene.low
        # those beyond the window are cut off by the canvas
        places = np.round(65535 * (triangles - self.scene.low) / span)
        return {"ground": {"corners": text_of(places.astype("<i4")),
                           "bright": text_of(np.round(255 * bright).astype("u1"))}}

    def _walls(self, times: np.ndarray) -> dict[str, Any]:
        """Lines of rigid walls and the strokes behind them, x1, y1, x2, y2 of each; which of them stand in each
        frame."""
        numbers: dict[tuple[str, str], int] = {}  # those at rest are there once
        frames = []
        for time in times:
            texts = [(text_of(segments.astype("<f4")), text_of(behind.astype("<f4")))
                     for segments, behind in self.scene.wall_lines(time)]
            frames.append([numbers.setdefault(text, len(numbers)) for text in texts])
        return {"walls": [{"line": line, "strokes": behind} for line, behind in numbers], "standing": frames}

    def _soil(self) -> dict[str, Any]:
        soil = self.scene.soil
        frames = [soil.frame(soil.nearest(time)) for time in self.scene.times[self.numbers]]
        chosen = [self._chosen(frame) for frame in frames]
        fields, values = [], []
        for name in self.fields:
            each = [scalar(frame.fields[name])[keep] for frame, keep in zip(frames, chosen)]
            every = np.concatenate(each)
            low, high = (float(np.nanpercentile(every, share)) for share in (0.5, 99.5))  # some fly far
            high = high if high > low else low + 1
            fields.append({"name": name.replace("_", " "), "low": low, "high": high,
                           "label": label_of(name, frames[0].fields[name])})
            shares = [np.clip((v - low) / (high - low), 0, 1) for v in each]
            values.append([text_of(np.round(255 * share).astype("u1")) for share in shares])
        count = len(frames[0].points)
        return {"fields": fields, "size": self.scene.size * max(1.0, count / max(1, self.num_points)) ** 0.5,
                "shown": self.num_points, "points": count,
                "soil": [{"points": self._places(frame.points[keep]), "values": [v[k] for v in values]}
                         for k, (frame, keep) in enumerate(zip(frames, chosen))]}


def scene_frames(results: Results) -> dict[str, Any] | None:
    """None where the folder has no frames. Raises ResultsError for frames that cannot be read."""
    if not results.soil and not results.structures:
        return None
    return Packer(results).pack()
