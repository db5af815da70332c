# SPDX-License-Identifier: BSD-3-Clause
"""A Tcl model: tclsh runs it, each command of OpenSees in it is one of OpenSeesPy. Needs tclsh (Debian: tcl)."""

import subprocess
import tempfile
from pathlib import Path
from typing import BinaryIO

# Texts go over stdin and stdout as their length, a line, and their bytes. pattern and section with a script run that
# after them; a series without a tag gets one. `load` is a command of Tcl itself.
PRELUDE = r"""
fconfigure stdin -translation binary -encoding utf-8
fconfigure stdout -translation binary -encoding utf-8 -buffering full
rename puts gabion_puts
proc gabion_put {text} {
  set bytes [encoding convertto utf-8 $text]
  gabion_puts stdout [string length $bytes]
  gabion_puts -nonewline stdout $bytes
}
proc gabion_call {args} {
  gabion_puts stdout [llength $args]
  foreach text $args { gabion_put $text }
  flush stdout
  gets stdin status
  gets stdin size
  set answer [encoding convertfrom utf-8 [read stdin $size]]
  if {$status ne "ok"} { error $answer }
  return $answer
}
proc puts {args} {
  if {[llength $args] == 1} { set args [linsert $args 0 stderr] }
  if {[lindex $args 0] eq "stdout"} { lset args 0 stderr }
  if {[lindex $args 0] eq "-nonewline" && [llength $args] == 2} { set args [list -nonewline stderr [lindex $args 1]] }
  gabion_puts {*}$args
}
rename load {}
proc unknown {args} { uplevel 1 [list gabion_call {*}$args] }
set gabion_series 880000000
proc pattern {type tag args} {
  global gabion_series
  if {$type ne "Plain"} { return [gabion_call pattern $type $tag {*}$args] }
  set series [lindex $args 0]
  if {![string is integer -strict $series]} {
    incr gabion_series
    gabion_call timeSeries [lindex $series 0] $gabion_series {*}[lrange $series 1 end]
    set series $gabion_series
  }
  gabion_call pattern Plain $tag $series {*}[lrange $args 1 end-1]
  uplevel 1 [lindex $args end]
}
proc section {type tag args} {
  if {$type ni {Fiber fiberSec NDFiber FiberThermal}} { return [gabion_call section $type $tag {*}$args] }
  gabion_call section $type $tag {*}[lrange $args 0 end-1]
  uplevel 1 [lindex $args end]
}
"""
LAST = r"""
foreach gabion_name [info globals] {
  if {![array exists $gabion_name]} { gabion_call {} $gabion_name [set $gabion_name] }
}
"""


class TclError(Exception):
    """The model file failed."""


def run_tcl(path: Path) -> dict:
    """Runs the file; its variables, numbers and lists of them as such."""
    import openseespy.opensees as ops
    variables: dict[str, object] = {}
    with tempfile.NamedTemporaryFile("w", suffix=".tcl") as script:
        script.write(f"{PRELUDE}\nset argv0 {{{path}}}\nsource {{{path}}}\n{LAST}")
        script.flush()
        try:
            tclsh = subprocess.Popen(["tclsh", script.name], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        except OSError as problem:
            raise TclError(f"{problem}; allowed: apt-get install tcl") from problem
        while words := read_call(tclsh.stdout):
            if words[0]:
                answer(tclsh.stdin, ops, words)
            else:
                variables[words[1]] = value_of(words[2])
                reply(tclsh.stdin, "ok", "")
        if tclsh.wait():
            raise TclError(f"{path}: ended with exit code {tclsh.returncode}; its message stands above")
    return variables


def read_call(stream: BinaryIO) -> list[str]:
    """The words of a command; none: the end."""
    count = stream.readline()
    return [stream.read(int(stream.readline())).decode() for _ in range(int(count or 0))]


def reply(stream: BinaryIO, status: str, text: str) -> None:
    stream.write(f"{status}\n{len(text.encode())}\n{text}".encode())
    stream.flush()


def answer(stream: BinaryIO, ops, words: list[str]) -> None:
    """Calls the command. What it refuses is an error of the Tcl script."""
    name, *arguments = words
    command = getattr(ops, {"print": "printModel"}.get(name, name), None)
    if command is None:
        return reply(stream, "error", f'invalid command name "{name}"')
    try:
        result = command(*(value_of(text) for text in arguments))
    except Exception as problem:  # of OpenSees, whatever it is
        return reply(stream, "error", f"{name}: {problem}")
    if isinstance(result, (list, tuple)):
        result = " ".join(map(repr, result))
    return reply(stream, "ok", "" if result is None else str(result))


def value_of(text: str) -> int | float | str | list:
    """Value of a text as Tcl would take it: a whole number, a number, a list of those, or a text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    if len(text.split()) > 1 and "{" not in text:
        parts = [value_of(part) for part in text.split()]
        if not any(isinstance(part, str) for part in parts):
            return parts
    return text
