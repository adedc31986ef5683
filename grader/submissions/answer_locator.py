"""Where in a notebook the answer to each part is: by the variable's name, and by the answer cell's metadata.

The value that the variable has at the end of the notebook counts: it is what a student sees who runs all cells.
Whatever else is read, for an answer that is there must not be lost, is said in a note. Cells are counted from the top,
text too.
"""

import ast
import difflib
import itertools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from qdot.exercises.problem.problem import Problem, variable
from qdot.grader.sandbox.contained.ipython import python_of
from qdot.grader.sandbox.sandbox import Run
from qdot.grader.submissions.cells import Cell, OverLimit, first_fault, parsed, plain

MOST = 50
"""Text cells, and names that may be misspelt, that are looked into for an answer."""

LONGEST = 30_000
"""Characters of a cell that is looked into; one that is longer is run all the same."""

MOST_PARSED = 3_000_000
"""Characters of a notebook's cells that are parsed in all, what is parsed again being remembered."""

RunCells = Callable[[Sequence[str], Sequence[str]], Run]
"""Runs cells and returns what variables of these names hold."""


@dataclass
class Answers:
    """What a notebook answers: the run, why each missing part is missing, by variable, and what is to be said.

    `refused` has the cells that stopped at what no notebook may do, for the staff.
    """

    run: Run
    reasons: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)

    def of(self, slot: str, problem: Problem) -> dict[str, str]:
        """Return the texts of the answers to a problem, by part."""
        names = {part.name: variable(slot, part.name) for part in problem.parts}
        return {part: self.run.answers[name] for part, name in names.items() if name in self.run.answers}

    def reason(self, slot: str, part: str) -> str:
        """Return why there is no answer to a part; nothing where there is one."""
        return self.reasons.get(variable(slot, part), "")


def find_answers(cells: Sequence[Cell], parts: Sequence[str], run: RunCells) -> Answers:
    """Run a notebook and find the answers to `parts`, called as in "p1.jacobian".

    Raises OverLimit where it takes too long to find out which cells have them.
    """
    names = {part: variable(*part.split(".", 1)) for part in parts}
    book = _Book(cells, names)
    for part in parts:
        book.look_for(part)
    order = sorted(book.sources)
    sources = [book.sources[index] for index in order]
    result = run(sources, list(names.values()))
    failed = {order[place]: error for place, error in result.cell_errors.items()}
    stops = {order[place]: _stop(book, order[place], result, place) for place in {*result.cell_errors, *result.missed}}
    answers = Answers(result, notes=book.notes)
    answers.notes += _first_stop(book, stops)
    answers.refused += [stops[index] for index in sorted(failed) if failed[index].startswith("PermissionError")]
    answers.notes += [_lost(name, order[index], value) for name, (index, value) in result.lost.items()]
    answers.notes += [*_stopped(failed, result, book), *([end] if (end := _end(result, order)) else [])]
    again = _Again(run, sources, order, failed)
    for part, name in names.items():
        if _is_missing(result, name):
            _take_an_earlier_value(answers, name)
        if _is_missing(result, name):
            _run_once_more(answers, name, book, again)
        if name in result.answers:
            _tell_several(answers, part, name, book, failed)
        else:
            answers.reasons[name] = _why_missing(part, name, book, result, order, stops)
    return answers


def asked_in(cells: Sequence[Cell], questions: Sequence[str]) -> list[str]:
    """Return the parts that a notebook seems to have, by metadata and by the names that it sets."""
    endings = {question.replace("-", "_"): question for question in questions}
    parts = dict[str, None]()
    for cell in cells:
        if cell.part is not None and re.fullmatch(r"p\d+\.[a-z0-9-]+", cell.part):
            parts[cell.part] = None
        for slot, ending in re.findall(r"(?m)^[ \t]*(p\d+)_(\w+) *=(?!=)", cell.source):
            if ending in endings:
                parts[f"{slot}.{endings[ending]}"] = None
    return list(parts)


# --- what cells set ---


class _Book:
    """A notebook's cells: what each sets, what is run for it, and what is to be said."""

    def __init__(self, cells: Sequence[Cell], names: Mapping[str, str]) -> None:
        self.cells, self.names, self.notes = cells, names, list[str]()
        self._trees, self._left = dict[str, ast.Module | None](), MOST_PARSED
        self.sources = {index: cell.source for index, cell in enumerate(cells) if cell.is_code}
        slots = "|".join(sorted({re.escape(part.split(".")[0]) for part in names})) or "$^"
        self._relevant = re.compile(rf"\b(?:{slots})_?\w", re.IGNORECASE)
        self.sets = {index: self._set_by(index) for index in self.sources}

    def _set_by(self, index: int) -> set[str]:
        """Return the names that a cell sets, of those that look like the names of answers."""
        cell = self.cells[index]
        if cell.part not in self.names and not self._relevant.search(cell.source):
            return set()
        tree = self._tree(cell.source)
        if tree is None:  # by the look of it: why the cell stops is told when it is run
            return set(re.findall(r"(?m)^[ \t]*(\w+)\b[^\n=!<>]*=(?!=)", cell.source[:LONGEST]))
        return set(_bound(tree, cell.source))

    def setters(self, name: str) -> list[int]:
        """Return the cells that set a variable."""
        return [index for index, names in self.sets.items() if name in names]

    def marked(self, part: str) -> list[int]:
        """Return the cells that the metadata call the answer to a part, text among them."""
        return [index for index, cell in enumerate(self.cells) if cell.part == part]

    def look_for(self, part: str) -> None:
        """See to it that the answer to a part is read, whatever its cell has become."""
        name, setters = self.names[part], self.setters(self.names[part])
        marked = [index for index in self.marked(part) if index in self.sources]
        if setters:
            own = [index for index in marked if isinstance(self._answer_in(index), ast.Assign)]
            if own and not set(marked) & set(setters):
                self.notes.append(
                    f"{name} is set in {_cells(setters)}, and was read there; "
                    f"the answer cell, {_cells(own)}, does not set it"
                )
            return
        assigns = [index for index in marked if isinstance(self._answer_in(index), ast.Assign)]
        several = f", the last of {_cells(marked)}," if len(marked) > 1 else ""
        for index in reversed(assigns or marked):
            if self._read_as(index, part, f"{_cells([index])}{several} is the answer cell of {name}"):
                return
        says = re.compile(rf"(?m)^ *`*{name} *=(?!=)")
        texts = (index for index, cell in enumerate(self.cells) if not cell.is_code and index not in self.sources)
        answers = (index for index in texts if self.cells[index].part == part or says.search(self.cells[index].source))
        if any(self._read_text(index, part) for index in itertools.islice(answers, MOST)):
            return
        self._look_for_misspelt(name)

    def _look_for_misspelt(self, name: str) -> None:
        """Read another variable for one that nothing sets, if there is one that is nearly called so."""
        close = {other for names in self.sets.values() for other in names if abs(len(other) - len(name)) < 3}
        near = [other for other in sorted(close)[:MOST] if self._is_near(name, other)]
        if len(near) == 1:
            index = self.setters(near[0])[-1]
            if self._rename(index, name, near[0]):
                self.notes.append(f"{name} is not set anywhere; {near[0]} in {_cells([index])} was read for it")

    def _is_near(self, name: str, other: str) -> bool:
        """Tell whether another name is this one misspelt: P1_Jacobian, p1_jacobain."""
        if other in self.names.values() or other[:2].casefold() != name[:2].casefold():
            return False
        closest = difflib.get_close_matches(other.casefold(), list(self.names.values()), 1, 0.87)
        return closest == [name]

    def _answer_in(self, index: int) -> "ast.Assign | ast.Expr | None":
        """Return the statement of an answer cell that gives its answer, whatever the variable is called."""
        tree = self._tree(self.sources[index])
        if tree is None or not tree.body:
            return None
        assigned = {
            target.id: statement
            for statement in tree.body
            if isinstance(statement, ast.Assign) and isinstance(target := statement.targets[-1], ast.Name)
        }
        last = tree.body[-1]
        if isinstance(last, ast.Expr) and isinstance(last.value, ast.Name):
            return assigned.get(last.value.id, last)
        if isinstance(last, ast.Expr) and not assigned and not _shows(last):
            return last
        return max(assigned.values(), key=lambda found: (found.lineno, found.col_offset), default=None)

    def _read_as(self, index: int, part: str, because: str) -> bool:
        """Have the value of an answer cell read as the answer to its part. Return whether it has one."""
        name, statement = self.names[part], self._answer_in(index)
        if statement is None:
            return False
        target = statement.targets[-1] if isinstance(statement, ast.Assign) else None
        other = target.id if isinstance(target, ast.Name) else ""
        if target is not None and other in self.names.values():
            if self.setters(other) == [index]:
                return False  # it is the only answer to the other part
            self._write(index, target.lineno, target.col_offset, target.end_col_offset or 0, name)
        else:
            self._write(index, statement.lineno, statement.col_offset, statement.col_offset, f"{name} = ")
        self.sets[index] = self.sets[index] | {name}
        what = "is no assignment: its value" if not other else f"sets {other}, which"
        self.notes.append(f"{because} and {what} was read for it")
        return True

    def _rename(self, index: int, name: str, other: str) -> bool:
        """Have another variable, where a cell sets it, read as the answer."""
        tree = self._tree(self.sources[index])
        for statement in reversed(tree.body if tree else []):
            if isinstance(statement, ast.Assign) and any(
                isinstance(t, ast.Name) and t.id == other for t in statement.targets
            ):
                self._write(index, statement.lineno, statement.col_offset, statement.col_offset, f"{name} = ")
                return True
        return False

    def _write(self, index: int, number: int, begin: int, end: int, text: str) -> None:
        """Put a text in place of some bytes of a line, which is how Python counts."""
        lines = python_of(self.sources[index]).split("\n")
        line = lines[number - 1].encode()
        lines[number - 1] = (line[:begin] + text.encode() + line[end:]).decode()
        self.sources[index] = "\n".join(lines)

    def _read_text(self, index: int, part: str) -> bool:
        """Have Python in a text cell run, where the answer is nowhere else. Return whether there is any."""
        name = self.names[part]
        code = self._code_in(self.cells[index].source, name)
        if code is None:
            return False
        said = f"{_cells([index])} is a text cell, not code"
        tree = self._parsed(code)
        self.sources[index], self.sets[index] = code, set(_bound(tree, code)) if tree else {name}
        if name in self.sets[index]:
            self.notes.append(f"{said}; what it says was read for {name} as if it were code")
        elif not self._read_as(index, part, f"{said},"):
            del self.sources[index], self.sets[index]
            return False
        return True

    def _tree(self, source: str) -> ast.Module | None:
        """Return the tree of a cell that is not too long, as it is run."""
        return self._parsed(python_of(source)) if len(source) <= LONGEST else None

    def _parsed(self, code: str) -> ast.Module | None:
        """Return the tree of a text that is Python. Raises OverLimit where too much was parsed."""
        if code not in self._trees:
            self._left -= len(code)
            if self._left < 0:
                raise OverLimit(
                    "its cells have too much code in them for answers to be looked for; remove what is no answer"
                )
            self._trees[code] = parsed(code, LONGEST)
        return self._trees[code]

    def _code_in(self, text: str, name: str) -> str | None:
        """Return the Python in a text cell: all of it, without fences, else what follows after `name =`."""
        lines = [line for line in text[:LONGEST].split("\n") if not re.match(r"\s*(```|~~~)", line)]
        whole = "\n".join(lines).strip().strip("`")
        tree = self._parsed(whole)
        if tree is not None and any(map(_is_answer, tree.body)):
            return whole
        begin = next((n for n, line in enumerate(lines) if re.match(rf" *`*{name} *=(?!=)", line)), None)
        if begin is None:
            return None
        lines = lines[begin : begin + 60]
        while lines:
            code = "\n".join(lines).strip().strip("`")
            if self._parsed(code) is not None:
                return code
            del lines[max(0, min(first_fault(code), len(lines)) - 1) :]
        return None


def _bound(tree: ast.AST, source: str) -> Iterator[str]:
    """Yield the names that statements set, those inside of functions left out."""
    looked_into = ":=" in source or "for" in source
    left = [tree]  # a sum of a thousand terms is a thousand deep: no recursion
    while left:
        for node in ast.iter_child_nodes(left.pop()):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                yield node.id
            elif isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.AsyncFunctionDef)):
                yield node.name
            elif not isinstance(node, ast.Lambda) and (looked_into or not isinstance(node, VALUES)):
                left.append(node)


VALUES = (ast.BinOp, ast.UnaryOp, ast.Call, ast.Constant, ast.Compare, ast.BoolOp, ast.Dict, ast.Set)
"""Expressions in which nothing is set but by a walrus or in a comprehension; answers are made of them."""


def _shows(statement: ast.Expr) -> bool:
    """Tell whether a statement only shows something, or is a magic of IPython's."""
    called = statement.value.func if isinstance(statement.value, ast.Call) else None
    if isinstance(called, ast.Attribute):
        return called.attr in ("show", "run_line_magic", "run_cell_magic", "system", "getoutput")
    return isinstance(called, ast.Name) and called.id in ("print", "display", "pprint", "init_printing", "help")


def _is_answer(statement: ast.stmt) -> bool:
    """Tell a statement from a word or two of prose, which may be Python, too."""
    written = isinstance(statement, ast.Expr) and isinstance(statement.value, (ast.Call, ast.BinOp, ast.List, ast.Dict))
    return written or isinstance(statement, ast.Assign)


# --- what was read ---


def _is_blank(text: str) -> bool:
    return re.fullmatch(r"(?:blank|[\s\[\](){},\"'])*", text) is not None


def _is_missing(run: Run, name: str) -> bool:
    return name not in run.answers or _is_blank(run.answers[name])


def _take_an_earlier_value(found: Answers, name: str) -> None:
    """Read the last value that was one, where the variable holds a placeholder at the end, or what can't be read."""
    run = found.run
    earlier = [text for text in run.earlier.get(name, ()) if not _is_blank(text)]
    if earlier:
        became = "left blank" if name in run.answers else f"no value that can be read ({run.failures.get(name, '')})"
        run.answers[name] = earlier[-1]
        run.failures.pop(name, None)
        found.notes.append(f"{name} is {became} at the end of the notebook; its value before that was read")


def _lacks_name(error: str) -> bool:
    return error.startswith("NameError")


@dataclass
class _Again:
    """A second run, in which cells that lacked a name come once more after all others; made when it is needed first."""

    run: RunCells
    sources: list[str]
    order: list[int]
    failed: Mapping[int, str]
    _second: Run | None = None

    def cells(self) -> list[int]:
        return [index for index in self.order if _lacks_name(self.failed.get(index, ""))]

    def value(self, name: str, names: Sequence[str]) -> str | None:
        """Return what a variable holds after the second run."""
        if self._second is None:
            by_index = dict(zip(self.order, self.sources, strict=True))
            self._second = self.run([*self.sources, *(by_index[index] for index in self.cells())], names)
        return self._second.answers.get(name)


def _run_once_more(found: Answers, name: str, book: _Book, again: _Again) -> None:
    """Run cells that stopped for want of a name again, after all others: in Jupyter, cells are run in any order."""
    setters = [index for index in again.cells() if index in book.setters(name)]
    if not setters or found.run.end != "done":
        return
    value = again.value(name, list(book.names.values()))
    if value is not None and not _is_blank(value):
        found.run.answers[name] = value
        why = again.failed[setters[-1]]
        found.notes.append(
            f"{_cells(setters)} stopped ({why}), and was run again after all other cells, which gave {name}"
        )


def _tell_several(found: Answers, part: str, name: str, book: _Book, failed: Mapping[int, str]) -> None:
    """Say which value was read, where several cells set it to different ones."""
    setters = book.setters(name)
    if len(setters) < 2 or any(said.startswith(f"{name} is ") for said in found.notes):
        return
    stopped = [index for index in setters if index in failed]
    values = {text for text in found.run.earlier.get(name, ()) if not _is_blank(text)}
    if stopped:
        found.notes.append(f"{name} is set in {_cells(setters)}, and {_cells(stopped)} stopped ({failed[stopped[-1]]})")
    elif len(values) > 1 and len([index for index in setters if book.cells[index].part in (part, None)]) > 1:
        found.notes.append(f"{name} is set in {_cells(setters)}; its value at the end of the notebook was read")


def _lost(name: str, index: int, value: str) -> str:
    """Say that a number stood for a symbol where an answer was worked out."""
    name = plain(name)
    return (
        f"{name} = {plain(value)} in {_cells([index])} puts a number in the place of the symbol, in the answers after "
        f"it, too: for a value use .subs, and write {name} = symbols('{name}') to have the symbol again"
    )


def _stopped(failed: Mapping[int, str], run: Run, book: _Book) -> list[str]:
    """Say which cells were stopped for their time, and what of them was read all the same."""
    notes = []
    for index, why in failed.items():
        if why.startswith(OVERTIME):
            read = [name for name in book.names.values() if name in book.sets[index] and name in run.answers]
            said = f"; {' and '.join(read)}, which it had set by then, was read" if read else ""
            notes.append(f"{_cells([index])} was stopped: {why}{said}")
    return notes


OVERTIME = "it took longer than", "it waited longer than"
"""How it is told that a cell took all its time."""


def _stop(book: _Book, index: int, run: Run, place: int) -> str:
    """Say where a cell stopped, or which import it went on without, and why."""
    said = [_without(book, index, run, place)]
    if place in run.cell_errors:
        where = f" at {_line(book, index, run.stopped_at[place])}" if place in run.stopped_at else ""
        said.append(f"{_cells([index])} stopped{where} ({run.cell_errors[place]})")
    return "; ".join(filter(None, said))


def _without(book: _Book, index: int, run: Run, place: int) -> str:
    """Say which import a cell went on without, and why; nothing where it lacks none."""
    if place not in run.missed:
        return ""
    number, why = run.missed[place]
    return f"{_cells([index])} went on without {_line(book, index, number)} ({why})"


def _line(book: _Book, index: int, number: int) -> str:
    lines = book.sources[index].split("\n")
    return f"line {number}" + (f", {plain(lines[number - 1].strip())}" if number <= len(lines) else "")


def _first_stop(book: _Book, stops: Mapping[int, str]) -> list[str]:
    """Say of the first cell above all answers that stopped that it did: what is below may lack what it was to make."""
    first_answer = min((index for index, names in book.sets.items() if names), default=len(book.cells))
    return [stops[index] for index in sorted(stops) if index < first_answer][:1]


def _why_missing(
    part: str, name: str, book: _Book, run: Run, order: Sequence[int], stops: Mapping[int, str]
) -> str:  # fmt: skip
    """Return why a part has no answer, in words."""
    if name in run.failures:
        return f"{name} has no value that can be read: {run.failures[name]}"
    failed = {order[place]: error for place, error in run.cell_errors.items()}
    places = [*book.setters(name), *book.marked(part)]
    stopped = next((index for index in places if index in failed), None)
    if stopped is not None:
        behind = _without(book, stopped, run, order.index(stopped)) or _behind(failed[stopped], stopped, book, stops)
        behind = behind or next((meant for error, meant in _MEANT.items() if error in failed[stopped]), "")
        return f"its cell stopped: {failed[stopped]}" + (f"; {behind}" if behind else "")
    if run.end != "done":
        return _end(run, order)
    if not places:
        return f"{name} is not set anywhere in the notebook"
    texts = [index for index in places if index not in book.sources]
    if len(texts) == len(places):
        return f"its cell ({_cells(texts)}) is text and not code, and no Python in it can be read"
    return f"its cell does not set {name}"


def _end(run: Run, order: Sequence[int]) -> str:
    """Say how a notebook ended that did not come to its end, and in which cell."""
    return run.note() if run.begun is None else run.note(_cells([order[run.begun]]))


_MEANT = {
    "for ^:": "in Python, a power is written **, as in a1**2; or put the answer into quotes, as text",
    "invalid character": "put an answer with such a character into quotes, as text",
}
"""What is said of an error that tells a beginner little."""


def _behind(error: str, stopped: int, book: _Book, stops: Mapping[int, str]) -> str:
    """Say which cell above stopped, where a cell lacks a name: the first that speaks of the name, else the first."""
    lacking = re.match(r"NameError: name '(\w+)'", error)
    above = [index for index in sorted(stops) if index < stopped] if lacking else []
    likely = [index for index in above if lacking and lacking[1] in book.sources[index]] or above
    return stops[likely[0]] if likely else ""


def _cells(indices: Sequence[int]) -> str:
    """Return how cells are named to people, as in "cells 3 and 7"."""
    numbers = [str(index + 1) for index in indices[:6]] + (["…"] if len(indices) > 6 else [])
    return f"cell {numbers[0]}" if len(numbers) == 1 else f"cells {', '.join(numbers[:-1])} and {numbers[-1]}"
