"""Locate the answer to each part in a notebook, by the variable's name and by the answer cell's metadata.

An answer cell is a cell whose metadata name a part. The value of the part's variable at the end of the notebook counts,
because students who run all cells see the same value. If that value is missing or blank, qdot may use another one and
notes this for the student. In notes, cells are numbered from the top, including text cells.
"""

import ast
import difflib
import functools
import itertools
import re
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field

import sympy

from qdot.exercises.problem.problem import Problem, name_answer_variable
from qdot.grader.sandbox.notebook_process.ipython import translate_to_python
from qdot.grader.sandbox.sandbox import Run
from qdot.grader.submissions.cells import Cell, OverLimit, find_first_syntax_error, make_printable, parse_python

MAX_SEARCHED_CANDIDATES = 50
"""Maximum number of text cells, and of variables with similar names, that are searched for an answer."""

MAX_TEXT_LINES = 60
"""Maximum number of lines of a text cell that are tried as the code of an answer."""

MAX_CELL_CHARACTERS = 30_000
"""Maximum length in characters of a cell that is parsed for answers; longer cells are only run."""

MAX_PARSED_CHARACTERS = 3_000_000
"""Maximum total number of characters that are parsed for a notebook; equal texts are parsed only once."""

RunCells = Callable[[Sequence[str | None], Sequence[str]], Run]
"""A function that runs cells, except those that are None, and returns the run with the values of named variables."""


@dataclass
class Answers:
    """The answers of a notebook: its run with the answers by variable, and notes for the student.

    `missing_reasons` maps the variable of each missing answer to the reason why it is missing. `forbidden_stops` has a
    note for the staff on each cell that stopped because it tried something forbidden.
    """

    run: Run
    missing_reasons: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    forbidden_stops: list[str] = field(default_factory=list)

    def map_texts(self, slot: str, problem: Problem) -> dict[str, str]:
        """Map the name of each answered part of a problem to the text of its answer."""
        variables = {part.name: name_answer_variable(slot, part.name) for part in problem.parts}
        return {part: self.run.answers[name] for part, name in variables.items() if name in self.run.answers}

    def explain_missing(self, slot: str, part: str) -> str:
        """Return the reason why there is no answer to a part; empty if there is an answer."""
        return self.missing_reasons.get(name_answer_variable(slot, part), "")


def find_answers(
    cells: Sequence[Cell], parts: Sequence[str], run_cells: RunCells, parts_in_words: AbstractSet[str] = frozenset()
) -> Answers:
    """Run a notebook and find the answers to `parts`, which have names such as "p1.jacobian".

    An answer to one of the `parts_in_words` is the text of its cell if Python can't run the cell. If the cell is blank,
    the answer is the text of the text cells that a student added beside it. Raises OverLimit if the search would take
    too long.
    """
    variables = {part: name_answer_variable(*part.split(".", 1)) for part in parts}
    notebook = _Notebook(cells, variables)
    for part in parts:
        notebook.locate_answer(part)
    sources = [notebook.sources.get(index) for index in range(len(cells))]
    run = run_cells(sources, list(variables.values()))
    errors = run.cell_errors
    cells_lacking_name = [index for index, error in sorted(errors.items()) if error.startswith("NameError")]

    @functools.cache
    def run_again() -> Run:
        """Run the cells that lacked a name again after all others, because students can run cells in any order."""
        return run_cells([*sources, *(sources[index] for index in cells_lacking_name)], list(variables.values()))

    stop_notes = {index: _describe_stop(notebook, index, run) for index in sorted({*errors, *run.failed_imports})}
    forbidden_cells = [index for index, error in sorted(errors.items()) if error.startswith("PermissionError")]
    answers = Answers(run, {}, notebook.notes, [stop_notes[index] for index in forbidden_cells])
    answers.notes += _find_first_stop(notebook, stop_notes)
    answers.notes += [_describe_replacement(name, *replacement) for name, replacement in run.replaced_symbols.items()]
    answers.notes += _describe_overtime(notebook, run)
    if end_note := _describe_end(run):
        answers.notes.append(end_note)
    for part, name in variables.items():
        if _is_missing(run, name):
            _use_earlier_value(answers, name)
        setters = [index for index in cells_lacking_name if index in notebook.find_setters(name)]
        if _is_missing(run, name) and setters and run.end == "done":
            _use_second_run(answers, name, setters, run_again())
        if _is_missing(run, name) and part in parts_in_words:
            _use_words_of_cell(answers, part, name, notebook)
        if _is_missing(run, name) and part in parts_in_words:
            _use_words_beside_cell(answers, part, name, notebook)
        if name in run.answers:
            _note_several_values(answers, part, name, notebook)
        else:
            answers.missing_reasons[name] = _explain_missing(part, name, notebook, run, stop_notes)
    return answers


def guess_parts(cells: Sequence[Cell], load_questions: Callable[[], Container[str]]) -> list[str]:
    """Return the parts that a notebook seems to answer, according to its metadata and the variables that it sets.

    `load_questions` returns the names of all questions. It is called only for variables of parts that no metadata name.
    """
    parts = dict[str, None]()
    for cell in cells:
        if cell.part is not None and re.fullmatch(r"p\d+\.[a-z0-9-]+", cell.part):
            parts[cell.part] = None
        for slot, ending in re.findall(r"(?m)^[ \t]*(p\d+)_(\w+) *=(?!=)", cell.source):
            question = ending.replace("_", "-")
            if f"{slot}.{question}" not in parts and question in load_questions():
                parts[f"{slot}.{question}"] = None
    return list(parts)


# --- what cells set ---


class _Notebook:
    """A notebook's cells, with the source that is run for each code cell, and the names that this source sets.

    `variables` maps each part to the name of its variable. `sources` and `bound_names` map the index of each code cell
    to its source and to the names that it sets. `notes` tell the student how the sources were changed to find an
    answer.
    """

    def __init__(self, cells: Sequence[Cell], variables: Mapping[str, str]) -> None:
        self.cells, self.variables, self.notes = cells, variables, list[str]()
        self._trees, self._remaining_characters = dict[str, ast.Module | None](), MAX_PARSED_CHARACTERS
        self.sources = {index: cell.source for index, cell in enumerate(cells) if cell.is_code}
        slots = "|".join(sorted({re.escape(part.split(".")[0]) for part in variables})) or "$^"  # "$^" never matches
        self._likely_variable = re.compile(rf"\b(?:{slots})_?\w", re.IGNORECASE)
        self.bound_names = {index: self._find_names_in_cell(index) for index in self.sources}

    def _find_names_in_cell(self, index: int) -> set[str]:
        """Return the names that a cell sets; an empty set if the cell can't contain an answer."""
        cell = self.cells[index]
        if cell.part not in self.variables and not self._likely_variable.search(cell.source):
            return set()
        tree = self._parse_cell(cell.source)
        if tree is None:  # guess the names; the run will report the error in the cell
            return set(re.findall(r"(?m)^[ \t]*(\w+)\b[^\n=!<>]*=(?!=)", cell.source[:MAX_CELL_CHARACTERS]))
        return set(_find_bound_names(tree, cell.source))

    def find_setters(self, name: str) -> list[int]:
        """Return the indices of the cells that set a variable."""
        return [index for index, names in self.bound_names.items() if name in names]

    def find_marked_cells(self, part: str) -> list[int]:
        """Return the indices of the cells whose metadata name them as the answer to a part, including text cells."""
        return [index for index, cell in enumerate(self.cells) if cell.part == part]

    def locate_answer(self, part: str) -> None:
        """If no cell sets the variable of a part, find the answer elsewhere and assign it in the source that is run."""
        name, setters = self.variables[part], self.find_setters(self.variables[part])
        marked_cells = [index for index in self.find_marked_cells(part) if index in self.sources]
        assigning_cells = [index for index in marked_cells if isinstance(self._find_statement(index), ast.Assign)]
        if setters:
            if assigning_cells and not set(marked_cells) & set(setters):
                note = f"{name} is set in {_name_cells(setters)}, and qdot used this value"
                self.notes.append(f"{note}; its answer cell, {_name_cells(assigning_cells)}, does not set it")
            return
        position = f", the last of {_name_cells(marked_cells)}," if len(marked_cells) > 1 else ""
        for index in reversed(assigning_cells or marked_cells):
            if self._use_as_answer(index, part, f"{_name_cells([index])}{position} is the answer cell of {name}"):
                return
        assignment = re.compile(rf"(?m)^ *`*{name} *=(?!=)")
        text_cells = [(index, cell) for index, cell in enumerate(self.cells) if index not in self.sources]
        likely_cells = (index for index, cell in text_cells if cell.part == part or assignment.search(cell.source))
        candidates = itertools.islice(likely_cells, MAX_SEARCHED_CANDIDATES)
        if not any(self._use_text_cell(index, part) for index in candidates):
            self._use_misspelt_variable(name)

    def _use_misspelt_variable(self, name: str) -> None:
        """Use a misspelt variable, such as P1_Jacobian, for one that no cell sets, if exactly one name is similar."""
        answer_names, start = list(self.variables.values()), name[:2].casefold()
        other_names = sorted(set().union(*self.bound_names.values()) - set(answer_names))
        candidates = [
            candidate for candidate in other_names
            if abs(len(candidate) - len(name)) < 3 and candidate[:2].casefold() == start
        ]  # fmt: skip
        # The cutoff allows about one wrong letter in eight.
        find_similar = functools.partial(difflib.get_close_matches, possibilities=answer_names, n=1, cutoff=0.87)
        candidates = candidates[:MAX_SEARCHED_CANDIDATES]
        similar_names = [candidate for candidate in candidates if find_similar(candidate.casefold()) == [name]]
        if len(similar_names) != 1:
            return
        (similar_name,) = similar_names
        index = self.find_setters(similar_name)[-1]
        tree = self._parse_cell(self.sources[index])
        for statement in reversed(tree.body if tree else []):
            targets = statement.targets if isinstance(statement, ast.Assign) else []
            if any(isinstance(target, ast.Name) and target.id == similar_name for target in targets):
                self._replace_text(index, statement.lineno, statement.col_offset, statement.col_offset, f"{name} = ")
                self.notes.append(f"no cell sets {name}; qdot used {similar_name} in {_name_cells([index])} instead")
                return

    def _find_statement(self, index: int) -> "ast.Assign | ast.Expr | None":
        """Return the statement with the answer in an answer cell, whatever its variable is called; None if unknown."""
        tree = self._parse_cell(self.sources[index])
        if tree is None or not tree.body:
            return None
        assignments = [statement for statement in tree.body if isinstance(statement, ast.Assign)]
        targets = [assignment.targets[-1] for assignment in assignments]
        pairs = zip(targets, assignments, strict=True)
        statements = {target.id: assignment for target, assignment in pairs if isinstance(target, ast.Name)}
        last_statement = tree.body[-1]
        if isinstance(last_statement, ast.Expr) and isinstance(last_statement.value, ast.Name):  # it shows a variable
            return statements.get(last_statement.value.id, last_statement)
        if isinstance(last_statement, ast.Expr) and not statements and not _is_display_call(last_statement):
            return last_statement
        return max(statements.values(), key=lambda statement: (statement.lineno, statement.col_offset), default=None)

    def _use_as_answer(self, index: int, part: str, reason: str) -> bool:
        """Use the value of an answer cell as the answer to its part; return False if the cell has no value to use."""
        name, statement = self.variables[part], self._find_statement(index)
        if statement is None:
            return False
        target = statement.targets[-1] if isinstance(statement, ast.Assign) else None
        assigned_name = target.id if isinstance(target, ast.Name) else ""
        if target is not None and assigned_name in self.variables.values():
            if self.find_setters(assigned_name) == [index]:
                return False  # the value is the only answer to another part
            self._replace_text(index, target.lineno, target.col_offset, target.end_col_offset or 0, name)
        else:
            self._replace_text(index, statement.lineno, statement.col_offset, statement.col_offset, f"{name} = ")
        self.bound_names[index] = self.bound_names[index] | {name}
        statement_text = f"sets {assigned_name}, not {name}" if assigned_name else "assigns no variable"
        self.notes.append(f"{reason} and {statement_text}; qdot used its value")
        return True

    def _replace_text(self, index: int, line_number: int, begin: int, end: int, text: str) -> None:
        """Replace the bytes from `begin` to `end` of a cell's line with a text; Python's syntax trees count bytes."""
        lines = translate_to_python(self.sources[index]).split("\n")
        line = lines[line_number - 1].encode()
        lines[line_number - 1] = (line[:begin] + text.encode() + line[end:]).decode()
        self.sources[index] = "\n".join(lines)

    def _use_text_cell(self, index: int, part: str) -> bool:
        """Use and run the Python code in a text cell; return False if the code contains no answer."""
        name = self.variables[part]
        code = self._find_code(self.cells[index].source, name)
        if code is None:
            return False
        reason = f"{_name_cells([index])} is a text cell, not a code cell"
        tree = self._parse(code)
        self.sources[index], self.bound_names[index] = code, set(_find_bound_names(tree, code)) if tree else {name}
        if name in self.bound_names[index]:
            self.notes.append(f"{reason}; qdot ran its text as code for {name}")
        elif not self._use_as_answer(index, part, f"{reason},"):
            del self.sources[index], self.bound_names[index]
            return False
        return True

    def _parse_cell(self, source: str) -> ast.Module | None:
        """Return the syntax tree of a cell as it is run; None if the cell is too long or not Python."""
        return self._parse(translate_to_python(source)) if len(source) <= MAX_CELL_CHARACTERS else None

    def _parse(self, code: str) -> ast.Module | None:
        """Return the syntax tree of a text; None if it is not Python. Raises OverLimit if too much was parsed."""
        if code not in self._trees:
            self._remaining_characters -= len(code)
            if self._remaining_characters < 0:
                raise OverLimit("the cells have too much code to search; remove code that is not part of an answer")
            self._trees[code] = parse_python(code, MAX_CELL_CHARACTERS)
        return self._trees[code]

    def _find_code(self, text: str, name: str) -> str | None:
        """Return the Python code in a text cell: the whole text without fences, else the text from `name =` on."""
        lines = [line for line in text[:MAX_CELL_CHARACTERS].split("\n") if not re.match(r"\s*(```|~~~)", line)]
        text_without_fences = "\n".join(lines).strip().strip("`")
        tree = self._parse(text_without_fences)
        if tree is not None and any(map(_is_likely_code, tree.body)):
            return text_without_fences
        begin = next((n for n, line in enumerate(lines) if re.match(rf" *`*{name} *=(?!=)", line)), None)
        if begin is None:
            return None
        lines = lines[begin : begin + MAX_TEXT_LINES]
        while lines:
            code = "\n".join(lines).strip().strip("`")
            if self._parse(code) is not None:
                return code
            # Try again without the lines from the first error on.
            del lines[max(0, min(find_first_syntax_error(code), len(lines)) - 1) :]
        return None


def _find_bound_names(tree: ast.AST, source: str) -> Iterator[str]:
    """Yield the names that statements set, except inside functions."""
    expressions_may_bind = ":=" in source or "for" in source
    unvisited_nodes = [tree]  # no recursion: the tree of a sum of a thousand terms is a thousand levels deep
    while unvisited_nodes:
        for node in ast.iter_child_nodes(unvisited_nodes.pop()):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                yield node.id
            elif isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.AsyncFunctionDef)):
                yield node.name
            elif not isinstance(node, ast.Lambda) and (expressions_may_bind or not isinstance(node, VALUE_CLASSES)):
                unvisited_nodes.append(node)


VALUE_CLASSES = (ast.BinOp, ast.UnaryOp, ast.Call, ast.Constant, ast.Compare, ast.BoolOp, ast.Dict, ast.Set)
"""Classes of expressions, common in answers, in which only a walrus or a comprehension can set a name."""


def _is_display_call(statement: ast.Expr) -> bool:
    """Return whether a statement only displays something, or is an IPython magic."""
    function = statement.value.func if isinstance(statement.value, ast.Call) else None
    if isinstance(function, ast.Attribute):
        return function.attr in ("show", "run_line_magic", "run_cell_magic", "system", "getoutput")
    return isinstance(function, ast.Name) and function.id in ("print", "display", "pprint", "init_printing", "help")


def _is_likely_code(statement: ast.stmt) -> bool:
    """Return whether a statement is likely to be code. A word or two of prose may also be valid Python."""
    is_code = isinstance(statement, ast.Expr) and isinstance(statement.value, (ast.Call, ast.BinOp, ast.List, ast.Dict))
    return is_code or isinstance(statement, ast.Assign)


# --- reading answers ---


def _is_blank(text: str) -> bool:
    """Return whether an answer is empty or contains only placeholders."""
    return re.fullmatch(r"(?:blank|[\s\[\](){},\"'])*", text) is not None


def _is_missing(run: Run, name: str) -> bool:
    """Return whether a variable has no value or a blank value."""
    return name not in run.answers or _is_blank(run.answers[name])


def _use_earlier_value(answers: Answers, name: str) -> None:
    """If a variable holds a placeholder or an unreadable value at the end, use the last other value that it had."""
    run = answers.run
    earlier_values = [text for text in run.earlier_values.get(name, ()) if not _is_blank(text)]
    if earlier_values:
        reason = run.unreadable_reasons.pop(name, "")
        state = "left blank" if name in run.answers else f"unreadable ({reason})"
        run.answers[name] = earlier_values[-1]
        answers.notes.append(f"{name} is {state} at the end of the notebook; qdot used its earlier value")


def _use_second_run(answers: Answers, name: str, setters: Sequence[int], second_run: Run) -> None:
    """Use a variable's value after the second run of its cells, which lacked a name in the first run."""
    value = second_run.answers.get(name)
    if value is not None and not _is_blank(value):
        answers.run.answers[name] = value
        cause = f"{_name_cells(setters)} stopped ({answers.run.cell_errors[setters[-1]]})"
        answers.notes.append(f"{cause}; qdot ran it again after all other cells and got {name}")


def _use_words_of_cell(answers: Answers, part: str, name: str, notebook: _Notebook) -> None:
    """Use the words in the last cell that Python can't run: the text after `name =`, or else the whole answer cell."""
    marked_cells = notebook.find_marked_cells(part)
    for index in sorted({*notebook.find_setters(name), *marked_cells}, reverse=True):
        is_run = index in notebook.sources and index not in answers.run.cell_errors
        source = notebook.cells[index].source[:MAX_CELL_CHARACTERS]
        match = re.search(rf"(?ms)^[ \t]*{name}[ \t]*=(?!=)(.*?)(?=^[ \t]*p\d+_\w+[ \t]*=(?!=)|\Z)", source)
        whole_cell = source if index in marked_cells else ""
        text = match[1] if match else whole_cell
        words = _strip_quotes(text.strip()).strip().encode(errors="replace").decode()
        if not is_run and not _is_blank(words):
            answers.run.answers[name] = words
            answers.run.unreadable_reasons.pop(name, None)
            reason = "can't be run as Python code" if index in notebook.sources else "is a text cell"
            answers.notes.append(f"{_name_cells([index])} {reason}; qdot used its text as the answer {name}")
            return


_RELEASED_HEADING = re.compile(r"(?m)^#{2,3} (?:\d+(?:\.\d+)? |Check your answers)")
"""Matches the beginning of what a released notebook contains: of a problem, a question, or the self-checks."""


def _use_words_beside_cell(answers: Answers, part: str, name: str, notebook: _Notebook) -> None:
    """Use the text cells that a student added directly below an answer cell, or directly above it."""
    answer_cells = {*notebook.find_setters(name), *notebook.find_marked_cells(part)}
    for answer_cell, step in itertools.product(sorted(answer_cells), (1, -1)):
        texts, index, heading = dict[int, str](), answer_cell + step, None
        while 0 <= index < len(notebook.cells) and index not in notebook.sources and heading is None:
            cell = notebook.cells[index]
            heading = _RELEASED_HEADING.search(cell.source)
            if cell.part is not None or (heading and step < 0):  # another part's cell, or this part's question
                break
            text = cell.source[: heading.start() if heading else MAX_CELL_CHARACTERS].strip()
            if text:
                texts[index] = text.encode(errors="replace").decode()
            index += step
        if texts:
            answers.run.answers[name] = "\n\n".join(texts[index] for index in sorted(texts))
            words = f"{_name_cells(sorted(texts))} {'is a text cell' if len(texts) == 1 else 'are text cells'}"
            answers.notes.append(f"{words} beside the blank answer cell; qdot used the text as the answer {name}")
            return


def _strip_quotes(text: str) -> str:
    """Return a text without the quotes around it; quotes that belong to words inside the text remain.

    >>> _strip_quotes('"J = " + Matrix([[1, 0], [0, 1]])')
    '"J = " + Matrix([[1, 0], [0, 1]])'
    >>> _strip_quotes('"it grows')
    'it grows'
    """
    stripped_text = text.strip("\"'")
    is_quoted = text[:1] == text[-1:]
    return stripped_text if is_quoted or not re.search("[\"']", stripped_text) else text


def _note_several_values(answers: Answers, part: str, name: str, notebook: _Notebook) -> None:
    """Add a note on which value was used if several cells set different ones."""
    errors = answers.run.cell_errors
    setters = notebook.find_setters(name)
    if len(setters) < 2 or any(note.startswith(f"{name} is ") for note in answers.notes):
        return  # an earlier note says which value was used
    stopped_cells = [index for index in setters if index in errors]
    values = {text for text in answers.run.earlier_values.get(name, ()) if not _is_blank(text)}
    fact = f"{name} is set in {_name_cells(setters)}"
    if stopped_cells:
        answers.notes.append(f"{fact}, but {_name_cells(stopped_cells)} stopped ({errors[stopped_cells[-1]]})")
    elif len(values) > 1 and sum(notebook.cells[index].part in (part, None) for index in setters) > 1:
        answers.notes.append(f"{fact}; qdot used its value at the end of the notebook")


def _describe_replacement(name: str, index: int, value: str) -> str:
    """Return a note on a cell that assigned a number to the name of a symbol, which answers therefore lack."""
    symbol, number = make_printable(name), make_printable(value)
    effect = f"{symbol} = {number} in {_name_cells([index])} replaces the symbol by a number, also in later answers"
    return f"{effect}. Use .subs to insert a value, and {symbol} = symbols('{symbol}') to restore the symbol"


def _describe_overtime(notebook: _Notebook, run: Run) -> list[str]:
    """Return a note on each cell that was stopped because it took too long, with the answers that it had set."""
    notes = []
    for index, error in run.cell_errors.items():
        if error.startswith(OVERTIME_ERRORS):
            names = notebook.bound_names[index] & set(run.answers)
            used_names = [name for name in notebook.variables.values() if name in names]
            effect = f"; qdot used {' and '.join(used_names)}, which the cell had already set" if used_names else ""
            notes.append(f"qdot stopped {_name_cells([index])}: {error}{effect}")
    return notes


OVERTIME_ERRORS = "it took longer than", "it waited longer than"
"""The beginnings of the errors of cells that took too long."""


def _describe_stop(notebook: _Notebook, index: int, run: Run) -> str:
    """Return a note on the error at which a cell stopped, or on a failed import after which it continued."""
    reasons = [_describe_missing_import(notebook, index, run)]
    if index in run.cell_errors:
        line = f": {_read_line(notebook, index, run.stop_lines[index])}" if index in run.stop_lines else ""
        reasons.append(f"{_name_cells([index])} {_describe_error(index, run)}{line}")
    return "; ".join(filter(None, reasons))


def _describe_missing_import(notebook: _Notebook, index: int, run: Run) -> str:
    """Return a note on the failed import after which a cell continued, and why it failed; empty if none failed."""
    if index not in run.failed_imports:
        return ""
    number, error = run.failed_imports[index]
    line = _read_line(notebook, index, number)
    return f"{_name_cells([index])} continued without line {number} ({error}): {line}"


def _describe_error(index: int, run: Run) -> str:
    """Return the error of a cell as the end of a clause, as in "stopped at line 2 (NameError: …)"."""
    location = f" at line {run.stop_lines[index]}" if index in run.stop_lines else ""
    return f"stopped{location} ({run.cell_errors[index]})"


def _read_line(notebook: _Notebook, index: int, line_number: int) -> str:
    """Return the text of a line in a cell."""
    return make_printable("".join(notebook.sources[index].split("\n")[line_number - 1 : line_number]).strip())


def _find_first_stop(notebook: _Notebook, stop_notes: Mapping[int, str]) -> list[str]:
    """Return a list with the note on the first cell that stopped if this cell is above all answers; else an empty list.

    The answers may depend on such a cell. `stop_notes` maps the index of each cell that stopped to its note.
    """
    first_answer = min((index for index, names in notebook.bound_names.items() if names), default=len(notebook.cells))
    return [stop_notes[index] for index in sorted(stop_notes) if index < first_answer][:1]


def _explain_missing(part: str, name: str, notebook: _Notebook, run: Run, stop_notes: Mapping[int, str]) -> str:
    """Return a clause that says why a part has no answer; `name` is the part's variable."""
    if name in run.unreadable_reasons:
        return f"qdot can't parse the value of {name}: {run.unreadable_reasons[name]}"
    cells = [*notebook.find_setters(name), *notebook.find_marked_cells(part)]
    stopped_cell = next((index for index in cells if index in run.cell_errors), None)
    if stopped_cell is not None:
        error = run.cell_errors[stopped_cell]
        if error.startswith(OVERTIME_ERRORS):
            advice = ". Look for an endless loop or a slow calculation" if error.startswith(OVERTIME_ERRORS[0]) else ""
            return f"qdot stopped the cell with this answer: {error}{advice}"
        line_number = run.stop_lines.get(stopped_cell)
        line = "" if line_number is None else _read_line(notebook, stopped_cell, line_number)
        cause = _describe_missing_import(notebook, stopped_cell, run)
        if not cause:
            errors_above = {
                index: f"{_name_cells([index])} {_describe_error(index, run)}" if index in run.cell_errors else note
                for index, note in stop_notes.items()
                if index < stopped_cell
            }
            cause = _explain_unquoted_letter(name, line, error) or _find_cause(error, notebook, errors_above)
        sentences = [f"the cell with this answer {_describe_error(stopped_cell, run)}"]
        if cause:
            sentences.append(cause[:1].upper() + cause[1:])
        if line:
            sentences.append(f"The line is “{line}”")
        return ". ".join(sentences)
    if run.end != "done":
        return _describe_end(run)
    if not cells:
        return describe_unset(name)
    if not any(index in notebook.sources for index in cells):
        return f"the answer cell ({_name_cells(cells)}) is a text cell, and qdot found no Python code in it"
    return f"the cell for this answer does not set {name}"


def describe_unset(name: str) -> str:
    """Return why a part has no answer if the notebook never sets the part's variable `name`."""
    return f"no cell of the notebook sets {name}"


def _describe_end(run: Run) -> str:
    """Return a note on how a run ended early, and in which cell; empty if the run did not end early."""
    return run.describe_end("" if run.last_begun_cell is None else _name_cells([run.last_begun_cell]))


def _explain_unquoted_letter(name: str, line: str, error: str) -> str:
    """Return advice for a line such as `p1_choice = C`, in which the letter of an option lacks its quotes.

    >>> _explain_unquoted_letter("p1_choice", "p1_choice = C", "NameError: name 'C' is not defined")
    'type the letter of an option in quotes, as in "C"'
    """
    match = re.fullmatch(rf"{re.escape(name)}\s*=\s*([A-H])", line.partition("#")[0].strip())
    is_undefined = match is not None and error.startswith(f"NameError: name '{match[1]}'")
    return f'type the letter of an option in quotes, as in "{match[1]}"' if match and is_undefined else ""


def _find_cause(error: str, notebook: _Notebook, errors_above: Mapping[int, str]) -> str:
    """Return why a name in a cell is probably undefined, or what to do about it; "" if the error is another one.

    The cause is the first cell above that stopped before it set the name, or a misspelt name. `errors_above` are
    clauses on the cells above that stopped, such as "cell 3 stopped at line 2 (…)".
    """
    name_error = re.match(r"NameError: name '(\w+)'", error)
    if name_error is None:
        return ""
    name, names = name_error[1], sorted(set().union(notebook.variables.values(), *notebook.bound_names.values()))
    for index in sorted(errors_above):
        if _may_set(notebook.sources[index][:MAX_CELL_CHARACTERS], name):
            if name in notebook.variables.values():
                return f"the cell that sets {name} stopped, too. Correct that cell first"
            return f"the name {name} is missing because {errors_above[index]}"
    if name in _MODULE_IMPORTS:
        return f"write '{_MODULE_IMPORTS[name]}' in a cell above"
    if len(name) > 1 and hasattr(sympy, name) and name not in _GREEK_FUNCTIONS:
        return f"write 'from sympy import {name}' in a cell above"
    for known_name in (*names, *(sympy_name for sympy_name in dir(sympy) if len(sympy_name) > 1)):
        if known_name != name and known_name.casefold() == name.casefold():
            return f"Python distinguishes capital and small letters; write {known_name}"
    if similar_names := difflib.get_close_matches(name, (set(names) | _COMMON_FUNCTIONS) - {name}, 1, 0.8):
        return f"check the spelling; a similar name is {similar_names[0]}"
    return (
        f"no cell above sets {name}. Define it, or use a symbol from the first code cell. To find such errors before "
        "you submit, restart the kernel and run all cells"
    )


_MODULE_IMPORTS = {
    "sympy": "import sympy", "sp": "import sympy as sp", "numpy": "import numpy", "math": "import math",
}  # fmt: skip
"""Maps the name of a module to the statement that imports the module under this name."""
_GREEK_FUNCTIONS = {"beta", "gamma", "zeta"}
"""Functions of SymPy whose names students use for angles instead."""
_COMMON_FUNCTIONS = {"sin", "cos", "tan", "sqrt", "atan2", "simplify", "Matrix", "symbols", "solve", "diff", "zeros"}
"""Names that students often misspell."""


def _may_set(source: str, name: str) -> bool:
    """Return whether a cell may set a name, by an assignment, a definition, or an import."""
    word = re.compile(rf"\b{name}\b")
    beginnings = (line.partition("=")[0] for line in source.split("\n") if "=" in line)
    is_imported = re.search(rf"\bimport\b[^\n#]*(\*|\b{name}\b)|\bdef +{name}\b", source)
    return is_imported is not None or any(map(word.search, beginnings))


def _name_cells(indices: Sequence[int]) -> str:
    """Return the cells' numbers as a phrase for messages, such as "cells 3 and 7"."""
    numbers = [str(index + 1) for index in indices[:6]] + (["…"] if len(indices) > 6 else [])
    return f"cell {numbers[0]}" if len(numbers) == 1 else f"cells {', '.join(numbers[:-1])} and {numbers[-1]}"
