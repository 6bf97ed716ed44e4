"""`tilecast stress`: what breaks ray tracers, tried on this one, each hazard with the figure that it is held to."""

from __future__ import annotations

import json
import math
import os
import sys
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Annotated, Any, TextIO

import typer

from .failures import BAD_SCENE, FAILED, fail, writable

_QUICK = 50  # times fewer cases, but this many at least:
_FEWEST = 18

Row = dict[str, Any]


def stress(
    long: Annotated[bool, typer.Option("--long", help="So many cases that none failing bounds the rate of failures by "
                                                      "3e-9: hours.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="A fiftieth of the cases: seconds.")] = False,
    only: Annotated[
        list[str] | None, typer.Option(metavar="NAME,...", help="These cases alone.", show_default=False)
    ] = None,
    output: Annotated[str | None, typer.Option(
        "--json", metavar="FILE|-", show_default=False,
        help="Write the table as JSON, too; -: to standard output, and the table to standard error.")] = None,
    threads: Annotated[int | None, typer.Option(min=1, help="One a core by default.", show_default=False)] = None,
    first: Annotated[int, typer.Option(min=0, metavar="N", show_default=False,
                                       help="Leave out the cases before this one: a long run that was ended with Ctrl-C "
                                            "says where to go on.")] = 0,
) -> None:
    """Try the numerical hazards and extreme scenes, and print a table. Ends with status 1 if one falls short."""
    from .. import _core

    if long and quick:
        raise typer.BadParameter("a run cannot be both long and quick", param_hint="--quick")
    if output not in (None, "-"):
        writable(Path(output))
    cases = _chosen(_core.stress_cases(), only)
    screen = sys.stderr if output == "-" else sys.stdout
    rows: list[Row] = []
    complete = False
    try:
        _print(screen, HEAD)
        for case in cases:
            count = case.long_cases if long else case.cases
            if quick:
                count = max(count // _QUICK, min(count, _FEWEST))
            begin = min(first, count) // case.batch * case.batch
            with _running(case.name, screen):
                verdict, stopped = _core.run_stress(case.name, begin, count, threads or os.cpu_count() or 1)
            rows.append(row(case, verdict, begin, stopped))
            _print(screen, line(rows[-1], colour=screen.isatty()))
            if stopped:
                break
        else:
            complete = True
    except KeyboardInterrupt:
        pass
    for text in summary(rows):
        _print(screen, text)
    if output is not None:
        _write(output, {"complete": complete, "holds": complete and holds(rows), "cases": rows})
    if not complete:
        raise typer.Exit(130)
    if not holds(rows):
        raise typer.Exit(FAILED)


def row(case: Any, verdict: Any, first: int = 0, stopped: bool = False) -> Row:
    """A case and how it came out, as plain values: of the cases from `first` on. What is not finite is none in JSON."""
    out = {"gate": case.gate or None, "case": case.name, "figure": _finite(verdict.figure), "unit": case.figure,
           "limit": case.limit, "cases": verdict.cases, "holds": verdict.holds, "seconds": round(verdict.seconds, 3)}
    if first:
        out["first"] = first
    if stopped:
        out["go_on"] = first + verdict.cases
    if verdict.error:
        out["error"] = verdict.error
    if verdict.build_seconds:
        out["scene"] = {"build_seconds": verdict.build_seconds, "bytes": verdict.bytes,
                        "rays_per_second": verdict.rays_per_second}
    return out


HEAD = f"{'gate':>5}  {'case':<22}{'verdict':<8}{'cases':>13}{'seconds':>10}  figure, and its limit"


def line(row: Row, colour: bool = False) -> str:
    """A row of the table."""
    verdict = "holds" if row["holds"] else "stopped" if "go_on" in row else "FAILS"
    padded = f"{verdict:<8}"
    if colour and verdict == "FAILS":
        padded = typer.style(padded, fg="red", bold=True)
    figure = "not a finite" if row["figure"] is None else f"{row['figure']:.3g}"
    gate = row["gate"] or "scene"
    return (f"{gate:>5}  {row['case']:<22}{padded}{row['cases']:>13,}{row['seconds']:>10.1f}  "
            f"{figure} {row['unit']}; at most {row['limit']:g}" + (f": {row['error']}" if "error" in row else "")
            + (f"; from case {row['first']:,} on" if "first" in row else "")
            + (f"; go on with --first {row['go_on']}" if "go_on" in row else ""))


def summary(rows: list[Row]) -> list[str]:
    """What the scenes cost, and how many cases hold."""
    out = []
    scenes = [row for row in rows if "scene" in row]
    if scenes:
        out += ["", f"{'scene':<22}{'build, seconds':>15}{'MB':>10}{'rays a second':>15}"]
        out += [f"{row['case']:<22}{row['scene']['build_seconds']:>15.3f}{row['scene']['bytes'] / 1e6:>10.3f}"
                f"{row['scene']['rays_per_second']:>15,.0f}" for row in scenes]
    good = sum(row["holds"] for row in rows)
    out += ["", f"{good} of {len(rows)} hold, {sum(row['seconds'] for row in rows):.1f} s"]
    return out


def holds(rows: list[Row]) -> bool:
    return all(row["holds"] for row in rows)


def _chosen(cases: list[Any], only: list[str] | None) -> list[Any]:
    if not only:
        return cases
    wanted = [name.strip() for name in ",".join(only).split(",")]
    for name in wanted:
        if name not in {case.name for case in cases}:
            fail(f"--only: no case is called {name!r}; there are {', '.join(case.name for case in cases)}", BAD_SCENE)
    return [case for case in cases if case.name in wanted]


def _running(name: str, screen: TextIO) -> AbstractContextManager[Any]:
    """Shows what is running, where somebody looks."""
    if not screen.isatty():
        return nullcontext()
    from rich.console import Console
    return Console(file=screen).status(name)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _print(screen: TextIO, text: str) -> None:
    print(text, file=screen, flush=True)


def _write(output: str, table: Row) -> None:
    text = json.dumps(table, indent=2, allow_nan=False) + "\n"
    if output == "-":
        sys.stdout.write(text)
    else:
        try:
            Path(output).write_text(text)
        except OSError as error:
            fail(f"cannot write {output}: {error.strerror or error}")
