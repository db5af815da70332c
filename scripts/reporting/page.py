# SPDX-License-Identifier: BSD-3-Clause
"""Puts the page together: text, data as JSON blocks, style and programs, all in one file."""

import datetime
import html
import json
from pathlib import Path
from typing import Any

from plotting.live import Run
from plotting.results import Results, ResultsError
from plotting.verdict import Statement, headline, verdict
from reporting.answers import parts as asked
from reporting.curves import charts, compared, residuals
from reporting.frames import scene_frames
from reporting.library import library
from reporting.maps import map_section
from reporting.settings import mesh_files, overview, settings_files

HERE = Path(__file__).resolve().parent
PROGRAMS = ("chart.js", "residuals.js", "scene.js", "boulders.js", "orbit.js", "space.js", "start.js")


def page(results: Results, other: Results | None = None, base_friction: float | None = None) -> str:
    """Page of a folder in any state. Raises ResultsError where there is nothing to report.

    other: a run whose answers and curves stand beside; base_friction: coefficient under footings, None: not known.
    """
    run = Run(results.folder)
    run.read_on()
    files = settings_files(results)
    if not files and run.summary is None and not run.account.count:
        raise ResultsError(f"{results.folder}: nothing of a run here: no resolved_config.json, steps.csv or "
                           "summary.json")
    problems: list[str] = []
    readers = {"charts": charts, "residuals": residuals, "scene": scene_frames}
    data = {key: _or_problem(read, results, problems) for key, read in readers.items()}
    rows = _rows(results, base_friction, problems)
    beside = _rows(other, base_friction, problems) if other is not None else None
    if other is not None and data["charts"]:
        theirs = _or_problem(charts, other, problems) or []
        data["charts"] = compared(data["charts"], theirs, other.folder.resolve().name)
    maps = map_section(results.folder, problems)
    name = results.folder.resolve().name
    parts = {
        "TITLE": html.escape(name), "HEADLINE": html.escape(headline(run)), "STATE": run.state().value,
        "ANSWERS": _answers(rows, beside, name, other),
        "STYLE": (HERE / "page.css").read_text(encoding="utf-8"),
        "MAP": maps,
        "VERDICT": _verdict(verdict(run), problems),
        "OVERVIEW": _table(overview(files)), "SETTINGS": _settings(files),
        "VERSIONS": _table(_versions(run)), "REPEAT": _repeat(run, files),
        "DATA": "\n".join(_block(key, value) for key, value in data.items() if value),
        "LIBRARY": (library() or "") if data["scene"] and "space" in data["scene"] else "",
        "PROGRAMS": "\n".join((HERE / program).read_text(encoding="utf-8") for program in PROGRAMS),
    }
    text = (HERE / "page.html").read_text(encoding="utf-8")
    for key, value in parts.items():
        text = text.replace(f"<!--{key}-->", value)
    return text


def _rows(results: Results, base_friction: float | None, problems: list[str]) -> list[tuple[str, str]]:
    """Answers, without those whose files cannot be read."""
    return [row for part in asked(base_friction) for row in _or_problem(part, results, problems) or []]


def _answers(rows: list[tuple[str, str]], beside: list[tuple[str, str]] | None, name: str,
             other: Results | None) -> str:
    """A table; of two runs with a column each, rows of both."""
    if not rows and not beside:
        return "<p>Nothing is reported of a structure, a surface or a gauge so far.</p>"
    if beside is None:
        return _table(rows)
    names, runs = (name, other.folder.resolve().name), (dict(rows), dict(beside))
    head = "".join(f"<th>{html.escape(text)}</th>" for text in ("", *names))
    cells = "\n".join(f"<tr><th>{html.escape(key)}</th>"
                      + "".join(f'<td data-run="{html.escape(label, quote=True)}">{html.escape(run.get(key, "–"))}</td>'
                                for label, run in zip(names, runs)) + "</tr>"
                      for key in dict.fromkeys([*runs[0], *runs[1]]))
    return f'<table class="compared">\n<tr>{head}</tr>\n{cells}\n</table>'


def _or_problem(read: Any, results: Results, problems: list[str]) -> Any:
    """Run a part of the page; a part that cannot be read, such as a half-written file, is named on the page and left
    out."""
    try:
        return read(results)
    except (ResultsError, OSError, KeyError) as error:
        if f"Left out: {error}" not in problems:
            problems.append(f"Left out: {error}")
        return None


def _block(name: str, value: Any) -> str:
    text = json.dumps(value, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    return f'<script type="application/json" id="{name}-data">{text}</script>'


def _verdict(statements: list[Statement], problems: list[str]) -> str:
    items = [*statements, *(Statement("note", "page", problem) for problem in problems)]
    return "\n".join(f'<li class="{each.kind}" data-topic="{each.topic}">{html.escape(each.text)}</li>'
                     for each in items)


def _table(rows: list[tuple[str, str]]) -> str:
    cells = "\n".join(f"<tr><th>{html.escape(label)}</th><td>{html.escape(text)}</td></tr>" for label, text in rows)
    return f"<table>\n{cells}\n</table>" if rows else "<p>None are known.</p>"


def _settings(files: dict[str, dict]) -> str:
    parts = []
    for name, settings in files.items():
        text = html.escape(json.dumps(settings, indent=2, ensure_ascii=False))
        title = html.escape(name, quote=True)
        save = f'<button type="button" class="save" data-file="{title}">save</button>'
        parts.append(f"<details>\n<summary>{title} {save}</summary>\n<pre>{text}</pre>\n</details>")
    return "\n".join(parts) or "<p>No resolved_config.json: the run did not get as far.</p>"


def _versions(run: Run) -> list[tuple[str, str]]:
    summary = run.summary or {}
    rows = [("Gabion", summary.get("version", "not known before the run has ended")),
            ("program", summary.get("program", "coupler" if run.participants else "not known"))]
    rows += [(f"participant {name}", program) for name, (program, _) in sorted(run.participants.items())]
    rows += [(name, str(value)) for name, value in summary.get("methods", {}).items()]
    now = datetime.datetime.now().astimezone()
    return [*rows, ("folder", str(run.folder.resolve())), ("this page", f"written {now:%Y-%m-%d %H:%M %Z}")]


def _repeat(run: Run, files: dict[str, dict]) -> str:
    """Commands, and what they need that is not in this page."""
    names = " ".join(name for name in files if "/" not in name) or "the settings"
    lines = [f"mkdir my_scene    # and save {names} from this page there", "scripts/run my_scene --check",
             "scripts/run my_scene --output results/my_scene"]
    if run.checkpoint() is not None:
        lines += ["", f"# or go on from step {run.checkpoint()}:",
                  f"scripts/run my_scene --restart {run.folder} --output results/longer"]
    needs = sorted({name for settings in files.values() for name in mesh_files(settings)})
    for name in files:
        if "/" in name:
            needs.append(f"{name} (saved under its own name in a folder of the scene)")
    participants = files.get("coupler.json", {}).get("participants", {})
    needs += [" ".join(each["command"]) for each in participants.values() if each.get("command")]
    also = f"<p>It also needs: {html.escape('; '.join(needs))}.</p>" if needs else ""
    return f"<pre>{html.escape(chr(10).join(lines))}</pre>\n{also}"
