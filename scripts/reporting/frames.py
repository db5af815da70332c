# SPDX-License-Identifier: BSD-3-Clause
"""The scene over time in few bytes: positions as 16-bit numbers, fields as 8-bit numbers."""

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from plotting.results import Frame, Results, Series, evenly
from plotting.scene import ScenePlot, label_of, scalar
from plotting.space import camera_of
from plotting.view import FACES, cells_of_outer_faces, outer_faces
from reporting.rigid import boulder_bytes, packed_boulders, packed_walls, text_of
from reporting.solids import SolidColours

MAX_BYTES = 1_500_000  # of all frames, before they become text
MAX_FRAMES, MIN_FRAMES = 80, 12
MAX_GROUND = 12_000  # triangles
FIELDS = ("displacement", "velocity", "excess_pore_pressure", "plastic_strain", "pressure")


class Packer:
    """Packs the frames of one scene, seen as scripts/plot sees it; those of a scene in space in its three coordinates.
    """

    def __init__(self, results: Results) -> None:
        self.results = results
        self.scene = ScenePlot(results, most_ground=MAX_GROUND)
        self.view = self.scene.view
        solids = [structure for structure in self.scene.structures if len(structure.frame(0).cells)]
        self.plain = self.scene.beam_surfaces + self.scene.lines  # drawn as they are, without faces to be found
        self.structures = solids + self.plain
        self.meshes = [self._mesh(structure) for structure in self.structures]
        soil = self.scene.soil
        first = self.scene.first
        self.fields = [name for name in FIELDS if first and name in first.fields][:3]
        self.num_points = len(first.points) if first else 0
        a_place = 2 * results.dim
        a_point = a_place + len(self.fields)
        shapes, a_frame = boulder_bytes(results)
        a_frame += a_place * sum(len(used) for used, _ in self.meshes)
        self.colours = SolidColours(solids, [self._owners(structure) for structure in solids])
        a_frame += self.colours.bytes_of_frame
        a_frame += sum(16 * len(segments) for segments in self.scene.rigid_walls.at(self.scene.times[0]))
        for points in (self.num_points, 4000, 2000, 1000):
            self.num_points = min(self.num_points, points)
            frames = max(0, MAX_BYTES - shapes) // max(1, a_frame + a_point * self.num_points)
            if frames >= min(MIN_FRAMES, len(self.scene.times)):
                break
        count = min(MAX_FRAMES, max(2, frames), len(self.scene.times))
        self.numbers = evenly(len(self.scene.times), count)

    def _mesh(self, structure: Series) -> tuple[np.ndarray, np.ndarray]:
        """Nodes that are seen, and faces of them; in space from all sides."""
        first = structure.frame(0)
        if self._has_outer_faces(structure):
            faces = outer_faces(first.corners)
        else:
            faces = self._drawn(structure)
        used, numbers = np.unique(faces, return_inverse=True)
        return used, numbers.reshape(faces.shape)

    def _has_outer_faces(self, structure: Series) -> bool:
        return (self.view.dim == 3 and structure.frame(0).corners.shape[1] in FACES
                and structure not in self.plain)

    def _owners(self, structure: Series) -> np.ndarray:
        """The cell of each face of `_mesh`."""
        cells = structure.frame(0).corners
        return cells_of_outer_faces(cells) if self._has_outer_faces(structure) else np.arange(len(cells))

    def _drawn(self, structure: Series) -> np.ndarray:
        """Faces that the flat view draws, by their nodes."""
        first = structure.frame(0)
        return first.cells if structure in self.plain else self.view.faces(first.points, first.corners)

    def _front(self, structure: Series, used: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Numbers of the faces that the flat view draws, in their order."""
        number = {tuple(sorted(face)): k for k, face in enumerate(used[faces].tolist())}
        return np.array([number[tuple(sorted(face))] for face in self._drawn(structure).tolist()])

    def _set_box(self, clouds: list[np.ndarray]) -> None:
        """The box of the places: the window; in space that of all that moves."""
        if self.view.dim == 2:
            self.low, self.high = self.scene.low, self.scene.high
            return
        self.low = np.min([cloud.min(axis=0) for cloud in clouds], axis=0)
        self.high = np.max([cloud.max(axis=0) for cloud in clouds], axis=0)
        self.high = np.maximum(self.high, self.low + 1e-9 * np.ptp([self.low, self.high], axis=0).max())

    def _places(self, points: np.ndarray) -> str:
        share = np.clip((points[:, : len(self.low)] - self.low) / (self.high - self.low), 0, 1)
        return text_of(np.round(65535 * share).astype("<u2"))

    def _chosen(self, frame: Frame) -> np.ndarray:
        """Numbers of the points to draw, those behind first; the same in all frames as long as none is lost."""
        count = len(frame.points)
        keep = np.sort(np.random.default_rng(1).permutation(count)[: self.num_points])
        order = self.view.order(frame.points)
        return order[np.isin(order, keep)]

    def pack(self) -> dict[str, Any]:
        times = self.scene.times[self.numbers]
        soil = self.scene.soil
        frames = [soil.frame(soil.nearest(time)) for time in times] if soil else []
        moving = [[structure.frame(structure.nearest(time)).points[used] for time in times]
                  for structure, (used, _) in zip(self.structures, self.meshes)]
        clouds = [frame.points for frame in frames if len(frame.points)]  # all soil may have left
        if soil and not clouds:
            clouds = [self.scene.first.points]
        self._set_box(clouds + [points for each in moving for points in each])
        packed = {"low": self.scene.low.tolist(), "high": self.scene.high.tolist(), "labels": self.view.labels,
                  "box": [self.low.tolist(), self.high.tolist()], "across": self.view.across, "up": self.view.up,
                  "inverted": self.view.inverted, "times": times.tolist(),
                  "fields": [], "soil": [], "structures": [], "solids": [],
                  "boulders": packed_boulders(self.results, times)}
        if soil:
            packed |= self._soil(frames)
        for structure, (used, faces), places in zip(self.structures, self.meshes, moving):
            mesh = {"corners": faces.shape[1], "faces": text_of(faces.astype("<u4")),
                    "frames": [self._places(points) for points in places]}
            if self.view.dim == 3:
                mesh["front"] = text_of(self._front(structure, used, faces).astype("<u4"))
            packed["structures"].append(mesh)
        if self.colours.labels:
            packed["solids"], values = self.colours.pack(times)
            for mesh, each in zip(packed["structures"], values):  # solids stand first
                mesh["values"] = each
        if self.view.dim == 3:
            packed["space"] = self._space(times, clouds, moving)
        return packed | self._walls(times) | self._ground()

    def _space(self, times: np.ndarray, soil: list[np.ndarray], moving: list[list[np.ndarray]]) -> dict[str, Any]:
        """The first look of the view that turns: directions to the right, upwards (against gravity) and towards the
        eye; the box that it shows, without the few points that fly far; rigid walls. soil: points of frames that have
        some."""
        clouds = [np.percentile(points, [0.5, 99.5], axis=0) for points in soil]
        clouds += [points for each in moving for points in each]
        clouds += [faces.reshape(-1, 3) for time in times for faces in self.scene.boulders.at(time)]
        every = np.vstack([[cloud.min(axis=0), cloud.max(axis=0)] for cloud in clouds])
        camera = camera_of(self.results.gravity, np.ptp(every, axis=0), 0, 0)
        return {"right": camera.right.tolist(), "up": camera.up.tolist(), "eye": camera.eye.tolist(),
                "low": every.min(axis=0).tolist(), "high": every.max(axis=0).tolist(),
                "size": self._sphere_size(soil[0]) if soil else 0,
                "walls": packed_walls(self.results, times, MAX_GROUND)}

    def _sphere_size(self, points: np.ndarray) -> float:
        """Distance of points [m], in a lattice that of its six nearest; larger where not all of them are drawn.

        The extent of a body says less of it: one in a gully fills its box by a part only.
        """
        some = points[evenly(len(points), 2000)]
        near = cKDTree(points).query(some, k=min(7, len(points)))[0].reshape(len(some), -1)[:, -1]
        size = min(float(np.median(near)), self.scene.size) or self.scene.size
        return size * max(1.0, len(points) / max(1, self.num_points)) ** (1 / 3)

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

    def _soil(self, frames: list[Frame]) -> dict[str, Any]:
        chosen = [self._chosen(frame) for frame in frames]
        fields, values = [], []
        for name in self.fields:
            each = [scalar(frame.fields[name])[keep] for frame, keep in zip(frames, chosen)]
            every = np.concatenate(each)
            every = every if len(every) else np.zeros(1)
            low, high = (float(np.nanpercentile(every, share)) for share in (0.5, 99.5))  # some fly far
            high = high if high > low else low + 1
            fields.append({"name": name.replace("_", " "), "low": low, "high": high,
                           "label": label_of(name, frames[0].fields[name])})
            shares = [np.clip((v - low) / (high - low), 0, 1) for v in each]
            values.append([text_of(np.round(255 * share).astype("u1")) for share in shares])
        count = len(self.scene.first.points)
        return {"fields": fields, "size": self.scene.size * max(1.0, count / max(1, self.num_points)) ** 0.5,
                "shown": self.num_points, "points": count,
                "soil": [{"points": self._places(frame.points[keep]), "values": [v[k] for v in values]}
                         for k, (frame, keep) in enumerate(zip(frames, chosen))]}


def scene_frames(results: Results) -> dict[str, Any] | None:
    """None where the folder has no frames. Raises ResultsError for frames that cannot be read."""
    if not results.soil and not results.structures:
        return None
    return Packer(results).pack()
