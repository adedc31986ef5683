"""Translate a cell's IPython syntax (`%`, `!`, `?`, prompts, indentation) to Python, without IPython.

IPython is not used, because a mark must not depend on whether IPython is installed. Python's tokenizer finds
where statements begin, so that a `%` in a formula or a text is not changed. A cell that is Python already is returned
unchanged. Nothing is executed, and line numbers stay the same. The grader parses cells by these rules, too.
"""

import re
import tokenize
from collections.abc import Iterator, Sequence

NON_PYTHON_MAGICS = (
    "writefile", "file", "bash", "sh", "script", "system", "sx", "cmd", "html", "HTML", "svg", "SVG", "latex",
    "markdown", "javascript", "js", "perl", "ruby", "python2", "pypy", "cython", "R", "sql", "!",
)  # fmt: skip
"""The magics (commands of IPython) whose cells are not Python; cells of other magics, such as `%%time`, are Python."""

MAX_HELP_LENGTH = 500
"""Maximum length in characters of a line that may ask for help, as `sin?` does."""

_IPYTHON_SIGNS = re.compile(r"(?m)^[ \t]*(?:[%!?]|>>>|In \[)|=[ \t]*[%!]|\?[ \t]*$|\A(?:[ \t]*\n)*[ \t]+\S")
_CELL_MAGIC = re.compile(r"%%(\w+|!)[ \t]*(.*)")
_COMMENT = re.compile(r"[ \t]*(?:#.*)?")
_PREFIXED_LINE = re.compile(r"([ \t]*)(!!?|\?\??|%%?)[ \t]*(.*)")
_ASSIGNED_MAGIC = re.compile(r"([ \t]*[^\s=!%#'\"(][^=#'\"]*=[ \t]*)([!%])[ \t]*(.*)")
_HELP_LINE = re.compile(r"([ \t]*)[^'\"#]*?(%{0,2}(?!\d)[\w*]+(?:\.[\w*]+|\[[\w*]+\])*)(\?\??)[ \t]*")
_PROMPTS = (re.compile(r"(?:>>>|\.\.\.)(?: |$)"), re.compile(r"(?:In \[\d+\]:|[ \t]*\.{3,}:)(?: |$)"))


def translate_to_python(source: str) -> str:
    r"""Return a cell's source as Python, with each statement on its original line.

    >>> print(translate_to_python("files = !ls\n%time x = 5\nsin?"))
    files = get_ipython().getoutput('ls')
    x = 5
    get_ipython().run_line_magic('pinfo', 'sin')
    """
    if _IPYTHON_SIGNS.search(source) is None:
        return source
    lines = source.split("\n")
    first_code_line = next((n for n, line in enumerate(lines) if not _COMMENT.fullmatch(line)), len(lines))
    if first_code_line == len(lines):
        return source
    if prompt_pattern := next((pattern for pattern in _PROMPTS if pattern.match(lines[first_code_line])), None):
        lines = [prompt_pattern.sub("", line, count=1) for line in lines]
    code = lines[first_code_line]
    indent = code[: len(code) - len(code.lstrip(" \t"))]
    lines = [line.removeprefix(indent) for line in lines]
    while first_code_line < len(lines) and (magic := _CELL_MAGIC.fullmatch(lines[first_code_line])):
        if magic[1] in NON_PYTHON_MAGICS:
            body = "\n".join(lines[first_code_line + 1 :]).removesuffix("\n") + "\n"
            lines[first_code_line:] = [f"get_ipython().run_cell_magic({magic[1]!r}, {magic[2]!r}, {body!r})"]
            break
        lines[first_code_line] = "pass"
        first_code_line += 1
    return "\n".join(_translate_statements(lines))


def _translate_statements(lines: Sequence[str]) -> Iterator[str]:
    """Yield the lines, with each statement in IPython's syntax translated to Python."""
    begin = 0
    while begin < len(lines):
        if _COMMENT.fullmatch(lines[begin]):
            yield lines[begin]
            begin += 1
            continue
        end = begin + 1
        if _PREFIXED_LINE.fullmatch(lines[begin]) or _ASSIGNED_MAGIC.fullmatch(lines[begin]):
            while lines[end - 1].endswith("\\") and end < len(lines):
                end += 1
        translated_line = _translate_line(" ".join(line.rstrip("\\") for line in lines[begin:end]))
        if translated_line is not None:
            yield translated_line
            yield from [""] * (end - begin - 1)
        else:
            end = _find_statement_end(lines, begin)
            yield from lines[begin:end]
        begin = end


def _translate_line(line: str) -> str | None:
    """Return a line in IPython's syntax as Python; None for any other line."""
    if len(line) < MAX_HELP_LENGTH and (match := _HELP_LINE.fullmatch(line)):
        indent, name, question_marks = match.groups()
        return f"{indent}{_write_line_magic(_choose_help_magic(name, question_marks), name)}"
    if match := _PREFIXED_LINE.fullmatch(line):
        indent, escape, command = match.groups()
        if not command and escape.startswith("?"):
            return f"{indent}pass"
        if escape.startswith("?"):
            return f"{indent}{_write_line_magic(_choose_help_magic(command, escape), command)}"
        if escape.startswith("!"):
            return f"{indent}get_ipython().{'system' if escape == '!' else 'getoutput'}({command!r})"
        name, _, argument = command.partition(" ")
        if name == "time":  # run the rest of the line
            return indent + (argument.strip() or "pass")
        return indent + _write_line_magic(name, argument.strip())
    if match := _ASSIGNED_MAGIC.fullmatch(line):
        target, escape, command = match.groups()
        name, _, argument = command.partition(" ")
        if escape == "!":
            return f"{target}get_ipython().getoutput({command!r})"
        return target + _write_line_magic(name, argument.strip())
    return None


def _choose_help_magic(name: str, question_marks: str) -> str:
    if "*" in name:
        return "psearch"
    return "pinfo2" if question_marks == "??" else "pinfo"


def _write_line_magic(name: str, argument: str) -> str:
    return f"get_ipython().run_line_magic({name!r}, {argument!r})"


def _find_statement_end(lines: Sequence[str], begin: int) -> int:
    """Return the index after the statement that begins in line `begin`; `len(lines)` if the statement has no end."""
    remaining_lines = (f"{line}\n" for line in lines[begin:])
    try:
        for token in tokenize.generate_tokens(lambda: next(remaining_lines, "")):
            if token.type == tokenize.NEWLINE:
                return begin + token.start[0]
    except (tokenize.TokenError, SyntaxError):
        pass  # the cell is not Python; the error is reported when the cell is run
    return len(lines)
