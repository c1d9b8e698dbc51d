"""Modules joined to one script behave as before; unsupported syntax is refused."""

import subprocess

import pytest

from amb_live.scripts import joined, read_module
from tests.support.messages import raises_naming

SOURCES = {
    "ui/main.js": 'import { double, half as h } from "../math/scale.js";\n'
    "const x = 4;\nconsole.log(double(x), h(x));\n",
    "math/scale.js": 'import { two } from "./two.js";\n'
    "const x = two;\nexport function double(a) { return x * a; }\nexport const half = (a) => a / x;\n",
    "math/two.js": "const two = 2;\nexport { two };\n",
}


def test_a_joined_script_runs_like_its_modules(node):
    text = joined("ui/main.js", SOURCES)
    ended = subprocess.run([node, "-e", text], capture_output=True, text=True, timeout=60, check=False)
    assert ended.stdout.split() == ["8", "2"], ended.stderr


def test_modules_that_nothing_imports_are_left_out():
    assert "unused" not in joined("ui/main.js", SOURCES | {"ui/unused.js": "export const unused = 1;\n"})


@pytest.mark.parametrize(
    "line",
    [
        'import x from "./x.js";',
        'import * as x from "./x.js";',
        "export default 1;",
        "export let x = 1;",
        'import "./x.js";',
    ],
)
def test_other_forms_of_import_and_export_are_refused(line):
    with raises_naming(ValueError, "a.js", "import"):
        read_module("a.js", f"{line}\n")


def test_circular_imports_are_refused():
    circle = {"a.js": 'import { b } from "./b.js";\n', "b.js": 'import { a } from "./a.js";\nexport const b = 1;\n'}
    with raises_naming(ValueError, "a.js -> b.js -> a.js"):
        joined("a.js", circle)


def test_a_missing_module_is_named():
    with raises_naming(ValueError, "a.js", "c.js"):
        joined("a.js", {"a.js": 'import { c } from "./c.js";\n'})
