#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/check_structure finds each breach, and nothing where there is none."""

import unittest

from script_case import ScriptCase

SPDX = "// SPDX-License-Identifier: BSD-3-Clause\n"
HEADER = SPDX + "#pragma once\n"


class CheckStructure(ScriptCase):
    def breaches(self) -> list[str]:
        result = self.python_script("check_structure", self.folder)
        lines = result.stderr.splitlines()
        self.assertEqual(result.returncode, 1 if lines else 0)
        return lines

    def expect_breach(self, path: str, text: str, *words: str) -> None:
        """One file with one breach; the message names the file and contains the words."""
        self.write(path, text)
        lines = self.breaches()
        self.assertEqual(len(lines), 1, lines)
        for word in (path.rpartition(".")[0], *words):
            self.assertIn(word, lines[0])

    def test_allowed_arrows_pass(self) -> None:
        self.write("common/base/log.hpp", HEADER)
        mesh = SPDX + '#include "common/base/log.hpp"\n#include <petscmat.h>\n'
        self.write("common/mechanics/mesh.cpp", mesh)
        self.write("protocol/channel/socket.cpp", SPDX + '#include <zmq.hpp>\n#include "protocol/channel/socket.hpp"\n')
        self.write("coupler/loop.cpp", SPDX + '#include "protocol/wire/codec.hpp"\n#include <Eigen/Core>\n')
        self.write("fem_solver/main.cpp", SPDX + '#include "common/mechanics/mesh.hpp"\n#include <mpi.h>\n')
        self.write("common/program/mpi_session.cpp", SPDX + "auto world = MPI_COMM_WORLD;\n")
        self.assertEqual(self.breaches(), [])

    def test_base_must_not_know_mechanics(self) -> None:
        text = SPDX + '#include "common/mechanics/mesh.hpp"\n'
        self.expect_breach("common/base/a.cpp", text, "common/base/")

    def test_solvers_must_not_know_each_other(self) -> None:
        self.expect_breach("mpm_solver/a.cpp", SPDX + '#include "fem_solver/step/fem_step.hpp"\n', "fem_step.hpp")

    def test_coupler_must_not_know_mechanics(self) -> None:
        self.expect_breach("coupler/a.cpp", SPDX + '#include "common/mechanics/mesh.hpp"\n', "coupler")

    def test_rooms_of_a_program_include_one_way(self) -> None:
        self.write("mpm_solver/grid/basis.hpp", HEADER + '#include "mpm_solver/mpm_config.hpp"\n')
        self.write("mpm_solver/step/step.cpp", SPDX + '#include "mpm_solver/grid/basis.hpp"\n')
        self.write("mpm_solver/mpm_solver.cpp", SPDX + '#include "mpm_solver/grid/basis.hpp"\n')
        self.assertEqual(self.breaches(), [])
        self.expect_breach("mpm_solver/grid/a.cpp", SPDX + '#include "mpm_solver/step/step.hpp"\n', "step.cpp")

    def test_no_way_leads_back_to_a_room(self) -> None:
        self.write("mpm_solver/grid/a.hpp", HEADER + '#include "mpm_solver/walls/a.hpp"\n')
        self.write("mpm_solver/walls/a.hpp", HEADER + '#include "mpm_solver/step/a.hpp"\n')
        self.assertEqual(self.breaches(), [])
        self.write("mpm_solver/step/a.hpp", HEADER + '#include "mpm_solver/grid/a.hpp"\n')
        lines = self.breaches()
        self.assertEqual(len(lines), 1, lines)
        self.assertIn("grid → walls → step → grid", lines[0])

    def test_no_way_leads_back_through_a_door(self) -> None:
        self.write("mpm_solver/step/a.cpp", SPDX + '#include "mpm_solver/mpm_config.hpp"\n')
        self.write("mpm_solver/mpm_config.cpp", SPDX + '#include "mpm_solver/step/a.hpp"\n')
        self.assertEqual(self.breaches(), [])
        self.expect_breach("mpm_solver/mpm_config.hpp", HEADER + '#include "mpm_solver/step/a.hpp"\n',
                           "mpm_config.hpp → step → mpm_config.hpp", "mpm_solver/step/a.cpp")

    def test_rooms_use_doors(self) -> None:
        self.expect_breach("mpm_solver/grid/a.cpp", SPDX + '#include "mpm_solver/mpm_solver.hpp"\n',
                           "mpm_solver/mpm_solver.hpp", "config_checks.hpp, mpm_config.hpp")

    def test_exchange_between_ranks_works_without_petsc(self) -> None:
        self.expect_breach("common/mechanics/ranks/a.cpp", SPDX + "#include <petscsf.h>\n", "PETSc")

    def test_functions(self) -> None:
        self.expect_breach("coupler/a.cpp", SPDX + "void f() {\n" + "  g();\n" * 59 + "}\n", "61 lines")
        self.expect_breach("coupler/a.cpp", SPDX + "template <class A, class B>\nint A<B>::f(int a, B<int, int> b, "
                           "int c,\n  int d, int e, int f) const {\n  return [](int x) { return x; }(a);\n}\n",
                           "6 parameters")
        self.write("coupler/a.cpp",
                   SPDX + "A::A(int a, int b) : a_{a}, b_(b) {}\nvoid f();\nint x = f(1, 2, 3, 4, 5, 6);\n")
        self.assertEqual(self.breaches(), [])

    def test_classes_over_all_their_files(self) -> None:
        """Each file and each function is short enough; the class is not."""
        function = "void Long<dim>::f() {\n" + "  g();\n" * 37 + "}\n\n"
        head = HEADER + "template <int dim>\nclass Long final : public Short<dim> {\n  struct Inner {};\n};\n"
        self.write("coupler/short.hpp", HEADER + "class Short {\n};\nvoid Shorter::f() {}\n")
        self.write("coupler/long.hpp", head)
        self.write("coupler/parts.hpp", HEADER + "struct Long::Part {\n" + "  int a;\n" * 7 + "};\n")
        for part in range(3):
            self.write(f"coupler/long_{part}.cpp", SPDX + 3 * ("template <int dim>\n" + function))
        self.assertEqual(self.breaches(), [])  # 3 + 9 x 40 lines, and 9 of a type in it
        self.expect_breach("coupler/long.hpp", head.replace("};\n};", "};\n" + "  int a;\n" * 29 + "};"),
                           "Long has 401 lines in 5 files; allowed: 400")

    def test_interfaces(self) -> None:
        text = HEADER + "class Wide {\n  virtual ~Wide() = default;\n" + "  virtual void f();\n" * 17 + "};\n"
        self.write("coupler/wide.hpp", text)
        self.assertEqual(self.breaches(), [])
        self.expect_breach("coupler/wide.hpp", text.replace("};", "  virtual void f();\n};"),
                           "Wide has 18 virtual functions; allowed: 17")

    def test_one_name_one_type(self) -> None:
        self.write("coupler/a.hpp", HEADER + "class Settings {\n};\n")
        self.write("mpm_solver/b.hpp", HEADER + "struct Balance {\n};\n")
        self.write("fem_solver/b.hpp", HEADER + "struct Balance {\n};\n")
        self.assertEqual(self.breaches(), [])
        self.expect_breach("mpm_solver/a.hpp", HEADER + "struct Settings {\n};\n", "Settings", "coupler/a.hpp")

    def test_one_style_of_tests(self) -> None:
        self.expect_breach("tests/unit/a_test.cpp", SPDX + "TEST(A, works) {}\n", "test_")
        (self.folder / "tests/unit/a_test.cpp").unlink()
        self.expect_breach("tests/unit/test_a.cpp", SPDX + "TEST(A, WorksWell) {}\n", "snake_case")
        self.expect_breach("tests/unit/test_a.cpp", SPDX + "TEST(A, works) { EXPECT_THROW(f(), Error); }\n", "any text")

    def test_relative_include_is_refused(self) -> None:
        self.expect_breach("coupler/a.cpp", SPDX + '#include "a.hpp"\n', "a.hpp")

    def test_mechanics_must_not_know_the_protocol(self) -> None:
        self.expect_breach("common/mechanics/a.cpp", SPDX + '#include "protocol/wire/codec.hpp"\n', "codec.hpp")

    def test_folder_without_rule(self) -> None:
        self.expect_breach("common/drawer/a.cpp", SPDX, "does not say")

    def test_coupler_without_petsc(self) -> None:
        self.expect_breach("coupler/a.cpp", SPDX + "#  include <petscksp.h>\n", "PETSc")

    def test_world_has_one_owner(self) -> None:
        self.expect_breach("fem_solver/a.cpp", SPDX + "int x = rank(MPI_COMM_WORLD);\n", "MPI_COMM_WORLD")

    def test_zmq_outside_protocol(self) -> None:
        self.expect_breach("coupler/a.cpp", SPDX + "#include <zmq.hpp>\n", "ZeroMQ")

    def test_zmq_elsewhere_in_protocol(self) -> None:
        self.write("protocol/channel/keys.cpp", SPDX + "#include <zmq.h>\n")
        self.assertEqual(self.breaches(), [])
        self.expect_breach("protocol/a.cpp", SPDX + "#include <zmq.h>\n", "ZeroMQ")

    def test_missing_licence_and_pragma(self) -> None:
        self.expect_breach("coupler/a.hpp", SPDX, "#pragma once")
        self.write("coupler/a.hpp", "#pragma once\n")
        self.assertIn("SPDX", self.breaches()[0])

    def test_long_lines_of_python(self) -> None:
        head = "#!/usr/bin/python3\n# SPDX-License-Identifier: BSD-3-Clause\n"
        self.write("scripts/plot", head + "a" * 120 + "\n")
        self.write("scripts/go", "#!/bin/bash\n# SPDX-License-Identifier: BSD-3-Clause\n" + "a" * 121 + "\n")
        self.write("configs/a/table.csv", "a" * 121 + "\n")
        self.assertEqual(self.breaches(), [])
        self.expect_breach("scripts/plot", head + "ä" * 121 + "\n", "scripts/plot:3", "121 characters")

    def test_script_without_licence(self) -> None:
        self.expect_breach("scripts/go.sh", "#!/bin/sh\n", "SPDX")

    def test_file_length(self) -> None:
        self.write("coupler/a.cpp", SPDX + "\n" * 399)
        self.assertEqual(self.breaches(), [])
        self.expect_breach("coupler/a.cpp", SPDX + "\n" * 400, "401 lines")

    def test_configs(self) -> None:
        self.write("configs/a/README.md", "")
        self.expect_breach("configs/a/mpm.json", '{"dt": 1,}', "configs/a/mpm.json")
        self.write("configs/a/mpm.json", "{}")
        self.assertEqual(self.breaches(), [])
        self.expect_breach("configs/b/fem.json", "{}", "README.md")


if __name__ == "__main__":
    unittest.main()
