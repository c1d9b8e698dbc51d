"""Comparison of contact laws: errors follow theory, results are printed and drawn. No cost is asserted."""

import json

import pytest
from click.testing import CliRunner


@pytest.fixture(scope="module")
def data():
    from benchmarks.contact_cost import compare

    return compare(repeats=1)


@pytest.mark.slow
def test_constraint_converges_to_a_rigid_retainer(data):
    errors = [row["orbit_error"] for row in data["constraint"]]
    assert errors[0] < data["orbit_tolerance"]
    assert errors == sorted(errors, reverse=True)
    assert all(row["penetration"] < 1e-12 for row in data["constraint"])


@pytest.mark.slow
def test_stiffer_springs_approach_the_rigid_retainer(data):
    rows = data["rigid_retainer"]
    for key in ("orbit_error", "penetration"):
        values = [row[key] for row in rows]
        assert values == sorted(values, reverse=True)
    assert data["cost_ratio_at_equal_accuracy"] == rows[-1]["cost_ratio"]


def test_every_classical_law_converges_to_its_limit(data):
    assert len(data["own_accuracy"]) == 7
    for row in data["own_accuracy"]:
        assert row["force_error"] <= data["force_tolerance"]
        assert row["penetration"] > 0.01


def test_command_prints_json_or_tables_and_draws(tmp_path, monkeypatch, data):
    from benchmarks import contact_cost
    from benchmarks.__main__ import main

    monkeypatch.setattr(contact_cost, "compare", lambda: data)
    run = CliRunner().invoke(main, ["contact", "--json", "-o", str(tmp_path / "figures")])
    assert run.exit_code == 0
    assert json.loads(run.stdout)["constraint"] == data["constraint"]
    assert (tmp_path / "figures" / "contact_cost.png").stat().st_size > 10_000
    run = CliRunner().invoke(main, ["contact"])
    assert "times what the constraint costs" in run.stdout.replace("\n", " ")
    blocked = tmp_path / "file"
    blocked.touch()
    run = CliRunner().invoke(main, ["contact", "-o", str(blocked)])
    assert run.exit_code == 2
