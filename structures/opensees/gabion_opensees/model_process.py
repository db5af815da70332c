# SPDX-License-Identifier: BSD-3-Clause
"""The process that holds the OpenSees model; model.py speaks with it. Needs openseespy and nothing else.

    python model_process.py DESCRIPTOR PARENT MODEL      socket, process id of the parent, model file

OpenSees commits what it has solved and cannot go back. So a trial is a child: fork() gives it the accepted state,
history of materials and all. It solves, answers and waits. Rejected, it ends and its parent, the accepted state, goes
on; accepted, its parent ends and it is the accepted state. One process at a time reads the socket.
"""

import ctypes
import os
import runpy
import signal
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

OWN_TAG = 990_000_007  # of the load pattern and its series
PR_SET_PDEATHSIG = 1
LIBC = ctypes.CDLL(None)


class Model:
    """The commands of OpenSees on the model in this process."""

    def __init__(self, ops, settings: dict) -> None:
        self.ops, self.settings = ops, settings
        self.watched: list[int] = []  # nodes whose motion is sent
        self.probes: list[tuple[int, list[str]]] = []  # element, response
        ops.remove("recorders")  # they would write rejected solutions too
        ops.timeSeries("Constant", OWN_TAG)
        ops.pattern("Plain", OWN_TAG, OWN_TAG)
        self.set_analysis()

    def set_analysis(self) -> None:
        ops, settings = self.ops, self.settings
        ops.wipeAnalysis()
        ops.constraints("Transformation")
        ops.numberer("RCM")
        ops.system(*settings["system"])
        ops.test(*settings["test"])
        ops.algorithm(*settings["algorithm"])
        if settings["procedure"] == "static":
            ops.integrator("LoadControl", 0.0)
            ops.analysis("Static")
        else:
            ops.integrator(*settings["integrator"])
            ops.analysis("Transient")

    def describe(self) -> dict:
        """All that model.py wants to know of it, once."""
        ops = self.ops
        nodes = {tag: (ops.nodeCoord(tag), ops.getNDF(tag)[0]) for tag in ops.getNodeTags()}
        elements = {tag: ops.eleNodes(tag) for tag in ops.getEleTags()}
        return {"dimension": ops.getNDM()[0], "nodes": nodes, "elements": elements, "version": ops.version(),
                "constrained": ops.getConstrainedNodes()}

    def mass(self) -> dict:
        """The mass matrix over the unknowns, by rows, and the unknowns of each node (-1: supported). In a child: leaves
        another analysis behind, and no messages, as OpenSees warns of a singular matrix where an unknown has no
        mass."""
        ops = self.ops
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        ops.wipeAnalysis()
        ops.constraints("Transformation")
        ops.numberer("RCM")
        ops.system("FullGeneral")
        ops.test("NormDispIncr", 1.0, 1)
        ops.algorithm("Linear")
        ops.integrator("GimmeMCK", 1.0, 0.0, 0.0)
        ops.analysis("Transient")
        ops.analyze(1, 0.0)
        size = ops.systemSize()
        if size > self.settings["max_unknowns"]:
            return {"size": size}
        return {"size": size, "matrix": ops.printA("-ret"),
                "unknowns": {tag: ops.nodeDOFs(tag) for tag in ops.getNodeTags()}}

    def step(self, dt: float, loads: list, jumps: list) -> bool:
        """Loads, all components of some nodes, constant over dt; jumps: new accelerations at its begin."""
        ops = self.ops
        ops.remove("loadPattern", OWN_TAG)
        ops.pattern("Plain", OWN_TAG, OWN_TAG)
        for node, values in loads:
            ops.load(node, *values)
        for node, values in jumps:
            for axis, value in enumerate(values, 1):
                if value:
                    ops.setNodeAccel(node, axis, ops.nodeAccel(node, axis) + value, "-commit")
        if jumps:
            ops.domainChange()  # the integrator reads accelerations of nodes only then
        static = self.settings["procedure"] == "static"
        return (ops.analyze(1) if static else ops.analyze(1, dt)) == 0

    def motion(self) -> dict:
        ops = self.ops
        return {"u": [ops.nodeDisp(node) for node in self.watched], "v": [ops.nodeVel(node) for node in self.watched]}

    def probe_values(self) -> list[list[float]]:
        return [self.ops.eleResponse(element, *response) for element, response in self.probes]

    def solve(self, order: dict) -> dict:
        if not self.step(order["dt"], order["loads"], order["jumps"]):
            return {"failed": "analyze: no convergence"}
        return self.motion() | {"iterations": self.ops.testIter()}

    def answer(self, order: dict) -> dict:
        """Answer to an order that needs no child."""
        kind = order["order"]
        if kind == "describe":
            return self.describe()
        if kind == "watch":
            self.watched, self.probes = order["nodes"], order["probes"]
            return self.motion() | {"probes": self.probe_values()}
        if kind == "replay":
            for dt, loads, jumps in order["steps"]:
                if not self.step(dt, loads, jumps):
                    return {"error": "a step of the run that is continued has no solution: another model or version"}
            return self.motion() | {"probes": self.probe_values()}
        if kind == "frame":
            return {"u": {tag: self.ops.nodeDisp(tag) for tag in self.ops.getNodeTags()}}
        return {"error": f"unknown order {kind}"}


class Generations:
    """The processes of a model, and the one that holds the accepted state."""

    def __init__(self, model: Model, socket: Connection, ancestor: int) -> None:
        self.model, self.socket, self.ancestor = model, socket, ancestor
        self.predecessor = ancestor  # of this process, the accepted state before it

    def serve(self) -> None:
        """Never returns."""
        while True:
            order = self.socket.recv()
            if order["order"] == "trial":
                self.in_child(lambda: self.socket.send(self.model.solve(order)))
            elif order["order"] == "mass":
                self.in_child(lambda: self.socket.send(self.model.mass()))
            else:
                self.socket.send(self.model.answer(order))

    def in_child(self, solve: Callable[[], None]) -> None:
        """The child solves and awaits its verdict. This process waits for that; it ends when the child is accepted."""
        while (above := os.getppid()) != self.ancestor:
            if above != self.predecessor:  # the ancestor has been killed
                os._exit(1)
            os.sched_yield()  # the predecessor is still ending
        die_with_parent()
        sys.stdout.flush()
        sys.stderr.flush()
        parent = os.getpid()
        reading, writing = os.pipe()
        child = os.fork()
        if child:
            os.close(writing)
            self.await_child(child, reading)
            os.close(reading)
            return
        os.close(reading)
        die_with_parent()
        if os.getppid() != parent:
            os._exit(1)
        solve()
        if self.socket.recv()["order"] != "accept":
            os._exit(0)
        LIBC.prctl(PR_SET_PDEATHSIG, 0)
        self.predecessor = parent
        os.write(writing, b"a")
        os.close(writing)
        self.socket.send({"probes": self.model.probe_values()})

    def await_child(self, child: int, reading: int) -> None:
        if os.read(reading, 1):
            os._exit(0)
        _, status = os.waitpid(child, 0)
        if status:
            code = os.waitstatus_to_exitcode(status)
            how = f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
            self.socket.send({"error": f"the process of a trial solution {how}"})
            os._exit(1)


def die_with_parent() -> None:
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def run_model(path: Path) -> dict:
    """Runs the model file; its variables."""
    os.chdir(path.parent)
    sys.path.insert(0, str(path.parent))
    if path.suffix == ".tcl":
        from tcl import run_tcl  # beside this file
        return run_tcl(path)
    return runpy.run_path(str(path), run_name="__main__")


def plain(value: object) -> object:
    """Variables that settings may name: numbers and lists of them; None: anything else."""
    if isinstance(value, (int, float)):
        return value
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (list, tuple, range)):
        parts = [plain(part) for part in value]
        return None if None in parts else parts
    return None


def main() -> None:
    socket = Connection(int(sys.argv[1]))
    ancestor = int(sys.argv[2])
    die_with_parent()
    for number in (signal.SIGINT, signal.SIGTERM):  # a launcher sends them to all; the connection decides
        signal.signal(number, signal.SIG_IGN)
    settings = socket.recv()
    try:
        import openseespy.opensees as ops
    except (ImportError, RuntimeError) as problem:
        socket.send({"missing": f"{sys.executable}: {problem}"})
        os._exit(1)
    try:
        variables = run_model(Path(sys.argv[3]))
        model = Model(ops, settings)
        socket.send({"variables": {name: plain(value) for name, value in variables.items()
                                   if not name.startswith("__") and plain(value) is not None}})
        Generations(model, socket, ancestor).serve()
    except EOFError:
        os._exit(0)  # without OpenSees' last words
    except BaseException as problem:  # told to the connection, which names the participant
        socket.send({"error": f"{type(problem).__name__}: {problem}"})
        raise
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(1)


if __name__ == "__main__":
    main()
