"""`tilecast stress`: its table, its JSON and its status. That the hazards hold is for the core's tests."""

import json
import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
import typer.testing

from tilecast import _core, cli
from tilecast.cli import stress

TILECAST = [sys.executable, "-m", "tilecast", "stress"]


def run(*arguments):
    return subprocess.run([*TILECAST, *arguments], capture_output=True, text=True, timeout=300)


def verdict(**changes):
    return SimpleNamespace(**{"figure": 0.25, "cases": 1000, "seconds": 1.5, "holds": True, "error": "",
                              "build_seconds": 0.0, "bytes": 0, "rays_per_second": 0.0} | changes)


CASE = SimpleNamespace(name="slivers", gate=7, figure="error, in 8 u", limit=1.0, cases=1000, long_cases=10**9, batch=64)


def test_a_quick_run_holds_and_says_so(tmp_path):
    table = tmp_path / "table.json"
    result = run("--quick", "--json", str(table))
    assert result.returncode == 0, result.stdout + result.stderr
    found = json.loads(table.read_text())
    names = [case.name for case in _core.stress_cases()]
    assert found["holds"] and found["complete"] and [row["case"] for row in found["cases"]] == names
    assert all(row["holds"] and row["figure"] <= row["limit"] and row["cases"] > 0 for row in found["cases"])
    assert result.stdout.count(" holds ") == len(names) and f"{len(names)} of {len(names)} hold" in result.stdout
    stadium = next(row for row in found["cases"] if row["case"] == "stadium")
    assert stadium["gate"] is None and all(value > 0 for value in stadium["scene"].values())


def test_json_on_standard_output_leaves_the_table_to_the_other():
    result = run("--quick", "--only", "watertight,one-primitive", "--threads", "1", "--json", "-")
    assert [row["case"] for row in json.loads(result.stdout)["cases"]] == ["watertight", "one-primitive"]
    assert "watertight" in result.stderr and "2 of 2 hold" in result.stderr


def test_names_what_it_does_not_know():
    result = run("--only", "watertight", "--only", "even-crossings,nonsense")
    assert result.returncode == 2 and result.stderr.startswith("tilecast: --only: no case is called 'nonsense'")


def test_ctrl_c_ends_it_with_what_there_is(tmp_path):
    table = tmp_path / "table.json"
    process = subprocess.Popen([*TILECAST, "--long", "--only", "watertight", "--json", str(table)],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == stress.HEAD + "\n"
    time.sleep(0.5)
    os.kill(process.pid, signal.SIGINT)
    out, error = process.communicate(timeout=30)
    assert process.returncode == 130 and error == "" and "0 of 1 hold" in out
    found = json.loads(table.read_text())
    assert not found["complete"] and not found["holds"]
    [row] = found["cases"]
    assert row["figure"] == 0 and row["go_on"] == row["cases"] > 0
    [line] = [line for line in out.splitlines() if " stopped " in line]
    assert line.endswith(f"; go on with --first {row['go_on']}")


def test_a_run_goes_on_where_it_was_ended(tmp_path):
    table = tmp_path / "table.json"
    first = 1_000_000 - 8192
    result = run("--only", "watertight", "--first", str(first + 5), "--json", str(table))
    [row] = json.loads(table.read_text())["cases"]
    begin = first // 4096 * 4096  # where a batch does
    assert result.returncode == 0 and row["first"] == begin and row["cases"] == 1_000_000 - begin
    assert f"from case {begin:,} on" in result.stdout


def test_parts_of_a_run_are_the_run():
    def figure(first, end):
        return _core.run_stress("quadratic", first, end, 2)[0].figure

    assert figure(0, 40960) == max(figure(0, 8192), figure(8192, 40960))
    with pytest.raises(_core.Error, match="must be a multiple of 4096"):
        figure(1, 10)


def test_a_case_that_falls_short_is_told_and_ends_with_1(monkeypatch):
    good = SimpleNamespace(**{**vars(CASE), "name": "fine"})
    verdicts = {"fine": verdict(), "slivers": verdict(figure=float("inf"), holds=False, error="it broke")}
    monkeypatch.setattr(_core, "stress_cases", lambda: [good, CASE])
    monkeypatch.setattr(_core, "run_stress", lambda name, first, end, threads: (verdicts[name], False))
    result = typer.testing.CliRunner().invoke(cli.app, ["stress"])
    assert result.exit_code == 1
    lines = result.stdout.splitlines()
    assert lines[1].split()[:5] == ["7", "fine", "holds", "1,000", "1.5"]
    assert lines[2].split()[:3] == ["7", "slivers", "FAILS"] and lines[2].endswith("at most 1: it broke")
    assert lines[-1] == "1 of 2 hold, 3.0 s"


@pytest.mark.parametrize(("figure", "told"), [(0.25, "0.25 error"), (float("nan"), "not a finite error")])
def test_figures_are_told_with_unit_and_limit(figure, told):
    row = stress.row(CASE, verdict(figure=figure, holds=figure < 1))
    assert f"{told}, in 8 u; at most 1" in stress.line(row)
    json.dumps(row, allow_nan=False)
