"""The house's rules that a machine can check: imports look one way, modules stay of a size, no text names a machine."""

import ast
import re
import subprocess
from functools import cache
from pathlib import Path

from tests.support import ROOT
from tests.support.imports import imports, name_of
from tests.support.programs import GIT, needs

MODULES = sorted((*ROOT.glob("exercises/**/*.py"), *ROOT.glob("grader/**/*.py")))

LAYERS = {
    "exercises": """errors files input_file stream console parallel
        formula.printing formula.text formula.code formula.names formula.trees formula.algebra formula.notation
        formula.expression formula.program formula.field formula.angles formula.exact formula.identity formula.constants
        formula.pieces formula.conditions formula.claims
        arm.chain arm.kinematics arm.trigonometry arm.derivation arm.singularity arm.axes arm.reach arm.appearance
        arm.classification arm.directions arm.meanings arm.precise arm.path arm.entry arm.robot_file
        arm.arithmetic arm.stages
        credit decimals lateness difficulty answers problem families questions mistakes quizzes
        generation record verify writing.latex phrases languages render writing messages figure
        notebook show solving docs gradebook assignment store release exports.outlet exports.bank
        exports.known_wrong exports.stack_parts exports exports.registry site.keys site.record site.bank
        site.page site.chapter site.arms site.guide site.reference site.pages site.stale_files site.build site
        commands""",
    "grader": """verdict counterexample formulas choices direction compare contained functions parts credit residuals
        diagnosis follow marking prairielearn sandbox guarantees cells archives layouts roster submission
        finding uncounted copies overrides attempt settle remote cluster batch single history certificates certify
        check statistics similar variants reports nbgrader_cells demo commands pytest_plugin nbgrader_plugin
        gradescope outlets site docs cli""",
}
"""From the bottom up: a module imports only from those before it; a folder stands for what is in it."""


@cache
def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(text_of(path))


def layer(module: str, package: str) -> int | None:
    """Return the place of the longest beginning of a module's name that is listed; None for another package's."""
    parts = module.split(".")
    for length in range(len(parts), 1, -1):
        name = ".".join(parts[1:length])
        if parts[0] == package and name in LAYERS[package].split():
            return LAYERS[package].split().index(name)
    return None


def test_every_module_has_its_place_in_the_layers_and_on_the_map() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for package, listed in LAYERS.items():
        modules = [name_of(path) for path in MODULES if name_of(path).count(".") and name_of(path).startswith(package)]
        folders = {"exercises.formula", "exercises.arm"}  # without code of their own
        assert not [name for name in modules if layer(name, package) is None and name not in folders]
        assert not [name for name in listed.split() if not any(f"{package}.{name}" in module for module in modules)]
        for name in {module.split(".")[1] for module in modules}:
            folder = "/" if (ROOT / package / name).is_dir() else ""
            assert f"`{name}{folder}`" in text, f"CONTRIBUTING.md doesn't say what {package}/{name} is"


def looking_up(path: Path) -> list[str]:
    """Return what a module imports that is above it."""
    module, used = name_of(path), imports(path)
    found = [name for name in used if module.startswith("exercises") and name.split(".")[0] == "grader"]
    for package in LAYERS:
        own = layer(module, package)
        if own is not None:
            found += [name for name in used if (other := layer(name, package)) is not None and other > own]
    return sorted(found)


def test_imports_look_one_way() -> None:
    assert {name_of(path): above for path in MODULES if (above := looking_up(path))} == {}


def test_there_is_no_circle() -> None:
    graph = {name_of(path): imports(path) for path in MODULES}
    graph = {name: {other for other in used if other in graph and other != name} for name, used in graph.items()}
    done: set[str] = set()
    while graph:
        free = {name for name, used in graph.items() if used <= done}
        assert free, f"these import each other in a circle: {sorted(graph)}"
        done |= free
        graph = {name: used for name, used in graph.items() if name not in free}


def test_a_module_opens_with_what_it_is() -> None:
    assert [name_of(path) for path in MODULES if not ast.get_docstring(tree_of(path))] == []


def calls_of(path: Path) -> set[str]:
    """Return the names of all functions and methods that a module calls."""
    return {
        node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.Call)
    }


def test_students_text_is_never_executed_outside_the_runner() -> None:
    others = [path for path in MODULES if path.name != "runner.py"]
    executing = {"eval", "exec", "parse_expr", "lambdify"}
    assert {name_of(path): found for path in others if (found := calls_of(path) & executing)} == {}
    pickling = [path for path in others if "pickle" in imports(path)]
    assert [path for path in pickling if path != ROOT / "exercises" / "store.py"] == []  # signed with the secret


def test_no_text_speaks_of_what_is_not_in_the_repository() -> None:
    """Of documents that somebody had beside it."""
    elsewhere = re.compile(r"shared recipe|\bcli\.md|\.\./shared")
    assert [name_of(path) for path in MODULES if elsewhere.search(text_of(path))] == []


def test_no_tracked_text_names_a_machine_or_a_registry() -> None:
    needs("git", GIT)
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        return  # not a checkout
    pattern = re.compile(
        r"(?<![A-Za-z0-9_.~])/(?:work|farm|home|Users|root)/|index" + r"-url|registry" + r" *= *\"http"
    )
    found = {}
    for name in listed.stdout.splitlines():
        path = ROOT / name
        if path.is_file() and path.name != Path(__file__).name:
            found[name] = pattern.findall(path.read_text(encoding="utf-8", errors="replace"))
    assert {name: texts for name, texts in found.items() if texts} == {}
