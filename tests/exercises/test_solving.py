"""`qdot solve`: the textbook's arms come out as the textbook has them, and mistakes in a file are told by place."""

import json
import re
from collections.abc import Iterator
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

from exercises.arm import derivation, shipped
from exercises.arm.chain import TASK_ROWS, Chain, Joint
from exercises.arm.classification import Kind, domain_of
from exercises.arm.derivation import derive
from exercises.arm.entry import to_sympy
from exercises.arm.placing import Axis, reached
from exercises.arm.robot_file import read_robot_file
from exercises.arm.singularity import Component
from exercises.errors import QdotError
from exercises.families.own import own_family
from exercises.formula.conditions import Space, compare_sets
from exercises.formula.expression import read
from exercises.formula.pieces import pieces
from exercises.generation import generate
from exercises.input_file import shown
from exercises.problem import ProblemId
from exercises.questions import QUESTIONS
from exercises.solving import (
    Ready,
    Solution,
    read_robot,
    solution_data,
    solution_json,
    solution_latex,
    solution_text,
    solve,
    text_stages,
)
from exercises.solving_in_time import write_solution
from exercises.special_lengths import _plain
from exercises.writing.markup import to_text
from exercises.writing.statement import worked_solution, worked_steps
from exercises.writing.worked import SingularComponent, Worked
from tests.repository.test_schemas import errors
from tests.support import DATA
from tests.support.command import fails, run
from tests.support.suites import few_of

TRUTH = json.loads((DATA / "ground_truth.json").read_text(encoding="utf-8"))
EXPRESSIBLE = [row for row in TRUTH if set(row["task_rows"]) <= set(TASK_ROWS)]
NAMES = [row["name"] for row in EXPRESSIBLE]
SMALL = [row["name"] for row in EXPRESSIBLE if row["n"] <= 4]
AT_TIP = [row["name"] for row in EXPRESSIBLE if row["task_reference_point"].startswith("tip")]
WRITTEN = ["planar_2R", "planar_RP", "planar_3R_position", "SCARA_RRRP", "ZYZ_wrist", "pan_tilt_2R", "cartesian_PPP"]


def _toml_angle(text: str) -> str:
    """Return a ground-truth angle in degrees, as in theta1+90, in radians."""
    return re.sub(r"(?<![a-z\d])(\d+)", r"\1*pi/180", text)


def _row_toml(row: dict[str, str]) -> str:
    theta, alpha = _toml_angle(row["theta_deg"]), _toml_angle(row["alpha_deg"])
    return (
        f'[[joint]]\nkind = "{row["type"]}"\ntheta = "{theta}"\nd = "{row["d"]}"\na = "{row["a"]}"\nalpha = "{alpha}"\n'
    )


def _toml(arm: dict[str, Any]) -> str:
    point = re.sub("^tip ", "", arm["task_reference_point"])
    head = f'name = "{arm["name"]}"\ntask = {json.dumps(arm["task_rows"])}\npoint = "{point}"\n'
    return head + "".join(map(_row_toml, arm["dh"]))


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("robots")


@cache
def _chain(name: str, folder: Path) -> Chain:
    path = folder / f"{name}.toml"
    path.write_text(_toml(_arm(name)), encoding="utf-8")
    return read_robot(path)


@cache
def _solved(name: str, folder: Path) -> Solution:
    return solve(_chain(name, folder))


def _arm(name: str) -> dict[str, Any]:
    return next(row for row in TRUTH if row["name"] == name)


def _values(chain: Chain, seed: int) -> dict[sp.Symbol, float]:
    rng = np.random.default_rng(seed)
    angles = {q: float(rng.uniform(-3, 3)) for q in chain.q}
    return {**angles, **{symbol: float(rng.uniform(0.3, 1.2)) for symbol in chain.parameters}}


def _number(text: str, values: dict[sp.Symbol, float]) -> float:
    return float(to_sympy(read(text, [symbol.name for symbol in values])).xreplace(values))


def test_the_pose_at_home_of_oblique_axes_is_what_the_file_says(tmp_path: Path) -> None:
    """The table that is worked with has products of roots in brackets, which make the point that was given."""
    path = tmp_path / "arm.toml"
    path.write_text(
        'name = "Oblique"\nconvention = "screws"\npoint = ["a1 + a2", 0, "1/4"]\n'
        '[[joint]]\nkind = "R"\naxis = [0, 0, 1]\npoint = [0, 0, 0]\n'
        '[[joint]]\nkind = "R"\naxis = [1, 1, 0]\npoint = ["a1", 0, 0.2]\n'
        '[[joint]]\nkind = "P"\naxis = [0, 3, 4]\n'
    )
    chain = read_robot_file(path).chain
    a1, a2 = sp.symbols("a1 a2")
    steps = Worked(chain)
    assert list(steps.point_at_home) == [a1 + a2, 0, sp.Rational(1, 4)]
    assert list(steps.axis_at_home(3)) == [0, sp.Rational(3, 5), sp.Rational(4, 5)]
    (_, place), *_ = steps.moved_points
    d3 = sp.Symbol("d3")
    assert list(place) == [a1 + a2, sp.Rational(3, 5) * d3, sp.Rational(4, 5) * d3 + sp.Rational(1, 4)]


def test_rows_that_no_task_names_are_few() -> None:
    left_out = [row["name"] for row in TRUTH if row not in EXPRESSIBLE]
    assert left_out == ["Scorbot_5R_task_xyz_pitch_roll_at_P"]  # its rows are joint-rate sums, not vx … wz


@pytest.mark.parametrize("name", NAMES)
def test_determinant_is_the_textbooks_up_to_sign(name: str, folder: Path) -> None:
    chain, stated = _chain(name, folder), _arm(name).get("det")
    if stated is None:
        assert not derive(chain).is_square
        return
    ratios = set()
    for seed in range(4):
        values = _values(chain, seed)
        ratios.add(round(float(derive(chain).determinant.xreplace(values)) / _number(stated, values), 9))
    assert ratios in ({1.0}, {-1.0})


@pytest.mark.parametrize("name", AT_TIP)
def test_geometric_jacobian_at_the_tip_is_the_textbooks(name: str, folder: Path) -> None:
    chain = _chain(name, folder)
    values = _values(chain, 1)
    ours = np.array(derive(chain).geometric.xreplace(values).tolist(), dtype=float)
    theirs = np.array([[_number(entry, values) for entry in row] for row in _arm(name)["J_full_base_tip"]])
    assert np.allclose(ours, theirs)


@pytest.mark.parametrize("name", few_of(SMALL, 4))
def test_singular_set_is_the_textbooks(name: str, folder: Path) -> None:
    solution, arm = _solved(name, folder), _arm(name)
    chain = solution.chain
    joints = [q.name for q in chain.q]
    claimed = [piece for text in _conditions(solution) for piece in pieces(read(text), joints)]
    texts = [" and ".join(part["conditions"]) for part in arm["singular_set"]]
    reference = [piece for text in texts for piece in pieces(read(text), joints)]
    compared = compare_sets(claimed, reference, Space(joints, domain_of(chain)), "test")
    assert compared.equal, compared


def _conditions(solution: Solution) -> list[str]:
    """Return the conditions as the JSON has them, by values of joints where it gives any."""
    found = []
    for part in solution_data(solution)["singular"]:
        if part["solutions"] is None:
            found.append(" and ".join(f"{text} = 0" for text in part["conditions"]))
        else:
            found.append(" and ".join(f"{joint} in {{{', '.join(v)}}}" for joint, v in part["solutions"].items()))
    return found


@pytest.mark.parametrize(
    ("name", "kind"),
    [("planar_2R", "boundary"), ("planar_RP", "internal"), ("planar_PR", "boundary"), ("ZYZ_wrist", "internal")],
)
def test_kinds_are_the_textbooks(name: str, kind: str, folder: Path) -> None:
    (only,) = solution_data(_solved(name, folder))["singular"]
    assert (only["type"], only["uniform"]) == (kind, True)


def test_scorbot_arm_has_the_shoulder_that_the_book_leaves_out(folder: Path) -> None:
    solution = _solved("elbow_RRR_shoulder_offset_(Scorbot_point_P)", folder)
    elbow, shoulder = solution_data(solution)["singular"]
    assert (elbow["condition"], elbow["solutions"]) == ("sin(theta3)", {"theta3": ["0", "pi"]})
    assert shoulder["condition"] == "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3)"
    assert shoulder["solutions"] is None and (shoulder["type"], shoulder["uniform"]) == ("internal", True)
    assert "Straightening joint 2 alone" not in solution_text(solution)  # that is said of the chapter's arm


def test_what_the_chapter_has_otherwise_is_said_of_its_own_arm_only(tmp_path: Path) -> None:
    """Not of a file's arm of the same shape, whatever it and its file are called."""
    family = generate(ProblemId("elbow-3r", 0, ("singular-angles",), variation="chapter"))
    assert "The printed chapter gives" in worked_solution(family, family.parts[0])
    path = tmp_path / "elbow-3r.toml"
    rows = [("d1", "a1", "pi/2"), (0, "a2", 0), (0, "a3", 0)]
    joints = "".join(
        f'[[joint]]\nkind = "R"\ntheta = "theta{i}"\nd = {shown(d)}\na = {shown(a)}\nalpha = {shown(alpha)}\n'
        for i, (d, a, alpha) in enumerate(rows, 1)
    )
    path.write_text(f'name = "elbow-3r"\n{joints}')
    assert Worked(family.chain).is_elbow and Worked(read_robot(path)).is_elbow
    text = solution_text(solve(read_robot(path)))
    assert "a boundary singularity" in text and "printed chapter" not in text
    own = generate(ProblemId("elbow-3r", 0, ("singular-angles",)), family=own_family(path))
    assert "printed chapter" not in worked_solution(own, own.parts[0])


@pytest.mark.parametrize("name", WRITTEN)
def test_every_form_is_written(name: str, folder: Path) -> None:
    solution = _solved(name, folder)
    text, latex, data = solution_text(solution), solution_latex(solution), json.loads(solution_json(solution))
    assert "$" not in text and "\\" not in text
    assert latex.count(r"\begin{") == latex.count(r"\end{")
    assert latex.replace(r"\\[6pt]", "").count(r"\[") == latex.count(r"\]")
    assert len(data["position"]) == 3 and np.array(data["jacobian"]).shape == (3, solution.chain.n)
    assert np.array(data["geometric_jacobian"]).shape == (6, solution.chain.n)
    entries = [entry for row in data["geometric_jacobian"] for entry in row]
    for entry in [*data["position"], *entries, data["determinant"] or "0"]:
        to_sympy(read(entry))


# --- files ---

TWO_R = """name = "two"
[[joint]]
kind = "R"
theta = "theta1"
d = 0
a = "a1"
alpha = 0
[[joint]]
kind = "R"
theta = "theta2 + pi/2"
d = 0
a = 0.35
alpha = 0
"""


def _read(tmp_path: Path, text: str) -> Chain:
    path = tmp_path / "arm.toml"
    path.write_text(text, encoding="utf-8")
    return read_robot(path)


def test_decimals_are_exact_and_the_default_task_is_that_of_the_plane(tmp_path: Path) -> None:
    chain = _read(tmp_path, TWO_R)
    assert chain.joints[1].a == sp.Rational(7, 20)
    assert chain.joints[1].theta == sp.Symbol("theta2") + sp.pi / 2
    assert chain.task == ("vx", "vy")


def _refused(tmp_path: Path, old: str, new: str) -> str:
    assert old in TWO_R
    with pytest.raises(QdotError) as caught:
        _read(tmp_path, TWO_R.replace(old, new, 1))
    said = str(caught.value)
    assert "\n" not in said and "Decimal" not in said and said.startswith(str(tmp_path / "arm.toml"))
    return said.removeprefix(f"{tmp_path}/")


HEAD, LAST = 'name = "two"', "a = 0.35\nalpha = 0\n"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('kind = "R"\ntheta = "theta1"', 'kind = "X"\ntheta = "theta1"', 'line 3: joint 1: kind = "X": it is "R"'),
        ("alpha = 0\n[[", "alhpa = 0\n[[", "line 7: joint 1: unknown key 'alhpa' (did you mean 'alpha'?); known: kind"),
        ("alpha = 0\n[[joint]]", "[[joint]]", "arm.toml: line 2: joint 1: the key 'alpha' is missing; needed: kind"),
        (HEAD, "", "arm.toml: the key 'name' is missing"),
        (HEAD, "name = 5", "line 1: name = 5: it is a text"),
        (HEAD, f'{HEAD}\ntol = "z"', "arm.toml: line 2: unknown key 'tol' (did you mean 'tool'?); known: name"),
        (HEAD, f'{HEAD}\ntask = ["vx", "vq"]', 'line 2: task = ["vx", "vq"]: unknown row \'vq\' (did you mean'),
        (HEAD, f'{HEAD}\ntask = ["vx", "vx"]', "'vx' is named twice"),
        (HEAD, f'{HEAD}\npoint = "O5"', 'line 2: point = "O5": it is the origin of a frame, "O0" … "O2"'),
        (HEAD, f"{HEAD}\npoint = [1, 2]", "point = [1, 2]: it is the origin of a frame"),
        (HEAD, f'{HEAD}\npoint = ["theta1", 0, 0]', 'x = "theta1": theta1 is the variable of joint 1, and stands'),
        (HEAD, f'{HEAD}\npoint = [0, "4 cm", 0]', 'y = "4 cm": lengths are in metres; write 0.04'),
        ('a = "a1"', 'a = "f(a1)"', "line 6: joint 1: a = \"f(a1)\": the function 'f' is not understood"),
        ('a = "a1"', 'a = "theta2"', 'joint 1: a = "theta2": theta2 is the variable of joint 2, and stands nowhere'),
        ('a = "a1"', 'a = "alpha2"', 'joint 1: a = "alpha2": alpha2 names an angle'),
        ('a = "a1"', 'a = "pi/2"', 'joint 1: a = "pi/2": pi makes an angle; lengths are in metres'),
        (
            LAST,
            'a = 0.35\nalpha = "a1"\n',
            'joint 2: alpha = "a1": a1 names a length; call an angle alpha or beta, as in alpha1',
        ),
        (LAST, 'a = 0.35\nalpha = "theta7"\n', "theta7 belongs to no joint; the last one is joint 2"),
        ('a = "a1"', 'a = "1/0"', 'joint 1: a = "1/0": a division by zero; lengths are in metres, as in 0.4 or "a1"'),
        ('a = "a1"', 'a = "9**9**9**9"', "joint 1: a"),
        ('a = "a1"', 'a = "0,4"', 'joint 1: a = "0,4": decimals have a point; write 0.4'),
        ('a = "a1"', "a = true", "joint 1: a = true: it is a number"),
        ('a = "a1"', "a = inf", "joint 1: a = inf: it is a finite number"),
        ('a = "a1"', "a = 1e400", 'joint 1: a = 1E+400: it is out of range; lengths are in metres, as in 0.4 or "a1"'),
        ('a = "a1"', 'a = "d1 + 1e-30"', "it is out of range"),
        ('a = "a1"', "a = “a1”", 'line 6: not valid TOML: invalid value; its quotes are curly, write straight ones: "'),
        ('a = "a1"', 'α = "a1"', "invalid statement; a line is KEY = VALUE, a [[header]] or a # comment"),
        ('a = "a1"', 'a = "\\pi"', "unescaped '\\' in a string; formulas have no backslash"),
        (
            LAST,
            LAST + 'task = ["vx"]\n',
            "line 14: joint 2: the key 'task' stands at the top of the file, above every [[joint]]",
        ),
        (HEAD, f'{HEAD}\ntask = ["x", "y"]', "unknown row 'x' (did you mean 'vx'?)"),
        ('a = "a1"', 'a = "vx"', "means something else"),
        ('a = "a1"', 'a = "c1"', "c1 is short for a sine or cosine"),
        ('a = "a1"', 'a = "k"', "write k1"),
        ('kind = "R"', 'kind = "P"', 'joint 1: d = 0: a joint of kind "P" moves by its own variable there: d = "d1"'),
        (
            'kind = "R"\ntheta = "theta1"\nd = 0',
            'kind = "P"\ntheta = "theta1"\nd = "d1"',
            "call a constant angle alpha or b",
        ),
        ('a = "a1"', 'a = "len"', "'len' is no name for a length or angle; it is one letter, or alpha or beta,"),
        ('theta = "theta1"', "theta = 0", 'joint 1: theta = 0: a joint of kind "R" moves by its own variable'),
        ('theta = "theta1"', 'theta = "2*theta1"', 'line 4: joint 1: theta = "2*theta1": a joint of kind "R"'),
        ('theta = "theta1"', 'theta = "theta1 + theta2"', "theta2 is the variable of joint 2"),
        ('theta = "theta1"', 'theta = "theta1"\nalpha = 1.5708', "line 8: not valid TOML: cannot overwrite a value"),
        ("alpha = 0\n[[joint]]", "alpha = 1.5708\n[[joint]]", '"pi/2"'),
        ("alpha = 0\n[[joint]]", "alpha = 90\n[[joint]]", 'angles are in radians; 90 degrees would be "pi/2"'),
        (
            "alpha = 0\n[[joint]]",
            "alpha = pi/2\n[[joint]]",
            "line 7: not valid TOML: invalid value; put text and formulas",
        ),
        (
            "a = 0.35",
            "a = 0.35 m",
            "line 12: not valid TOML: expected newline or end of document after a statement; num",
        ),
        ('kind = "R"\ntheta = "theta1"', "kind = ", "line 3: not valid TOML: invalid value"),
        (
            LAST,
            LAST + "[draw]\na1 = [0.4, 0.2]\n",
            "line 15: draw: a1 = [0.4, 0.2]: the smaller end stands first; write a",
        ),
        (LAST, LAST + "[draw]\na1 = [-0.4, 0.2]\n", "draw: a1 = [-0.4, 0.2]: -0.4 is not positive"),
        (LAST, LAST + "[draw]\na1 = [0.401, 0.402]\n", "in whole centimetres; write a1 = [0.40, 0.41]"),
        (LAST, LAST + "[draw]\na1 = [0.4, 0.40]\n", "both ends are the same"),
        (LAST, LAST + "[draw]\na1 = 0.4\n", "draw: a1 = 0.4: a length has a range in metres, as in a1 = [0.3, 0.8]"),
        (LAST, LAST + "[draw]\na9 = [0.1, 0.2]\n", "draw: a9 = [0.1, 0.2]: 'a9' is no open length of the table; open"),
    ],
)
def test_a_mistake_is_told_by_place(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert said in _refused(tmp_path, old, new)


@pytest.mark.parametrize(
    ("alpha", "said"),
    [
        ("90 deg", 'angles are in radians; write "pi/2"'),
        ("90deg", 'angles are in radians; write "pi/2"'),
        ("-45°", 'angles are in radians; write "-pi/4"'),
        ("30 Degrees", 'angles are in radians; write "pi/6"'),
        ("60*deg", 'angles are in radians; write "pi/3"'),
        ("np.deg2rad(90)", 'angles are in radians; write "pi/2"'),
        ("beta + 90 deg", 'angles are in radians; write "beta + pi/2"'),
        ("pi/2 rad", 'angles are in radians; write "pi/2"'),
        ("1.5708 rad", '1.5708 looks like an angle rounded; write it exactly, "pi/2"'),
        ("0.4 m", 'm is a unit of a length; angles are in radians, as in "pi/2"'),
    ],
)
def test_units_of_angles_are_refused_with_what_to_write(tmp_path: Path, alpha: str, said: str) -> None:
    place = f'arm.toml: line 13: joint 2: alpha = "{alpha}": '
    assert _refused(tmp_path, LAST, f'a = 0.35\nalpha = "{alpha}"\n') == place + said


@pytest.mark.parametrize(
    ("a", "said"),
    [
        ("0.4 m", "lengths are in metres; write 0.4"),
        ("0.4m", "lengths are in metres; write 0.4"),
        ("400 mm", "lengths are in metres; write 0.4"),
        ("400MM", "lengths are in metres; write 0.4"),
        ("40 * cm", "lengths are in metres; write 0.4"),
        ("12 in", "lengths are in metres; write 0.3048"),
        ("a1 + 5cm", 'lengths are in metres; write "a1 + 0.05"'),
        ("a1 m", 'lengths are in metres; write "a1"'),
        ("90 deg", 'deg is a unit of an angle; lengths are in metres, as in 0.4 or "a1"'),
        ("a1 b2", 'a product is written with *; is "a1*b2" meant?'),
        ("(a1)(b2)", 'a product is written with *; is "(a1)*(b2)" meant?'),
    ],
)
def test_units_of_lengths_and_products_without_a_sign_are_refused(tmp_path: Path, a: str, said: str) -> None:
    assert _refused(tmp_path, "a = 0.35", f'a = "{a}"') == f'arm.toml: line 12: joint 2: a = "{a}": {said}'


@pytest.mark.parametrize(
    ("entry", "value"),
    [("2a1", "2*a1"), ("2(a1 + h)", "2*a1 + 2*h"), ("L_2", "L2"), ("sqrt(a1^2 + d1^2)", "sqrt(a1**2 + d1**2)")],
)
def test_what_can_be_meant_in_one_way_only_is_read(tmp_path: Path, entry: str, value: str) -> None:
    assert _read(tmp_path, TWO_R.replace("a = 0.35", f'a = "{entry}"')).joints[1].a == sp.expand(sp.sympify(value))
    turned = _read(tmp_path, TWO_R.replace(LAST, 'a = 0.35\nalpha = "2pi/3 + atan2(a1, h)"\n')).joints[1].alpha
    assert turned == 2 * sp.pi / 3 + sp.atan2(sp.Symbol("a1"), sp.Symbol("h"))


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("a = 0.35", "a = 400", "line 12: joint 2: a = 400"),
        (HEAD, f"{HEAD}\npoint = [0, 0, 400]", "line 2: point = [0, 0, 400]"),
        (LAST, LAST + "[draw]\na1 = [100, 400]\n", "line 15: draw: a1 = [100, 400]"),
    ],
)
def test_lengths_in_millimetres_are_noticed(tmp_path: Path, old: str, new: str, place: str) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(TWO_R.replace(old, new, 1), encoding="utf-8")
    said = f"{path}: {place}: lengths are in metres; is this in millimetres? 400 mm would be 0.4"
    assert read_robot_file(path).notes == (said,)
    path.write_text(TWO_R.replace(old, new.replace("400", "20"), 1).replace("100", "10"), encoding="utf-8")
    assert read_robot_file(path).notes == ()


def test_a_file_that_is_not_there_or_no_text(tmp_path: Path) -> None:
    path = tmp_path / "no-arm.toml"
    with pytest.raises(QdotError, match=r"no-arm\.toml: there is no such file"):
        read_robot(path)
    path.write_bytes(b'name = "x"\n\xff\n')
    with pytest.raises(QdotError, match=r"no-arm\.toml: line 2: this is not text in UTF-8"):
        read_robot(path)
    with pytest.raises(QdotError, match=r"the file can't be read: "):
        read_robot(tmp_path)


def test_a_file_saved_with_a_byte_order_mark_is_read(tmp_path: Path) -> None:
    assert _read(tmp_path, "\ufeff" + TWO_R).n == 2


@pytest.fixture
def hardly_any_terms(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let a determinant of more than one term be too long."""
    monkeypatch.setattr(derivation, "MOST_TERMS", 1)
    monkeypatch.setattr(shipped, "shipped", lambda _: {})
    kept: tuple[Any, ...] = (derivation._expanded_minors, derivation._generic_minors)
    for minors in kept:
        minors.cache_clear()
    yield
    for minors in kept:
        minors.cache_clear()


@pytest.mark.usefixtures("hardly_any_terms")
def test_what_would_be_too_long_to_read_is_not_worked_out(tmp_path: Path) -> None:
    """Position and Jacobian are; an arm of nine joints has tens of thousands of terms in its minors."""
    solution = solve(_read(tmp_path, TWO_R.replace('name = "two"', 'name = "too long"')))
    assert solution.determinant is None and solution.singular is None
    assert "more than 1 terms" in (solution.note or "")
    assert "not worked out" in solution_text(solution) and "not worked out" in solution_json(solution)
    assert QUESTIONS["singular-angles"].refusal(solution.chain) == QUESTIONS["determinant"].refusal(solution.chain)


def _many(count: int, alpha: str = "0") -> str:
    rows = (
        f'[[joint]]\nkind = "R"\ntheta = "theta{i}"\nd = "d{i}"\na = "a{i}"\nalpha = "{alpha}"\n'
        for i in range(1, count + 1)
    )
    return 'name = "long"\n' + "".join(rows)


def test_an_arm_of_too_many_joints_is_refused(tmp_path: Path) -> None:
    with pytest.raises(QdotError, match="11 joints are too many to be worked out; an arm has up to 10"):
        _read(tmp_path, _many(11))


@pytest.mark.whole  # in `make test`, a short arm stands for it, with a limit of hardly any terms
def test_an_arm_of_many_joints_is_worked_out_as_far_as_anyone_would_read(tmp_path: Path) -> None:
    solution = solve(_read(tmp_path, _many(8, "pi/2")))
    assert solution.singular is None
    assert "not worked out" in (solution.note or "")


def test_six_parallel_joints_count_for_their_plane(tmp_path: Path) -> None:
    assert _read(tmp_path, _many(6)).task == ("vx", "vy")


def test_rank_lost_everywhere_is_said_in_every_form(tmp_path: Path) -> None:
    text = TWO_R.replace('name = "two"', 'name = "two"\ntask = ["vx", "vz"]')
    solution = solve(_read(tmp_path, text))
    data = json.loads(solution_json(solution))
    assert data["singular"] is None and "every configuration" in data["note"]
    assert "every configuration" in solution_text(solution) and "every configuration" in solution_latex(solution)


MODIFIED = """name = "two"
convention = "modified-dh"
point = ["a2", 0, 0]
base = {position = [0, 0, 0.5], rpy = ["pi", 0, 0]}
[[joint]]
kind = "R"
theta = "theta1"
d = 0
a = 0
alpha = 0
[[joint]]
kind = "R"
theta = "theta2"
d = 0
a = "a1"
alpha = 0
limits = ["-pi/2", "3*pi/4"]
"""


def test_an_arm_is_shown_as_it_was_told_and_its_limits_rule_values_out(tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(MODIFIED)
    said = run("solve", path)
    assert "Given by a modified table (Craig)" in said and "The same arm in a modified table" in said
    assert "O₀ stands at (0, 0, 0.5) m in the world." in said  # what turns about x is in the first row
    path.write_text(MODIFIED.replace("base =", "# base ="))
    assert "Given by" not in run("solve", path)  # it is told so
    path.write_text(MODIFIED)
    assert "expressed in the world frame" in said
    assert "Limits of the joints rule out θ₂ = 180° (from −90° to 135°)." in said
    axes = tmp_path / "axes.toml"
    axes.write_text(run("solve", path, "--convert", "screws"))
    by_axes = run("solve", axes)
    assert "The axes at home" in by_axes and "Screw axes at home" in by_axes and "Denavit" not in by_axes
    assert 'base = {position = [0, 0, 0.5], rpy = ["pi", 0, 0]}' in run("solve", path, "--convert", "dh")
    assert "--convert 'craig' is none of dh, modified-dh, screws" in fails("solve", path, "--convert", "craig")


SKEW = """name = "skew"
task = ["vx", "vy", "vz"]
[[joint]]
kind = "R"
theta = "theta1"
d = "d1"
a = %s
alpha = "pi/3"
[[joint]]
kind = "R"
theta = "theta2"
d = %s
a = %s
alpha = 0
"""


@pytest.mark.parametrize(
    ("lengths", "said"),
    [
        (('"a1"', '"d2"', '"a2"'), "Only for lengths that are related to each other"),
        (("0.2", "0.1", "0.4"), "The Jacobian for this task has full rank in every configuration"),
        (("0.1", "0.1", "0.2"), "where"),  # a2^2 = a1^2 + 3 d2^2, where the conditions do hold together
    ],
)
def test_conditions_that_hold_for_special_lengths_only_are_said_of_those(
    lengths: tuple[str, str, str], said: str, tmp_path: Path
) -> None:
    path = tmp_path / "skew.toml"
    path.write_text(SKEW % lengths)
    solution = solve(read_robot(path))
    assert said in solution_text(solution).replace("\n", " ")
    assert bool(solution.singular) == (lengths[1] == "0.1" and lengths[0] == "0.1")


def test_a_twist_whose_sine_is_below_a_fraction_bar_is_no_failure(tmp_path: Path) -> None:
    path = tmp_path / "rrp.toml"
    rows = [("R", "theta1", 0, 0.2, '"pi/3"'), ("R", "theta2", 0.1, 0.3, '"-pi/4"'), ("P", None, "d3", 0, 0)]
    joints = "".join(
        f'[[joint]]\nkind = "{kind}"\ntheta = {shown(theta or 0)}\nd = {shown(d)}\na = {a}\nalpha = {alpha}\n'
        for kind, theta, d, a, alpha in rows
    )
    path.write_text(f'name = "rrp"\ntask = ["vx", "vy", "vz", "wx", "wy", "wz"]\n{joints}')
    assert solve(read_robot(path)).singular == ()


def test_a_table_is_shown_as_it_is_written_and_its_rewriting_is_said(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    row = '[[joint]]\nkind = "R"\ntheta = "-theta%d + pi/2"\nd = 0.1\na = 0.3\nalpha = "pi/2"\n'
    path.write_text('name = "m"\ntask = ["vx", "vy"]\n' + row % 1 + row % 2)
    said = run("solve", path)
    given, _, standard = said.partition("The same arm in a standard table follows")
    assert "Given by a standard table in which joints count the other way" in given
    assert "90° − θ₁" in given and "90° − θ₂" in given and "−90°" not in given
    assert "θ₁ − 90°" in standard
    path.write_text(
        'name = "m"\nconvention = "modified-dh"\nbase = {position = [0, 0, 1], rpy = ["pi/2", 0, 0]}\n' + row % 1
    )
    assert "on a base at (0, 0, 1) m, turned by roll, pitch and yaw of 90°, 0, 0" in run("solve", path).replace(
        "\n", " "
    )
    assert "--format is for what" in fails("solve", path, "--convert", "dh", "--format", "json")
    assert "--map is for what" in fails("solve", path, "--convert", "dh", "--map", str(tmp_path / "map.svg"))


EQUAL_LINKS = 'name = "arm"\n' + "".join(
    f'[[joint]]\nkind = "R"\ntheta = "theta{i}"\nd = 0\na = {a}\nalpha = 0\n' for i, a in ((1, '"a1"'), (2, "%s"))
)


@pytest.mark.parametrize(("second", "relation"), [('"a2"', "a1 = a2"), ("0.7", "a1 = 7/10")])
def test_links_of_one_length_fold_back_onto_the_base_which_is_no_boundary(
    second: str, relation: str, tmp_path: Path
) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(EQUAL_LINKS % second)
    solution = solve(read_robot(path))
    data = solution_data(solution)
    assert (data["singular"][0]["type"], data["singular"][0]["uniform"]) == ("boundary", True)
    (special,) = data["special_lengths"]
    assert special["lengths"] == relation and special["singular"][0]["uniform"] is False
    said = " ".join(solution_text(solution).split())
    assert "At θ₂ = 180°: P lies on the axis of joint 1, which then does not move it, an internal singularity" in said
    assert "Looked at were these relations of lengths: a₁ =" in said and "Others were not." in said
    path.write_text((EQUAL_LINKS % second).replace('"a1"', "0.4").replace('"a2"', "0.7"))
    assert "special_lengths" not in solution_data(solve(read_robot(path)))


def test_lengths_are_no_joints_whatever_they_are_called() -> None:
    """Two conditions are the same up to a length, which d1 is, and not up to the variable of a slide, which d3 is."""
    q1, q2, d1, d3, a2 = sp.symbols("theta1 theta2 d1 d3 a2")
    joints = Joint("R", q1, d1, 0, sp.pi / 2), Joint("R", q2, 0, a2, sp.pi / 2), Joint("P", 0, d3, 0, 0)
    chain = Chain("arm", joints, ("vx", "vy", "vz"))
    condition = a2 * sp.cos(q2) + d3 * sp.sin(q2)
    for same in (d1 * condition, -3 * d1**2 * a2 * condition):
        assert _plain(same, chain) == _plain(condition, chain)
    for other in (d3 * condition, sp.cos(q1) * condition, condition + d1):
        assert _plain(other, chain) != _plain(condition, chain)
    assert _plain(d1 * d3, chain) == _plain(-2 * a2 * d3, chain) == _plain(d3, chain)


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ("cos(theta2)", "J was found to keep its rank somewhere where `cos(theta2) = 0`: don't rely on this condition"),
        ("2 + cos(theta2)", "No configuration was found in which `cos(theta2) + 2 = 0`, in 60 searches"),
        ("theta1 - theta1", ""),
    ],
)
def test_what_a_test_in_numbers_finds_amiss_is_told(
    told: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "arm.toml"
    text = (EQUAL_LINKS % "0.7").replace('"a1"', "0.4")
    path.write_text(text.replace("arm", f"arm {told}"))  # one of which nothing is kept
    conditions = [to_sympy(read(one)) for one in ("sin(theta2)", told) if one != "theta1 - theta1"]
    components = tuple(Component((condition,), None) for condition in conditions)
    shown = [SingularComponent(one.conditions, None, Kind("", False, "x")) for one in components]
    monkeypatch.setattr("exercises.solving.singular_set", lambda _: components)
    monkeypatch.setattr(Worked, "found", shown)
    solution = solve(read_robot(path))
    assert said in (solution.note or "") and (said == "") == (solution.note is None)
    monkeypatch.setattr(Worked, "found", [])
    worked_steps.cache_clear()
    note = solve(read_robot(path)).note
    assert note is not None and "60 ended in configurations that none of these conditions accounts for" in note


BY_AXES = """name = "by its axes"
convention = "screws"
point = %s
[[joint]]
kind = "R"
axis = [0, 0, 1]
point = [0.1, 0.2, 0.5]
[[joint]]
kind = "P"
axis = [0, 1, 1]
[[joint]]
kind = "R"
axis = [1, 0, 0]
point = [0, "a1", 0.3]
"""


def test_json_of_an_arm_told_by_axes_has_its_space_and_body_jacobian(tmp_path: Path) -> None:
    """Held against exponentials of the told axes: where they take axes, and how the body frame then stands."""
    path = tmp_path / "axes.toml"
    path.write_text(BY_AXES % "[0.3, 0.4, 0.6]")
    solution = solve(read_robot(path))
    data = json.loads(solution_json(solution))
    assert errors("solve", data) == [] and data["twist_rows"] == ["wx", "wy", "wz", "vx", "vy", "vz"]
    values = {sp.Symbol(name): value for name, value in (("theta1", 0.4), ("d2", -0.3), ("theta3", 1.2), ("a1", 0.7))}
    q, lengths = np.array([0.4, -0.3, 1.2]), {sp.Symbol("a1"): 0.7}
    up = np.array([0.0, 1.0, 1.0]) / np.sqrt(2)
    told = [
        ("R", np.array([0.0, 0, 1]), [0.1, 0.2, 0.5]),
        ("P", up, [0, 0, 0]),
        ("R", np.array([1.0, 0, 0]), [0, 0.7, 0.3]),
    ]
    axes = [Axis(kind, sp.Matrix(along), sp.Matrix(through)) for kind, along, through in told]

    def moved(count: int, point: Any) -> np.ndarray:
        return reached(axes[:count], sp.Matrix(point), q[:count], lengths)

    space = []
    for i, (kind, along, through) in enumerate(told):
        there = moved(i, through)
        direction = moved(i, through + along) - there
        space.append([*direction, *np.cross(there, direction)] if kind == "R" else [0, 0, 0, *direction])
    P = np.array([0.3, 0.4, 0.6])
    there = moved(3, P)
    turned = np.array([moved(3, P + step) - there for step in np.eye(3)]).T
    body = [[*turned.T @ column[:3], *turned.T @ (column[3:] + np.cross(column[:3], there))] for column in space]
    for key, expected in (("space_jacobian", space), ("body_jacobian", body)):
        ours = [[_number(entry, values) for entry in row] for row in data[key]]
        np.testing.assert_allclose(ours, np.array(expected).T, atol=1e-12)
    path.write_text(BY_AXES % "{frame = 2, offset = [0.3, 0.4, 0.6]}")
    data = json.loads(solution_json(solve(read_robot(path))))
    assert errors("solve", data) == []
    assert data["body_jacobian"] is None and len(data["space_jacobian"]) == 6  # P is on link 2
    assert "space_jacobian" not in solution_data(solve(read_robot(_table(path))))


def _table(path: Path) -> Path:
    """Write an arm that is told by a table, and return its file."""
    path.write_text(TWO_R)
    return path


TWO_BY_AXES = """name = "two"
convention = "screws"
task = ["vx", "vz"]
point = [0.4, 0, 0.2]
[[joint]]
kind = "R"
axis = [0, 1, 0]
point = [0, 0, 0]
[[joint]]
kind = "R"
axis = [0, 1, 0]
point = [0.3, 0, 0]
"""


@pytest.mark.parametrize("arm", [TWO_R.replace('"a1"', "0.4"), TWO_BY_AXES], ids=["table", "axes"])
@pytest.mark.parametrize(("rpy", "rounded"), [("[0.3, 0.2, 0]", True), ('["pi/3", 0, 0]', False)])
def test_numbers_that_are_rounded_are_told_to_be(arm: str, rpy: str, rounded: bool, tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(arm.replace("[[joint]]", f"base = {{rpy = {rpy}}}\n[[joint]]", 1))
    robot = read_robot_file(path)
    stages = (stage for stage in text_stages(robot.chain, robot) if isinstance(stage, Ready))
    texts = {stage.name: " ".join(to_text(stage.content).split()) for stage in stages}
    assert ("Some of its numbers have no short form and are rounded to ten decimals" in texts["arm"]) == rounded
    assert ("Numbers in these conditions are rounded" in texts["singular-angles"]) == rounded
    said: list[str] = []
    write_solution(robot, "json", 0.3, said.append, lambda _: nullcontext())
    content = json.loads("".join(said))
    assert errors("solve", content) == [] and content.get("rounded", False) == rounded
