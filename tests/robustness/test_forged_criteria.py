"""Files of criteria with random mistakes: each formula gives a finite number, or the file is refused in sentences."""

from __future__ import annotations

import math
import random

import pytest
from mutations import changed_toml

from amb_assessment.assessment.criteria import check_formulas, load_criteria, packaged_criteria

FACTS = {name: 1.0 for name in ("AF", "N_c", "N_min", "N_mc")}
NUMBERS = ("0", "1", "-1", "1e308", "1e-308", "64", "0.5", "9" * 30, "2.5", "1_0", "0x1F", "1j", "True", "'a'")
NAMES = ("AF", "N_c", "N_mc", "nothing", "min", "__class__", "Ω", "N_c.real", "(lambda: 1)()", "[1]", "AF[0]")
OPERATORS = ("+", "-", "*", "/", "**", "<", "<=", ">", ">=", "and", "or", "==", "%", "//", "if", ",", ":=", "@")
FUNCTIONS = ("min", "max", "sqrt", "abs", "log10", "not ", "-", "", "", "eval", "pow")


def formula(chance, depth=4):
    """A random formula, sometimes of what is not allowed in one."""
    if depth == 0 or chance.random() < 0.2:
        return chance.choice(NUMBERS if chance.random() < 0.6 else NAMES)
    if chance.random() < 0.4:
        operands = ", ".join(formula(chance, depth - 1) for _ in range(chance.choice((1, 1, 2, 2, 3, 0))))
        return f"{chance.choice(FUNCTIONS)}({operands})"
    return f"{formula(chance, depth - 1)} {chance.choice(OPERATORS)} {formula(chance, depth - 1)}"


def forged(texts, chance):
    """A file changed at random, or with a formula of its own for one criterion."""
    text = chance.choice(texts)
    if chance.random() < 0.5:
        return changed_toml(text, chance)
    lines = text.splitlines()
    places = [k for k, line in enumerate(lines) if line.startswith(("limit = ", "when = "))]
    local = formula(chance) * chance.choice((1, 1, 1, 50)) if places else ""
    for k in chance.sample(places, min(1, len(places))):
        lines[k] = f'{lines[k].split(" = ")[0]} = "{local}"'
    return "\n".join(lines).encode()


def judged(criteria, facts):
    """The limits of all criteria that apply, after whether they are met was asked."""
    limits = []
    for item in criteria:
        if item.known != "missing" and item.applies(facts):
            limits.append(item.limit_of(facts))
            assert item.is_met(1.0, facts) in (True, False)
            item.zone_of(1.0)
    return limits


@pytest.fixture
def count(is_long):
    return 10_000 if is_long else 100


def test_a_forged_file_of_criteria_is_finite_or_refused(tmp_path, first_seed, count):
    texts = [file.read_text(encoding="utf-8") for file in packaged_criteria().values()]
    file, refused = tmp_path / "mine.toml", 0
    for seed in range(first_seed, first_seed + count):
        chance = random.Random(seed)
        file.write_bytes(forged(texts, chance))
        facts = {name: chance.choice((0.0, 1.0, -1.0, 1e300, 1e-300, 12000.0)) for name in FACTS}
        try:
            criteria = load_criteria([file])
            check_formulas(criteria, facts)
            limits = judged(criteria, facts)
        except ValueError as error:
            refused += 1
            message = str(error)
        else:
            assert all(math.isfinite(limit) for limit in limits), f"seed {seed}: {limits}"
            continue
        assert message, f"seed {seed}"
        assert len(message) < 20_000, f"seed {seed}: {message[:500]}"
    print(f"{count} forged, {refused} refused")
    assert 0 < refused < count
