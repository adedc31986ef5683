"""Remove from prompts and statements what is useless on paper: remarks on how to type answers, and code."""

import re

from qdot.exercises.problem.problem import Problem
from qdot.exercises.writing.latex import list_prismatic_joints, tex, write_symbol

_CODE_EXAMPLES = r"`[^`]+`(?:, `[^`]+`)*"
_REMARKS_ON_TYPING = (
    (r"the letter, typed in quotes, for example `[^`]+`\.", "tick the correct one."),
    (r"the letters of all correct options, typed in quotes, for example `[^`]+`\.", "tick all correct options."),
    (r'`"true"` or `"false"`, typed in quotes', "tick one"),
    (rf" \(typed {_CODE_EXAMPLES}\)", ""),
    (rf"(?:[;,]| and) (?:the joint rates|the components) are typed {_CODE_EXAMPLES}", ""),
    (rf"\. The components of the load are typed {_CODE_EXAMPLES}; ", "; "),
    (r",? typed in quotes(?:, for example `[^`]+`)?", ""),
    (r" letters in quotes in the order of the joints, for example `[^`]+`", " letters in the order of the joints"),
    (r"These examples, for another arm, show the accepted forms: .*?(?=Conditions in a list)", ""),
    (
        r"Conditions in a list are alternatives",
        "Join conditions that must hold together with “and”; write each alternative on a line of its own",
    ),
    (r"a text in your own words\. A person marks it\.", "a text in your own words."),
    (r"in your answers, use radians", "in answers that are formulas, use radians"),
)
"""(pattern, replacement) for each remark on how to type an answer."""
_OPTION_PATTERN = re.compile(r"^- \*\*[A-H]\.\*\* .*\n?|^\$\$\n\\text\{[A-H]\.\} \\quad [^$]*\n\$\$\n?", re.MULTILINE)
_CODE_PATTERN = re.compile(r"`([^`]*)`")


def remove_typing_remarks(text: str, problem: Problem) -> str:
    """Return Markdown without remarks on typing, in which typed symbols become formulas and other code plain text."""
    for pattern, replacement in _REMARKS_ON_TYPING:
        text = re.sub(pattern, replacement, text, flags=re.DOTALL)
    symbols = problem.chain.q + problem.chain.rates + problem.chain.parameters
    formulas = {symbol.name: tex(symbol, problem.chain) for symbol in symbols}
    joints = list_prismatic_joints(problem.chain)
    formulas |= {row: write_symbol(row, joints) for row in problem.symbols if row not in formulas}

    def write_code(match: re.Match[str]) -> str:
        code = match[1].strip('"')
        row = re.fullmatch(r"\[(.*)\]", code)
        return f"${formulas[code]}$" if code in formulas else f"$({row[1]})$" if row else code

    return _CODE_PATTERN.sub(write_code, text)


def remove_options(text: str) -> str:
    """Return a prompt without the options to choose from."""
    return re.sub(r"\n{3,}", "\n\n", _OPTION_PATTERN.sub("", text))
