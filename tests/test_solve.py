"""`qdot solve`: the textbook's arms come out as the textbook has them, and mistakes in a file are told by place."""

import json
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

from exercises.arm.chain import TASK_ROWS, Chain
from exercises.arm.classification import domain_of
from exercises.arm.derivation import derive
from exercises.arm.robot_file import to_sympy
from exercises.errors import QdotError
from exercises.formula.conditions import Space, compare_sets, pieces
from exercises.formula.expression import read
from exercises.solve import Solution, read_robot, solution_data, solution_json, solution_latex, solution_text, solve

TRUTH = json.loads((Path(__file__).parent / "data" / "ground_truth.json").read_text(encoding="utf-8"))
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


@pytest.mark.parametrize("name", SMALL)
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
    assert "Straightening joint 2 alone" in " ".join(solution_text(solution).split())


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


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('kind = "R"\ntheta = "theta1"', 'kind = "X"\ntheta = "theta1"', "joint 1: kind = 'X'"),
        ("alpha = 0\n[[joint]]", "alhpa = 0\n[[joint]]", "joint 1: unknown key 'alhpa' (did you mean 'alpha'?)"),
        ("alpha = 0\n[[joint]]", "[[joint]]", "joint 1: 'alpha' is missing"),
        ('name = "two"', "", "'name' is missing"),
        ('name = "two"', 'name = "two"\ntask = ["vx", "vq"]', "task: unknown row 'vq' (did you mean"),
        ('name = "two"', 'name = "two"\ntask = ["vx", "vx"]', "'vx' is named twice"),
        ('name = "two"', 'name = "two"\npoint = "O5"', "O2"),
        ('name = "two"', 'name = "two"\npoint = [1, 2]', "[x, y, z]"),
        ('a = "a1"', 'a = "f(a1)"', "joint 1: a = 'f(a1)'"),
        ('a = "a1"', 'a = "theta2"', "joint 1: a = theta2"),
        ('a = "a1"', 'a = "1/0"', "joint 1: a = '1/0': a division by zero"),
        ('a = "a1"', 'a = "9**9**9**9"', "joint 1: a"),
        ('a = "a1"', "a = true", "joint 1: a = True"),
        ('a = "a1"', "a = inf", "joint 1: a = Infinity"),
        ('a = "a1"', 'a = "vx"', "means something else"),
        ('theta = "theta1"', "theta = 0", 'theta = "theta1"'),
        ('theta = "theta1"', 'theta = "2*theta1"', "theta1 plus a constant"),
        ('theta = "theta1"', 'theta = "theta1"\nalpha = 1.5708', "arm.toml is not valid TOML"),
        ("alpha = 0\n[[joint]]", "alpha = 1.5708\n[[joint]]", '"pi/2"'),
        ("alpha = 0\n[[joint]]", "alpha = 90\n[[joint]]", '"pi/2"'),
        ('kind = "R"\ntheta = "theta1"', "kind = ", "arm.toml is not valid TOML"),
    ],
)
def test_a_mistake_is_told_by_place(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in TWO_R
    with pytest.raises(QdotError) as caught:
        _read(tmp_path, TWO_R.replace(old, new, 1))
    assert said in str(caught.value) and "arm.toml" in str(caught.value) and "\n" not in str(caught.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(QdotError, match=r"no-arm\.toml can't be read"):
        read_robot(tmp_path / "no-arm.toml")


def test_rank_lost_everywhere_is_said_in_every_form(tmp_path: Path) -> None:
    text = TWO_R.replace('name = "two"', 'name = "two"\ntask = ["vx", "vz"]')
    solution = solve(_read(tmp_path, text))
    data = json.loads(solution_json(solution))
    assert data["singular"] is None and "every configuration" in data["note"]
    assert "every configuration" in solution_text(solution) and "every configuration" in solution_latex(solution)
