"""A PrairieLearn course folder: a question for every place of an assignment, whose server.py calls qdot."""

import hashlib
import json
import uuid
from collections.abc import Generator

from exercises.assignment import SECRET_FILE, Assignment, Slot
from exercises.exports.bank import bank
from exercises.exports.outlet import File, Order, robots
from exercises.render import render

BANK_FILE = "bank.json"
"""The seeds of the certified variants, by place."""
TOPIC = "Velocity kinematics"


def course(order: Order) -> Generator[File, None, None]:
    """Yield the course's files; the secret is not among them, the seeds of the bank's problems are."""
    assignment = order.assignment
    key = assignment.key.lower()
    seeds: dict[str, list[str]] = {slot.name: [] for slot in assignment.slots}
    for variant in bank(order):
        seeds[variant.slot.name].append(str(variant.problem.id.seed))  # as text: JavaScript rounds whole numbers
    yield File("infoCourse.json", _json(_course(assignment)))
    for slot in assignment.slots:
        folder, title = f"questions/{key}-{slot.name}", f"{assignment.title}: {slot.name} ({slot.family.name})"
        info = {
            "uuid": question_uuid(assignment, slot),
            "title": title,
            "topic": TOPIC,
            "tags": ["qdot"],
            "type": "v3",
        }
        yield File(f"{folder}/info.json", _json(info))
        yield File(f"{folder}/question.html", render("exports/prairielearn/question.html.j2"))
        words = {"title": title.replace("\\", " ").replace('"', "'"), "slot": slot.name, "folder": f"qdot/{key}"}
        yield File(f"{folder}/server.py", render("exports/prairielearn/server.py.j2", **words))
    yield from _server_files(assignment, f"serverFilesCourse/qdot/{key}", seeds)


def _server_files(assignment: Assignment, folder: str, seeds: dict[str, list[str]]) -> Generator[File, None, None]:
    text = (assignment.folder / "assignment.toml").read_text(encoding="utf-8")
    yield File(f"{folder}/assignment.toml", text, private=True)
    for name in sorted(robots(assignment)):
        yield File(f"{folder}/{name}", (assignment.folder / name).read_text(encoding="utf-8"), private=True)
    yield File(f"{folder}/roster.csv", "student\nprairielearn\n", private=True)
    yield File(f"{folder}/{SECRET_FILE}", _derived(assignment, "seed") + "\n", private=True)
    yield File(f"{folder}/{BANK_FILE}", _json({"digest": assignment.edition, "seeds": seeds}), private=True)
    yield File(f"{folder}/README.md", render("exports/prairielearn/assignment-README.md.j2"))


def _derived(assignment: Assignment, use: str) -> str:
    """Return a text from which nobody finds the secret, other for each use."""
    return hashlib.sha256(f"qdot/prairielearn/{use}/{assignment.secret}".encode()).hexdigest()


def question_uuid(assignment: Assignment, slot: Slot) -> str:
    """Return the question's UUID: the same at every export of a place of an assignment, whatever it asks."""
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f"qdot:{_derived(assignment, 'uuid')}:{assignment.key}:{slot.name}"))


def _course(assignment: Assignment) -> dict[str, object]:
    topic = {"name": TOPIC, "color": "blue3", "description": "Velocities and singularities of robot arms"}
    tag = {"name": "qdot", "color": "gray2", "description": "Made and graded by qdot"}
    return {"name": assignment.key, "title": assignment.title, "topics": [topic], "tags": [tag]}


def _json(content: object) -> str:
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"
