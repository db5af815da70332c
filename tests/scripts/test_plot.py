#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/plot reads what a results folder holds and draws it."""

import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from matplotlib.collections import LineCollection
from script_case import ROOT, ScriptCase

import made_up_results as made_up
from plotting import boulders, contact, gauges, history
from plotting import scene as scenes
from plotting.column import compare_surface, failure_line, front_of, read_reference, surface_of
from plotting.envelope import envelope_rows, write_envelope
from plotting.results import Frame, Results, ResultsError, Series, Table
from plotting.scene import ScenePlot, point_size
from plotting.style import COLOURS, new_figure, plt
from plotting.summary import summary_lines
from plotting.stresses import von_mises
from plotting.view import View, cells_of_outer_faces, outer_faces, view_of
from plotting.walls import Walls, strokes, widened


class Reading(ScriptCase):
    def test_table(self) -> None:
        path = self.write("a.csv", "time,verdict,x\n0,converged,1e-3\n1,cut,\n2,conv")
        table = Table(path)
        self.assertEqual(table.num_rows, 2)  # the half row of a killed run is left out
        np.testing.assert_array_equal(table["time"], [0, 1])
        self.assertEqual(table["x"][0], 1e-3)
        self.assertTrue(np.isnan(table["x"][1]))
        self.assertEqual(list(table["verdict"]), ["converged", "cut"])
        with self.assertRaisesRegex(ResultsError, "no column y; there are time, verdict, x"):
            table["y"]

    def test_half_a_number_is_left_out(self) -> None:
        table = Table(self.write("a.csv", "time,x\n0,1e-3\n1,1e-"))
        np.testing.assert_array_equal(table["x"], [1e-3])
        self.assertEqual(Table(self.write("a.csv", "time,x")).num_rows, 0)

    def test_broken_table_is_refused(self) -> None:
        with self.assertRaisesRegex(ResultsError, "another number of cells"):
            Table(self.write("a.csv", "a,b\n1,2\n1\n1\n3,4\n"))

    def test_series_gives_back_what_was_written(self) -> None:
        made_up.write_series(self.folder, "structure", made_up.structure_frames())
        series = Series(self.folder / "structure.xdmf")
        time, points, cells, fields = made_up.structure_frames()[3]
        self.assertEqual(series.nearest(time + 0.01), 3)
        frame = series.frame(3)
        np.testing.assert_array_equal(frame.points, points)
        np.testing.assert_array_equal(frame.cells, cells)
        np.testing.assert_array_equal(frame.fields["displacement"], fields["displacement"])

    def test_every_structure_is_found(self) -> None:
        made_up.write_results(self.folder)
        made_up.write_series(self.folder / "fence", "structure", made_up.structure_frames())
        self.assertEqual([series.path.parent.name for series in Results(self.folder).structures], ["fem", "fence"])

    def test_moment_of_a_support_is_about_z_in_2d(self) -> None:
        for names, dim in (("structure.reaction_foot_x,structure.reaction_foot_y,structure.moment_foot_z", 2),
                           ("structure.moment_foot_x,structure.moment_foot_y,structure.moment_foot_z", 3),
                           ("structure.A.ux,structure.A.uy,structure.A.uz", 3)):
            folder = self.write(f"{len(names)}/probes.csv", f"time,{names}\n0,0,0,0\n").parent
            self.assertEqual(Results(folder).dim, dim, names)

    def test_missing_frame_is_named(self) -> None:
        made_up.write_series(self.folder, "soil", made_up.soil_frames())
        (self.folder / "soil_000002.h5").unlink()
        with self.assertRaisesRegex(ResultsError, "soil_000002.h5"):
            Series(self.folder / "soil.xdmf").frame(2)

    def test_half_a_frame_is_named(self) -> None:
        made_up.write_series(self.folder, "soil", made_up.soil_frames())
        frame = self.folder / "soil_000002.h5"
        frame.write_bytes(frame.read_bytes()[: frame.stat().st_size // 2])
        with self.assertRaisesRegex(ResultsError, "soil_000002.h5: .*truncated file"):
            Series(self.folder / "soil.xdmf").frame(2)


class Column(ScriptCase):
    def points(self) -> np.ndarray:
        """A wedge of height 0.1 (1 - x / 0.4) of points at distance 2 mm, and one stray grain."""
        x, y = np.meshgrid(np.arange(0.001, 0.4, 0.002), np.arange(0.001, 0.1, 0.002))
        inside = y < 0.1 * (1 - x / 0.4)
        return np.vstack([np.column_stack([x[inside], y[inside]]), [[0.5, 0.001]]])

    def test_surface_of_a_wedge(self) -> None:
        x, height = surface_of(self.points(), 0.002)
        covered = (x > 0.005) & (x < 0.38)
        np.testing.assert_allclose(height[covered], 0.1 * (1 - x[covered] / 0.4), atol=0.0025)

    def test_front_leaves_stray_grains_aside(self) -> None:
        self.assertAlmostEqual(front_of(self.points(), 0.002), 0.396, delta=0.004)

    def test_error_is_the_shift(self) -> None:
        measured = np.array([[x, 0.1 * (1 - x / 0.4) - 0.01] for x in np.linspace(0.01, 0.3, 20)])
        error = compare_surface(self.points(), 0.002, measured)
        self.assertAlmostEqual(error.mean_abs_m, 0.01, delta=0.002)
        self.assertGreaterEqual(error.max_abs_m, error.mean_abs_m)

    def test_failure_line_is_the_border_of_what_moved(self) -> None:
        start = self.points()[:-1]
        u = np.zeros((len(start), 3))
        u[start[:, 1] > 0.03, 0] = 0.05  # soil above 3 cm went 5 cm
        points = np.column_stack([start, np.zeros(len(start))]) + u
        last = Frame(1.0, points, None, {"displacement": u})
        # At 0.36 m the wedge is 1 cm high and all of it stayed.
        line = failure_line(last, np.array([0.05, 0.1, 0.36]), 2e-3, 0.002)
        np.testing.assert_allclose(line, [0.03, 0.03, 0.01], atol=1e-3)
        with self.assertRaisesRegex(ResultsError, "no soil at x = 0.5 m at the start"):
            failure_line(last, np.array([0.5]), 2e-3, 0.002)

    def test_reference_of_the_scene(self) -> None:
        series = read_reference(ROOT / "configs/column_collapse/data/bui2008_column_collapse.csv")
        surface = series["exp_surface"]
        self.assertLess(surface[0, 0], 0.01)
        self.assertAlmostEqual(surface[0, 1], 0.1, delta=0.002)
        self.assertTrue((np.diff(surface[:, 0]) > 0).all())

    def test_reference_that_cannot_be_read(self) -> None:
        with self.assertRaisesRegex(ResultsError, "nowhere.csv: No such file"):
            read_reference(self.folder / "nowhere.csv")
        table = self.folder / "bad.csv"
        table.write_text("series,x,height\nexp_surface,0.1\n")
        with self.assertRaisesRegex(ResultsError, r"bad.csv: found a row \['exp_surface', '0.1'\]"):
            read_reference(table)


class Space(ScriptCase):
    """The plane in which a scene in space is drawn."""

    def test_plane_holds_gravity_and_the_longest_horizontal_extent(self) -> None:
        for gravity, extent, axes in (
            ([0, 0, -9.81], [3, 2, 9], (0, 2)),
            ([0, 0, -9.81], [2, 3, 9], (1, 2)),
            ([0, -9.81, 0], [2, 9, 3], (2, 1)),
            ([-9.81, 0, 0], [9, 2, 3], (2, 0)),
            ([0, 3.0, -9.3], [9, 1, 1], (1, 2)),  # a slope: the direction of the slide
            ([0, 0, 0], [1, 2, 9], (1, 2)),
            (None, [2, 1, 9], (0, 2)),
        ):
            view = view_of(3, gravity, np.array(extent))
            self.assertEqual((view.across, view.up), axes)
            self.assertFalse(view.inverted)
        self.assertTrue(view_of(3, [0, 0, 9.81], np.ones(3)).inverted)
        self.assertEqual(view_of(2, [-9.81, 0], np.array([1, 5])), View(0, 1))

    def test_nearest_point_is_drawn_last(self) -> None:
        points = np.array([[0.0, 0, 0], [1, 2, 3], [2, 1, 1]])
        self.assertEqual(list(View(0, 2, dim=3).order(points)), [1, 2, 0])  # seen from -y
        self.assertEqual(list(View(0, 2, True, 3).order(points)), [0, 2, 1])
        self.assertEqual(list(View(1, 2, dim=3).order(points)), [0, 1, 2])  # seen from +x

    def test_faces_of_meshes(self) -> None:
        x, y, z = np.meshgrid([0, 1, 2], [0, 1], [0, 1], indexing="ij")
        points = np.column_stack([x.ravel(), y.ravel(), z.ravel()]).astype(float)
        brick = np.array([[0, 4, 6, 2, 1, 5, 7, 3]])
        bricks = np.vstack([brick, brick + 4])
        self.assertEqual(len(outer_faces(bricks)), 10)
        for view, depth in ((View(0, 2, dim=3), 0), (View(0, 2, True, 3), 1)):
            faces = view.faces(points, bricks)
            self.assertEqual(len(faces), 2)
            np.testing.assert_array_equal(points[faces][:, :, 1], depth)
        tetrahedron = np.array([[0, 4, 2, 1]])  # its faces x = 0, y = 0 and z = 0, and the inclined one
        np.testing.assert_array_equal(np.sort(View(0, 2, dim=3).faces(points, tetrahedron)), [[0, 1, 4]])
        np.testing.assert_array_equal(np.sort(View(1, 2, dim=3).faces(points, tetrahedron)), [[1, 2, 4]])

    def shown(self, folder: Path) -> tuple[tuple[str, str], np.ndarray, np.ndarray]:
        """Labels, window and corners of the wall as drawn at the end."""
        scene = ScenePlot(Results(folder))
        figure, (axes,) = new_figure()
        scene.draw(axes, made_up.END)
        wall = np.vstack([path.vertices for path in axes.collections[1].get_paths()])
        plt.close(figure)
        return scene.view.labels, np.array([scene.low, scene.high]), wall

    def test_scene_is_seen_from_the_side(self) -> None:
        made_up.write_results(self.folder / "flat")
        _, window, wall = self.shown(self.folder / "flat")
        for up, label in ((1, "y [m]"), (2, "z [m]")):
            folder = made_up.write_space_results(self.folder / f"up{up}", up)
            labels, window_in_space, wall_in_space = self.shown(folder)
            self.assertEqual(labels, ("x [m]", label))
            np.testing.assert_allclose(window_in_space, window)
            np.testing.assert_allclose(np.unique(wall_in_space, axis=0), np.unique(wall, axis=0))

    def test_scene_is_seen_from_above(self) -> None:
        folder = made_up.write_space_results(self.folder / "a", 2)
        view = ScenePlot(Results(folder), plane="xy").view
        self.assertEqual(view.labels, ("x [m]", "y [m]"))
        self.assertEqual(list(view.order(np.array([[0.0, 0, 3], [1, 2, 1], [2, 1, 2]]))), [1, 2, 0])
        with self.assertRaisesRegex(ResultsError, "only scenes in 3D"):
            ScenePlot(Results(made_up.write_results(self.folder / "flat")), plane="xy")

    def test_without_gravity_the_last_axis_is_up(self) -> None:
        folder = made_up.write_space_results(self.folder / "a", 2, gravity=None)
        self.assertIsNone(Results(folder).gravity)
        self.assertEqual(self.shown(folder)[0], ("x [m]", "z [m]"))

    def test_size_of_points_in_a_thin_slice(self) -> None:
        points = np.stack(np.meshgrid(np.arange(40), np.arange(20), np.arange(2)), -1).reshape(-1, 3)
        for cloud in (points, points[points[:, 2] == 0]):
            self.assertAlmostEqual(point_size(0.01 * cloud, 3), 0.01, delta=1e-6)


class RigidWalls(ScriptCase):
    def setUp(self) -> None:
        super().setUp()
        folder = made_up.write_rigid_walls(made_up.write_contact(made_up.write_results(self.folder / "a")))
        self.scene = ScenePlot(Results(folder))

    def test_each_is_where_it_is_as_long_as_it_acts(self) -> None:
        for time, lid in ((0, 0.2), (0.2, 0.18), (0.3, None)):
            bed, *others = self.scene.rigid_walls.at(time)
            np.testing.assert_allclose(bed, [[[9, 0], [0.1, 0]], [[0.1, 0], [-9, 0]]])
            self.assertEqual(len(others), lid is not None)
            for segments in others:
                np.testing.assert_allclose(segments, [[[0, lid], [0.1, lid]], [[0.1, lid], [0.2, lid]]], rtol=1e-12)

    def test_strokes_are_on_the_side_without_soil(self) -> None:
        bed, lid = self.scene.rigid_walls.at(0)
        behind = strokes(lid, 0.25)
        np.testing.assert_allclose(np.diff(behind[:, 0, 0]), 0.005)
        self.assertTrue((behind[:, 0, 1] == 0.2).all())
        self.assertTrue((behind[:, 1, 1] > 0.2).all())
        self.assertTrue((strokes(bed, 0.25)[:, 1, 1] < 0).all())
        self.assertEqual(len(strokes(lid, 1e3)), 1)

    def test_window_holds_the_short_wall_and_some_of_the_long_one(self) -> None:
        low, high = widened(np.array([0, 0]), np.array([1, 0.5]), [np.array([[[-9, 0.2], [9, 0.2]]])])
        np.testing.assert_allclose([low, high], [[-1 / 7, 0], [8 / 7, 0.5]])
        low, high = widened(low, high, [np.array([[[0.5, 0.5], [0.5, 0.9]]])])
        np.testing.assert_allclose([low[1], high[1]], [0, 0.9])
        self.assertGreater(self.scene.high[1], 0.2)

    def test_lines_in_the_picture(self) -> None:
        for time, count in ((0, 2), (made_up.END, 1)):
            figure, (axes,) = new_figure()
            self.scene.draw(axes, time)
            lines = [c for c in axes.collections if isinstance(c, LineCollection)]
            self.assertEqual(len(lines), 1 + 2 * count)  # the outline of the structure at the start is one
            plt.close(figure)

    def test_none_without_rigid_walls_and_in_space(self) -> None:
        for write in (made_up.write_results, made_up.write_space_results):
            self.assertEqual(len(Walls(Results(write(self.folder / write.__name__)))), 0)


class Drawing(ScriptCase):
    def draw(self, *arguments: object) -> list[str]:
        result = self.python_script("plot", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        paths = [Path(line) for line in result.stdout.splitlines() if line.endswith((".png", ".gif"))]
        for path in paths:
            self.assertGreater(path.stat().st_size, 5000)
        return [path.name for path in paths]

    def test_everything(self) -> None:
        made_up.write_results(self.folder / "a")
        self.assertEqual(
            self.draw(self.folder / "a"),
            ["probes.png", "residuals.png", "iterations.png", "forces.png", "energies.png", "scene.png"],
        )

    def test_step_sizes_that_vary_much_are_drawn_on_a_logarithmic_scale(self) -> None:
        for smallest, scale in ((0.3, "linear"), (0.2, "log")):
            self.write("steps.csv", f"time,dt,iterations\n1,1,3\n{1 + smallest},{smallest},2\n")
            with mock.patch.object(history, "save", lambda figure, path: figure):
                figure = history.plot_iterations(Results(self.folder), self.folder)
            self.assertEqual(figure.axes[1].get_yscale(), scale)

    def test_instants_of_tall_scenes_stand_in_pairs(self) -> None:
        view = ScenePlot(Results(made_up.write_results(self.folder / "a")))
        for tall, shape in ((scenes.TALL, (3, 1)), (0, (2, 2))):
            with (mock.patch.object(scenes, "save", lambda figure, path: figure),
                  mock.patch.object(scenes, "TALL", tall)):
                figure = scenes.plot_scene(view, [0, 0.2, 0.4], self.folder)
            self.assertEqual(figure.axes[0].get_subplotspec().get_gridspec().get_geometry(), shape)
            self.assertEqual([axes.get_title(loc="left") for axes in figure.axes[:3]],
                             ["t = 0 s", "t = 0.2 s", "t = 0.4 s"])
            self.assertEqual(figure.axes[2].get_xlabel(), "x [m]")
            plt.close(figure)

    def test_everything_in_space(self) -> None:
        made_up.write_space_results(self.folder / "a")
        drawn = self.draw(self.folder / "a", "--animate", "--field", "displacement")
        self.assertEqual(drawn[-2:], ["scene.png", "scene.gif"])

    def test_run_without_contact_has_no_residuals_to_draw(self) -> None:
        folder = made_up.write_results(self.folder / "a")
        head, *rows = (folder / "iterations.csv").read_text(encoding="utf-8").splitlines()
        zero = [i for i, name in enumerate(head.split(",")) if "residual" in name]
        for k, row in enumerate(rows):
            cells = row.split(",")
            for i in zero:
                cells[i] = "0"
            rows[k] = ",".join(cells)
        self.write("a/iterations.csv", "\n".join([head, *rows, ""]))
        self.assertNotIn("residuals.png", self.draw(folder))

    def test_choices(self) -> None:
        a, b = (made_up.write_results(self.folder / name) for name in "ab")
        self.assertEqual(self.draw(a, "--residuals"), ["residuals.png"])
        self.assertEqual(self.draw(a, "--compare", b, "--labels", "one", "two"), ["compare.png"])

    def test_unknown_field_names_the_known_ones(self) -> None:
        result = self.python_script("plot", made_up.write_results(self.folder / "a"), "--field", "colour")
        self.assertEqual(result.returncode, 2)
        self.assertIn("no field colour; there are displacement, plastic_strain", result.stderr)

    def test_instant_outside_the_run(self) -> None:
        folder = made_up.write_results(self.folder / "a")
        for time in ("99", "-1", "nan"):
            for more in ([], ["--space"]):
                result = self.python_script("plot", folder, "--times", "0.3", time, *more)
                self.assertEqual(result.returncode, 2)
                self.assertIn(f"--times: found {time}, allowed: 0 to 0.5 s", result.stderr)
        self.assertFalse((folder / "plots").exists())

    def test_full_disk(self) -> None:
        folder = made_up.write_results(self.folder / "a")
        with self.full_disk(3000):
            result = self.python_script("plot", folder)
        self.assertEqual((result.returncode, result.stderr), (2, f"scripts/plot: {folder}/plots: File too large\n"))

    def test_empty_folder(self) -> None:
        result = self.python_script("plot", self.folder)
        self.assertEqual(result.returncode, 2)
        self.assertIn("nothing to draw", result.stderr)

    def test_summary(self) -> None:
        text = "\n".join(summary_lines(Results(made_up.write_results(self.folder / "a"))))
        self.assertIn("completed at t = 0.5 s in 12.5 s", text)
        self.assertIn(f"largest {2e3 * made_up.AMPLITUDE:.4g} mm", text)
        self.assertIn("horizontal force on the structure: largest 20 N/m", text)
        self.assertIn("impulse 7 N s/m", text)  # 20 N/m through 0.3 s

    def test_summary_of_small_displacements(self) -> None:
        folder = made_up.write_results(self.folder / "a")
        for middle, end, words in (
            (8.7562e-3, 7.65249e-3, "largest 8.756 mm at t = 0.5 s, at the end 7.652 mm"),
            (-9.1237e-6, -1e-12, "largest -0.009124 mm at t = 0.5 s, at the end -1e-09 mm"),
            (-0.0, -0.0, "largest 0 mm at t = 0 s, at the end 0 mm"),
        ):
            rows = [[0, 0], [0.5, middle], [1, end]]
            made_up.write_table(folder / "probes.csv", ["time", "structure.A.ux"], rows)
            self.assertIn(f"structure.A.ux: {words}", "\n".join(summary_lines(Results(folder))))

    def test_envelope(self) -> None:
        folder = made_up.write_results(self.folder / "a")
        names = ["time", "wall.ux", "soil.front"]
        made_up.write_table(folder / "probes.csv", names, [[0, 0, ""], [0.5, -3, ""], [1, 2, 7], [1.5, 2, 6]])
        rows = envelope_rows(Results(folder))
        self.assertEqual(rows[0], ["wall.ux", "-3", "0.5", "2", "1", "2"])
        self.assertEqual(rows[1], ["soil.front", "6", "1.5", "7", "1", "6"])
        path = write_envelope(Results(folder), self.folder)
        self.assertEqual(path.read_text(encoding="utf-8").splitlines()[1], ",".join(rows[0]))
        made_up.write_table(folder / "probes.csv", names, [])
        self.assertIsNone(write_envelope(Results(folder), self.folder))

    def test_summary_of_rigid_walls(self) -> None:
        folder = made_up.write_results(self.folder / "a")
        names = ["time", "wall.left.fx", "lid.fx", "lid.fy", "lid.mz"]
        made_up.write_table(folder / "probes.csv", names, [[0, 0, 0, 0, 0], [0.5, 9, 1, -8, 1], [1, 9, 2, -6, 1]])
        text = "\n".join(summary_lines(Results(folder)))
        self.assertIn("vertical force on lid: largest -8 N/m at t = 0.5 s, at the end -6 N/m", text)
        self.assertNotIn("wall.left", text)

    def test_summary_in_space(self) -> None:
        folder = made_up.write_results(self.folder / "a")
        made_up.write_table(folder / "steps.csv", ["step", "time", "dt", "fx", "fy", "fz"],
                            [[1, 0.5, 0.5, 1, 0, -2], [2, 1.0, 0.5, 1, 0, -4]])
        text = "\n".join(summary_lines(Results(folder)))
        self.assertIn("z force on the structure: largest -4 N at t = 1 s, impulse -3 N s", text)
        self.assertNotIn("N/m", text)


class Contact(ScriptCase):
    """Pressure on interfaces and rigid walls."""

    def profile(self) -> tuple[contact.Profile, Series]:
        made_up.write_contact(self.folder)
        series = contact.contact_series(Results(self.folder))["wall"]
        return contact.profile_of(series.frame(0), 2, 1), series

    def test_a_wall_has_a_row_for_each_face_over_its_height(self) -> None:
        """Faces to -x and +x and a crest of a thin wall; soil on the first alone: one row, foot at the bottom."""
        points = np.array([[0.2, 0, 0], [0.2, 0.5, 0], [0.2, 1, 0], [0, 1, 0], [0, 0.75, 0], [0, 0, 0]])
        cells = np.column_stack([np.arange(5), np.arange(1, 6)])
        made_up.write_series(self.folder / "mpm", "contact_thin", [
            (time, points, cells, {"pressure": time * np.array(pressed)})
            for time, pressed in ((0.0, [0] * 5), (1.0, [0, 0, 9, 3, 7]), (2.0, [0, 0, 9, 5, 6]))])
        run = Results(self.folder)
        with mock.patch.object(contact, "save", side_effect=lambda figure, path: figure):
            figure = contact.plot_contact(run, "thin", run.contacts["thin"], None, self.folder)
        left, right = figure.axes[:2]
        self.assertEqual((right.get_title(loc="left"), left.get_ylabel()),
                         ("thin, side -x", "height above its foot [m]"))
        last = [patch.get_data() for patch in left.patches][-1]
        np.testing.assert_allclose(last.values, [12, 10])
        np.testing.assert_allclose(last.edges, [0, 0.625, 1])
        contact.plt.close(figure)

    def test_cells_of_second_order_are_drawn_by_their_corners(self) -> None:
        nodes = np.arange(20)[None]
        for kind, count in (("Triangle_6", 3), ("Quadrilateral_8", 4), ("Tetrahedron_10", 4), ("Hexahedron_20", 8),
                            ("Hexahedron", 20), ("", 20)):
            frame = Frame(0.0, np.zeros((20, 3)), nodes, {}, kind=kind)
            np.testing.assert_array_equal(frame.corners, nodes[:, :count])

    def test_equivalent_stress(self) -> None:
        """Uniaxial tension s gives s, pure shear t sqrt(3) t, pressure 0."""
        stress = np.array([[5.0, 0, 0, 0, 0, 0], [0, 2, 0, 0, 0, 0], [0, 0, 0, 0, 2, 0], [-3, 0, 0, -3, 0, -3]])
        np.testing.assert_allclose(von_mises(stress), [5, 2 * np.sqrt(3), 2 * np.sqrt(3), 0], atol=1e-12)

    def test_outer_faces_know_their_cells(self) -> None:
        bricks = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]])
        for face, cell in zip(outer_faces(bricks), cells_of_outer_faces(bricks), strict=True):
            self.assertLessEqual(set(face), set(bricks[cell]))

    def test_upright_line_is_drawn_by_height(self) -> None:
        profile, series = self.profile()
        self.assertEqual(profile.label, "y [m]")
        np.testing.assert_allclose(profile.edges, np.linspace(0, 0.1, 11), atol=1e-12)
        mean = profile.mean(series.frame(5).fields["pressure"])
        np.testing.assert_allclose(mean, 500 * (1 - (np.arange(10) + 0.5) / 10), rtol=1e-6)

    def test_bent_line_is_drawn_by_length(self) -> None:
        points = np.array([[1.0, 0, 0], [1, 2, 0], [0, 2, 0], [0, 0, 0]])
        frame = Frame(0.0, points, np.array([[1, 2], [0, 1], [2, 3]]), {})
        profile = contact.profile_of(frame, 2, 1)
        np.testing.assert_allclose(profile.edges, [0, 2, 3, 5])
        np.testing.assert_array_equal(profile.mean(np.array([1.0, 2, 3])), [2, 1, 3])
        self.assertEqual(profile.corners, (2, 3))

    def test_wall_in_space_is_drawn_by_height(self) -> None:
        y, z = np.meshgrid([0.0, 1, 3], [0.0, 1, 2], indexing="ij")
        points = np.column_stack([np.zeros(9), y.ravel(), z.ravel()])
        cells = np.array([[0, 3, 4, 1], [1, 4, 5, 2], [3, 6, 7, 4], [4, 7, 8, 5]])
        profile = contact.profile_of(Frame(0.0, points, cells, {}), 3, 2)
        self.assertEqual(profile.label, "z [m]")
        # Areas 1 and 2 in each of the two rows.
        np.testing.assert_allclose(profile.mean(np.array([3.0, 1, 6, 4])), [5, 3])

    def test_the_top_of_a_post_has_no_interval_of_its_own(self) -> None:
        x, z = np.meshgrid([0.0, 1], [0.0, 1, 2, 3], indexing="ij")
        front = np.column_stack([x.ravel(), np.zeros(8), z.ravel()])
        points = np.vstack([front, front + [0, 1, 0]])
        cells = np.array([[0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 15, 11]])
        profile = contact.profile_of(Frame(0.0, points, cells, {}), 3, 2)
        np.testing.assert_allclose(profile.edges, [0, 1, 2, 3])
        np.testing.assert_allclose(profile.mean(np.array([3.0, 2, 1, 0])), [3, 2, 0.5])

    def test_a_closed_line_is_followed_once(self) -> None:
        np.testing.assert_array_equal(contact.chain(np.array([[2, 0], [0, 1], [1, 2]])), [0, 1, 2])

    def test_times(self) -> None:
        profile, series = self.profile()
        pressure = np.array([profile.mean(series.frame(k).fields["pressure"]) for k in range(6)])
        np.testing.assert_array_equal(contact._chosen(series, pressure, None), [2, 3, 4, 5])
        np.testing.assert_array_equal(contact._chosen(series, pressure, [0.11, 0.5]), [1, 5])

    def test_pictures(self) -> None:
        folder = made_up.write_results(self.folder / "a")
        made_up.write_contact(folder)
        made_up.write_contact(folder, "never", first=9)
        result = self.python_script("plot", folder, "--times", "0.3", "0.5")
        self.assertEqual(result.stderr, "")
        drawn = [Path(line) for line in result.stdout.splitlines() if "contact" in line]
        self.assertEqual([path.name for path in drawn], ["contact_wall.png"])
        self.assertGreater(drawn[0].stat().st_size, 5000)


class Gauges(ScriptCase):
    def test_a_panel_a_quantity_and_a_colour_a_gauge(self) -> None:
        columns = ["depth", "top", "normal_speed", "max_speed", "section_flux", "passed_mass", "pressure",
                   "dynamic_pressure"]
        head = ["time", "soil.mass", *(f"soil.{gauge}.{name}" for gauge in ("toe", "top") for name in columns)]
        made_up.write_table(self.folder / "probes.csv", head, [[t, 1, *range(t, t + 16)] for t in range(3)])
        self.assertEqual(gauges.gauge_names(Table(self.folder / "probes.csv")), ["soil.toe", "soil.top"])
        with mock.patch.object(gauges, "save", lambda figure, path: figure):
            figure = gauges.plot_gauges(Results(self.folder), self.folder)
        self.addCleanup(plt.close, figure)
        toe, toe_top, top, _, _ = figure.axes[0].get_lines()
        self.assertEqual([toe.get_color(), toe_top.get_color(), top.get_color()], [*COLOURS[:1] * 2, COLOURS[1]])
        np.testing.assert_array_equal(top.get_ydata(), [8, 9, 10])
        self.assertEqual(len(figure.axes[3].get_lines()), 3)  # mass and zero

    def test_a_run_without_gauges(self) -> None:
        run = Results(made_up.write_results(self.folder / "a"))
        self.assertIsNone(gauges.plot_gauges(run, self.folder))


class Curves(ScriptCase):
    """Contents of the figures of curves."""

    def axes_of(self, plot, *arguments: object) -> list:
        """The axes that `plot` made."""
        figures = []
        with mock.patch.object(history, "save", lambda figure, path: figures.append(figure) or path):
            plot(*arguments, self.folder)
        self.addCleanup(plt.close, figures[0])
        return figures[0].axes

    def titles(self, axes: list) -> list[str]:
        return [each.get_title(loc="left") for each in axes]

    def test_probes_without_round_off(self) -> None:
        run = Results(made_up.write_space_results(self.folder / "a"))  # its uy is 1e-9 of ux
        axes = self.axes_of(history.plot_probes, {"a": run})
        self.assertEqual(self.titles(axes), ["point A, x", "point A, vertical (z)"])

    def test_vertical_meets_vertical(self) -> None:
        flat = Results(made_up.write_results(self.folder / "flat"))
        for up, title in ((1, "point A, vertical (y)"), (2, "point A, vertical (y/z)")):
            space = Results(made_up.write_space_results(self.folder / f"space{up}", up))
            if up == 1:  # the vertical displacement to y
                table = self.folder / "space1" / "probes.csv"
                text = table.read_text(encoding="utf-8")
                table.write_text(text.replace("uy,structure.A.uz", "uz,structure.A.uy"), encoding="utf-8")
            axes = self.axes_of(history.plot_probes, {"flat": flat, "space": space})
            self.assertEqual(self.titles(axes), ["point A, x", title])
            first, second = axes[1].get_lines()
            np.testing.assert_array_equal(first.get_ydata(), second.get_ydata())

    def test_residuals_of_some_steps(self) -> None:
        run = Results(made_up.write_results(self.folder / "a", iterations=5))
        axes = self.axes_of(history.plot_residuals, run)
        right = next(each for each in axes if each.get_xlabel() == "iteration within the step")
        self.assertIn("steps 145 to 157", [each.get_title(loc="left") for each in axes])
        lines = [line.get_xydata() for line in right.get_lines() if line.get_linestyle() == "-"]
        longest = max(lines, key=len)
        np.testing.assert_array_equal(longest[:, 0], range(5))
        self.assertEqual(right.get_xlim()[1] // 1, 4)

    def test_energies_without_round_off(self) -> None:
        folder = made_up.write_results(self.folder / "a")
        names = ["time", "soil.gravity_work", "soil.wall_loss", "soil.damping"]
        made_up.write_table(folder / "probes.csv", names, [[0, 0, 0, 0], [0.5, 7, 6e-12, 8e-12]])
        axes = self.axes_of(history.plot_energies, Results(folder))
        self.assertEqual([text.get_text() for text in axes[0].get_legend().get_texts()],
                         ["soil gravity work", "soil damping", "soil kinetic energy"])

    def test_forces_and_moments_of_interfaces(self) -> None:
        head = ["time", "fx", "fy", "wall.fx", "wall.fy", "wall.mz", "net.fx", "net.fy", "net.mz"]
        legend = {"one": ["fx", "fy"], "two": ["fx", "fy", "wall fx", "wall fy", "net fx", "net fy"]}
        for interfaces, forces in legend.items():
            names = head if interfaces == "two" else head[:6]
            made_up.write_table(self.folder / "steps.csv", names, [[t, *range(len(names) - 1)] for t in range(2)])
            run = Results(self.folder)
            shown = [[[text.get_text() for text in axes.get_legend().get_texts()] for axes in self.axes_of(plot, run)]
                     for plot in (history.plot_forces, history.plot_moments)]
            # Moments have a panel, and so a scale, for each surface.
            self.assertEqual(shown, [[forces], [["wall mz"]] if interfaces == "one" else [["wall mz"], ["net mz"]]])

    def test_forces_on_walls(self) -> None:
        names = ["time", "soil.wall.left.fx", "soil.wall.left.fy", "soil.lid.fx", "soil.lid.mz", "member.fx"]
        made_up.write_table(self.folder / "probes.csv", names, [[0, 0, 0, 0, 0, 0], [1, 2, 0, 3, 1, 5]])
        axes = self.axes_of(history.plot_wall_forces, Results(self.folder))
        self.assertEqual([text.get_text() for text in axes[0].get_legend().get_texts()],
                         ["soil wall left fx", "soil lid fx"])

    def test_forces_and_moments_of_sections(self) -> None:
        names = ["time", "wall.foot.N", "wall.foot.V_x", "wall.foot.M_z", "wall.A.ux", "MASS.N_A"]
        made_up.write_table(self.folder / "probes.csv", names, [[0, 0, 0, 0, 0, 0], [1, 2, 3, 4, 5, 6]])
        axes = self.axes_of(history.plot_sections, Results(self.folder))
        self.assertEqual([[text.get_text() for text in each.get_legend().get_texts()] for each in axes],
                         [["wall foot N", "wall foot V x"], ["wall foot M z"]])

    def test_boulders_are_no_walls(self) -> None:
        own = ["x", "y", "vx", "vy", "wz", "qw", "qx", "qy", "qz", "kinetic_energy", "fx", "fy", "mz"]
        names = ["time", *(f"soil.{stone}.{column}" for stone in ("block", "ball") for column in own), "soil.lid.fx",
                 "soil.lid.mz"]
        made_up.write_table(self.folder / "probes.csv", names, [[t, *range(len(names) - 1)] for t in range(2)])
        run = Results(self.folder)
        self.assertEqual(boulders.boulder_names(run.table("probes.csv")), ["soil.block", "soil.ball"])
        self.assertEqual(history.wall_columns(run.table("probes.csv")), ["soil.lid.fx"])
        with mock.patch.object(boulders, "save", lambda figure, path: figure):
            figure = boulders.plot_boulders(run, self.folder)
        speed = figure.axes[1].get_lines()
        self.assertEqual([line.get_label() for line in speed], ["block", "ball"])
        np.testing.assert_allclose(speed[0].get_ydata(), np.hypot(2, 3))
        self.assertIsNone(boulders.plot_boulders(Results(made_up.write_results(self.folder / "none")), self.folder))

    def test_surfaces_of_boulders_have_no_picture_of_pressure(self) -> None:
        made_up.write_results(self.folder)
        for name in ("wall", "stone", "rock_1", "rock_12", "rock_bed"):
            (self.folder / "mpm" / f"contact_{name}.xdmf").touch()
        run = Results(self.folder)
        settings = {"boulders": [{"name": "stone"}, {"name": "unseen"}], "random_boulders": [{"name": "rock"}]}
        with mock.patch.object(Results, "settings", return_value=settings), \
                mock.patch("plotting.results.Series"), \
                mock.patch.object(contact, "plot_contact", side_effect=lambda _, name, *__: name):
            self.assertEqual(run.boulders, ["stone", "rock_1", "rock_12"])
            self.assertEqual(set(contact.plot_contacts(run, None, self.folder)) & {"stone", "rock_1", "rock_12"}, set())
            self.assertLessEqual({"wall", "rock_bed"}, set(contact.plot_contacts(run, None, self.folder)))

    def test_parts_of_boulders_stand_beside_the_force(self) -> None:
        names = ["time", "soil.rock_1.qw", "soil.rock_1.kinetic_energy", "soil.boulders_kinetic_energy", "soil.lid.fx",
                 "soil.lid.mz", "soil.wall.boulders_fx", "soil.wall.boulders_fy", "soil.lid.boulders_fx"]
        made_up.write_table(self.folder / "probes.csv", names, [[t, *range(7), t * 8] for t in range(2)])
        table = Results(self.folder).table("probes.csv")
        self.assertEqual(history.boulder_parts(table), ["soil.wall.boulders_fx", "soil.wall.boulders_fy",
                                                        "soil.lid.boulders_fx"])
        walls = self.axes_of(history.plot_wall_forces, Results(self.folder))
        self.assertEqual([text.get_text() for text in walls[0].get_legend().get_texts()],
                         ["soil lid fx", "soil lid boulders fx"])
        forces = self.axes_of(history.plot_forces, Results(self.folder))
        self.assertEqual([text.get_text() for text in forces[0].get_legend().get_texts()],
                         ["soil wall boulders fx", "soil wall boulders fy"])
        self.assertEqual([name for _, name in history.energy_curves(Results(self.folder))],
                         ["soil.boulders_kinetic_energy"])

    def test_mass_that_left_by_side(self) -> None:
        names = ["time", "soil.mass", "soil.removed_mass", "soil.removed.right.mass", "soil.removed.top.mass"]
        made_up.write_table(self.folder / "probes.csv", names, [[0, 5, 0, 0, 0], [1, 2, 3, 3, 0]])
        axes = self.axes_of(history.plot_removed, Results(self.folder))
        self.assertEqual([text.get_text() for text in axes[0].get_legend().get_texts()],
                         ["soil removed mass", "soil removed right mass"])

    def test_runs_in_the_plane_are_horizontal_and_vertical(self) -> None:
        run = Results(made_up.write_results(self.folder / "a"))
        axes = self.axes_of(history.plot_probes, {"a": run})
        self.assertEqual(self.titles(axes), ["point A, horizontal", "point A, vertical"])

    def test_a_run_keeps_its_colour(self) -> None:
        one, two = (made_up.write_results(self.folder / name) for name in ("one", "two"))
        table = two / "probes.csv"
        text = table.read_text(encoding="utf-8")
        table.write_text(text.replace("structure.A.", "structure.B."), encoding="utf-8")
        axes = self.axes_of(history.plot_probes, {"one": Results(one), "two": Results(two)})
        self.assertEqual([text.get_text() for text in axes[0].get_legend().get_texts()], ["one", "two"])
        for each, run in zip(axes, (0, 0, 1, 1)):
            shown = [line.get_color() for line in each.get_lines() if len(line.get_xdata())]
            self.assertEqual(shown, [COLOURS[run]])


if __name__ == "__main__":
    unittest.main()
