"""Make a question from an instructor's definition: compute its answer, and decide to which arms it applies.

Formulas are derived by the stages of `derivation.graph`, so a mistake in a stage leads to the wrong answer that a
student gives. Arms that differ only in the values of their lengths and oblique angles form a class. Their symbolic arm
has symbols for these values (`make_symbolic_arm`).
"""

import ast
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import lru_cache
from itertools import combinations, product

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.trigonometry import write_in_textbook_form
from qdot.exercises.common.errors import KeyReason
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import TooLong, derive, make_symbolic_arm
from qdot.exercises.derivation.graph import (
    StageResults,
    compute_numeric_stages,
    compute_symbolic_stages,
    to_sympy_matrix,
)
from qdot.exercises.derivation.lengths import replace_lengths_by_symbols
from qdot.exercises.formula.parser import parse_reference
from qdot.exercises.formula.program import Evaluation, compile_program, evaluate
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.formula.trees import Node
from qdot.exercises.problem.problem import Details, SymbolInfo, list_table_numbers
from qdot.exercises.questions import inversion, language, quantities
from qdot.exercises.questions.base import AnswerAndDetails, Question, find_term_count_objection
from qdot.exercises.questions.custom.definition import GIVEN_GROUPS, SAMPLED_KINDS, TEXT_ANSWER, Definition, GivenValue
from qdot.exercises.questions.custom.units import MIXED_UNITS, find_dimensions, find_unit_objection, has_unit_of_kind
from qdot.exercises.questions.language import AXES, FormulaError, UnknownName
from qdot.exercises.questions.reference import derive_reference
from qdot.exercises.reference_answers import (
    Choice,
    ConditionSet,
    Direction,
    Expression,
    Matrix,
    Number,
    Selection,
    Words,
)
from qdot.exercises.singularities.classification import sample_condition
from qdot.exercises.singularities.singular_set import Component, find_zero_set

MAX_TRIES = 20
"""Maximum number of sets of random values that are sampled to find a finite answer in which nothing is 0 by chance."""
MAX_OPERATIONS = 20_000
"""Maximum number of operations of a formula that is simplified. A readable formula has a few hundred before that."""
MAX_EDITED_OPERATIONS = 400
"""Maximum number of operations, before simplification, of a formula in which mistakes in a number are looked for."""

SOURCES = {
    "p": ("position",), "v": ("position",), "J": ("jacobian",), "det(J)": ("determinant", "jacobian"),
    "inv(J)": ("inverse-jacobian", "jacobian"),
}  # fmt: skip
"""Maps names and calls in a formula to built-in questions. The answer to any of these questions gives the value."""


def _find_sources(formula: ast.expr) -> Iterator[str]:
    """Yield the names and calls of a formula that are in SOURCES, but not the J in det(J)."""
    stack: list[ast.AST] = [formula]
    while stack:
        node = stack.pop()
        if isinstance(node, ast.expr) and (text := ast.unparse(node)) in SOURCES:
            yield text
        else:
            stack.extend(ast.iter_child_nodes(node))


_ABOUT_OTHER_OPTIONS = re.compile(r"\s*(none|all|any) of (these|them|the (others|above))", re.IGNORECASE)
"""Matches an option about the other options, such as "none of these". Such an option stays last."""

ZEROS = "zeros"
"""The function whose result is a set of configurations. An answer can't contain it as a part of a formula."""


@dataclass(frozen=True, kw_only=True)
class CustomDetails(Details):
    """Details of a custom question: its definition, and the values that the question gives to this student.

    `configuration` has the lengths and joint values, if any are given, and `values` has the other given values.
    `order` holds the indices of the options in the order shown.
    """

    definition: Definition
    configuration: inversion.Configuration | None = None
    values: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    order: tuple[int, ...] = ()

    @property
    def question(self) -> Question:
        """The question of the definition."""
        return make_question(self.definition)

    @property
    def evaluator(self) -> "DefinitionEvaluator":
        """The functions that compute the answer."""
        return DefinitionEvaluator(self.definition)

    @property
    def all_values(self) -> dict[sp.Symbol, sp.Expr]:
        """All given values, for substitution."""
        return {**(self.configuration.values if self.configuration else {}), **self.values}

    def list_given_values(self, chain: Chain) -> Mapping[str, float]:
        """Return the given lengths, joint values and other values."""
        numbers = self.configuration.numbers if self.configuration else {}
        return numbers | {symbol.name: float(value) for symbol, value in self.values.items()}


@dataclass(frozen=True)
class CustomQuestion(Question):
    """A question that an instructor has defined."""

    _: KW_ONLY
    definition: Definition

    @property
    def typed_formula(self) -> str:
        """The answer as the instructor wrote it."""
        return self.definition.answer


@lru_cache(maxsize=1024)
def make_question(definition: Definition) -> CustomQuestion:
    """Return the question of a definition. Raises FormulaError if a formula can't be parsed."""
    evaluator = DefinitionEvaluator(definition)
    if definition.options:
        sample = evaluator.sample_choice
    elif evaluator.is_set:
        sample = evaluator.find_zeros
    elif definition.answer == TEXT_ANSWER:
        sample = evaluator.ask_for_words
    else:
        sample = evaluator.sample_number if definition.given else evaluator.derive_formulas
    prerequisites = tuple(dict.fromkeys(name for names in evaluator.prerequisite_sets for name in names))
    return CustomQuestion(
        definition.name, definition.texts[0].title, "", definition=definition, points=definition.points,
        rounding=definition.rounding,
        template="custom", sample=sample, prerequisites=prerequisites, find_arm_objection=evaluator.find_objection,
        compute=evaluator.compute_answer if evaluator.formulas and not evaluator.is_set else None,
        compute_zero=evaluator.compute_zeros if evaluator.is_set else None,
        alternative_prerequisites=evaluator.prerequisite_sets,
        name_entries=lambda chain, details: definition.rows,
    )  # fmt: skip


def check_question_names(definition: Definition, question_names: Collection[str]) -> None:
    """Raise FormulaError if a formula contains the name of a question, unless the name has another meaning."""
    symbol_names = {name for name, _ in definition.units}
    for formula in DefinitionEvaluator(definition).all_formulas:
        for name in language.find_names(formula) & set(question_names) - symbol_names:
            if not quantities.is_result_or_symbol(name):
                advice = "a formula can't contain the answer to another question; write the formula of its answer"
                raise FormulaError(f"{name!r} is a question, and {advice}")


class DefinitionEvaluator:
    """Computes, samples and checks the answer of a definition.

    Every answer is the value of its formulas in the stages of a derivation (`_compute`). The methods return it in four
    forms:

    - `compute_answer`: in the arithmetic of the stages, to apply mistakes or a student's earlier answers
    - `derive`: as formulas in textbook form, for people to read
    - `compute_symbolic_answer`: as formulas that are not simplified, to compute numbers fast
    - `derive_zeros`: as the set of configurations at which the formulas are zero

    The last three use the symbolic arm if possible, so that one derivation is enough for all arms of a class.
    """

    def __init__(self, definition: Definition) -> None:
        self.definition = definition
        self.is_set, self.formulas = False, list[ast.expr]()
        if definition.answer not in ("", TEXT_ANSWER):
            match language.parse(definition.answer):
                case ast.Call(func=ast.Name(id=function), args=arguments) if function == ZEROS:
                    self.is_set, self.formulas = True, arguments
                case tree:
                    self.formulas = [tree]
        self.option_formulas = [
            language.parse(option.content) if option.is_formula else None for option in definition.options
        ]

    @property
    def all_formulas(self) -> list[ast.expr]:
        """The formulas of the answer and of the options."""
        return [*self.formulas, *filter(None, self.option_formulas)]

    @property
    def prerequisite_sets(self) -> tuple[tuple[str, ...], ...]:
        """The sets of built-in questions from whose answers a student can derive this answer."""
        sources = [SOURCES[name] for formula in self.formulas for name in _find_sources(formula)]
        sets = (tuple(dict.fromkeys(names)) for names in product(*sources))
        return () if self.has_numeric_derivative or not sources else tuple(dict.fromkeys(sets))

    @property
    def has_numeric_derivative(self) -> bool:
        """Whether the answer is a number with a derivative, which can't be computed from a student's earlier answer."""
        return bool(self.definition.given) and any(
            language.find_calls(formula) & {"ddt", "diff", "at"} for formula in self.formulas
        )

    # --- symbols ---

    def _uses_accelerations(self) -> bool:
        """Return whether a formula contains joint accelerations: by name, or because a velocity is differentiated."""
        names = set().union(*map(language.find_names, self.all_formulas))
        calls = set().union(*map(language.find_calls, self.all_formulas))
        is_named = any(name.startswith("qdd") for name in names)
        differentiates_rates = "ddt" in calls and any(name in ("v", "w") or name.startswith("qd") for name in names)
        return (
            is_named or differentiates_rates or any("ddt(ddt(" in ast.unparse(formula) for formula in self.all_formulas)
        )

    def list_new_symbols(self, chain: Chain) -> dict[str, SymbolInfo] | None:
        """Return the symbols of the answer that the arm lacks: accelerations, loads, and symbols with a unit."""
        symbols = {name: SymbolInfo("force", unit) for name, unit in self.definition.units}
        if self._uses_accelerations():
            accelerations = zip(quantities.name_accelerations(chain), chain.joints, strict=True)
            units = {name: "rad/s^2" if joint.is_revolute else "m/s^2" for name, joint in accelerations}
            symbols |= {name: SymbolInfo("rate", unit) for name, unit in units.items()}
        names = {value.name for value in self.definition.given}.union(*map(language.find_names, self.all_formulas))
        if names & {"f", "force"}:
            symbols = inversion.make_load_symbols(chain) | symbols
        return symbols or None

    def _compute(self, formula: ast.expr, stages: StageResults) -> np.ndarray:
        return quantities.compile_formula(formula, tuple(self.list_new_symbols(stages.chain) or ()))(stages)

    # --- formulas ---

    def compute_answer(self, stages: StageResults, _: Details) -> np.ndarray:
        """Return the answer, (rows, columns, …), in the arithmetic of the stages."""
        return self.compute_formula(self.formulas[0], stages)

    def compute_formula(self, formula: ast.expr, stages: StageResults) -> np.ndarray:
        """Return those rows of a formula that the answer has, (rows, columns, …), in the arithmetic of the stages."""
        value = self._compute(formula, stages)
        if self.definition.rows and language.count_axes(value) != 1:
            shape = language.describe_shape(value)
            raise FormulaError(f"rows are names of the entries of a vector, but the answer is {shape}", "rows")
        value = quantities.select_components(value, self.definition.rows)
        return value[None] if value.ndim == 1 else value

    def compute_zeros(self, stages: StageResults, _: Details) -> np.ndarray:
        """Return the formulas that are zero in the set, (formulas, 1, …), in the arithmetic of the stages."""
        return np.stack([self._compute(formula, stages) for formula in self.formulas])[:, None]

    def derive_formulas(self, chain: Chain, rng: Stream) -> AnswerAndDetails:
        """Return the answer as formulas in textbook form."""
        details = CustomDetails(definition=self.definition, symbols=self.list_new_symbols(chain))
        matrix = _derive_answer(self.definition, chain)
        if self.definition.is_up_to_factor:
            return Direction(matrix), details
        return (Expression(matrix[0]) if matrix.shape == (1, 1) else Matrix(matrix)), details

    def derive(self, chain: Chain, formula: ast.expr, mentions_symbols: bool) -> sp.Matrix:
        """Return the value of a formula in textbook form.

        If possible, the formula is derived for the symbolic arm, and the arm's numbers are substituted at the end. A
        formula that mentions joint variables or lengths is derived for the arm itself, because those of the symbolic
        arm differ.
        """
        derived_chain = chain if mentions_symbols else make_symbolic_arm(chain).chain
        value = self._compute(formula, derive_reference(derived_chain, {}))
        matrix = to_sympy_matrix(value).applyfunc(_simplify)
        return matrix if mentions_symbols else derive(chain).substitute_matrix(matrix)

    def derive_text_formula(self, text: str, chain: Chain) -> sp.Matrix | sp.Expr:
        """Return the value of a formula in a text of the question. Raises FormulaError."""
        formula = language.parse(text)
        matrix = self.derive(chain, formula, self.mentions_arm_symbols(chain, [formula]))
        return matrix[0] if matrix.shape == (1, 1) else matrix

    def mentions_arm_symbols(self, chain: Chain, formulas: Sequence[ast.expr] = ()) -> bool:
        """Return whether formulas (by default, of answer and options) mention joint variables or lengths of the arm."""
        searched_formulas = formulas or self.all_formulas
        arm_names = {*(symbol.name for symbol in (*chain.q, *chain.parameters)), *list_table_numbers(chain), "q"}
        nodes = (node for formula in searched_formulas for node in ast.walk(formula))
        keywords = {node.arg for node in nodes if isinstance(node, ast.keyword)}  # theta1 in at(p, theta1 = 0)
        return not arm_names.isdisjoint(keywords.union(*map(language.find_names, searched_formulas)))

    # --- numbers ---

    def sample_number(self, chain: Chain, rng: Stream) -> AnswerAndDetails | None:
        """Return the numeric answer at random given values; None if no sample gives a finite number.

        If possible, no entry is 0 by chance, and neither an angle nor a sum of rates of consecutive joints is 0.
        Otherwise some mistakes would not change the answer.
        """
        matrix, first_sample = self.compute_symbolic_answer(chain), None
        fixed_names = {value.name for value in self.definition.given if not value.is_random}
        for _ in range(MAX_TRIES):
            details = self._sample_values(chain, rng)
            numbers = [_evaluate(entry, details.all_values) for entry in matrix]
            if any(number is None for number in numbers):
                continue
            sample = self._make_numeric_answer(sp.Matrix(matrix.rows, matrix.cols, numbers)), details
            has_only_true_zeros = all(number or entry == 0 for entry, number in zip(matrix, numbers, strict=True))
            if has_only_true_zeros and not _vanishes_by_chance(chain, details.all_values, fixed_names):
                return sample
            first_sample = first_sample or sample
        return first_sample

    def compute_symbolic_answer(self, chain: Chain) -> sp.Matrix:
        """Return the answer as formulas that are not simplified; they are computed once for all arms of a class."""
        if self.mentions_arm_symbols(chain):
            return _compute_formulas(self.definition, chain)
        formulas = _compute_formulas(self.definition, make_symbolic_arm(chain).chain)
        return derive(chain).substitute_matrix(formulas)

    def _make_numeric_answer(self, values: sp.Matrix) -> Number:
        """Return numbers with their units. Raises FormulaError if the definition has another number of units."""
        units, largest_value = self.definition.entry_units, max(abs(float(value)) for value in values)
        if len(units) == 1:
            units *= len(values)
        tolerances = self.definition.rounding.errors_of_entries if self.definition.rounding else ()
        entries = f"{len(values)} {'entry' if len(values) == 1 else 'entries'}"
        for key, noun, count in (("unit", "units", len(units)), ("tolerance", "tolerances", len(tolerances))):
            if count not in (len(values), 0):
                advice = f"the answer has {entries}; write one for each entry, or one for all"
                raise FormulaError(f"it has {count} {noun}, but {advice}", key)
        return Number(values, units, inversion.THREE_DIGIT_TOLERANCE, inversion.ERROR_NEAR_ZERO * largest_value)

    def _sample_values(self, chain: Chain, rng: Stream) -> CustomDetails:
        """Return details with random values of everything that the question gives."""
        given_by_name, values = {value.name: value for value in self.definition.given}, dict[sp.Symbol, sp.Expr]()
        joint_names = {q.name for q in chain.q}
        configuration = None
        if "pose" in given_by_name or joint_names & set(given_by_name):
            random_configuration = inversion.sample_configuration_and_velocity(chain, rng)
            given_joints = {q: _sample_value(given_by_name[q.name], rng) for q in chain.q if q.name in given_by_name}
            joints = random_configuration.joints | given_joints
            configuration = inversion.Configuration(random_configuration.lengths, joints)
        elif chain.parameters:
            configuration = inversion.Configuration(inversion.sample_lengths(chain, rng), {})
        groups: dict[str, Sequence[sp.Symbol]] = {
            "rates": chain.rates,
            "velocity": [sp.Symbol(row) for row in chain.task],
            "force": list(map(sp.Symbol, inversion.make_load_symbols(chain))),
        }
        numbers = list_table_numbers(chain)
        for name, value in given_by_name.items():
            if name == "pose" or name in joint_names:  # joint values are part of the configuration
                continue
            sampled_value = replace(value, kind=GIVEN_GROUPS.get(name) or value.kind)
            for symbol in groups.get(name, [sp.Symbol(name)]):  # a length that is a number in the table keeps it
                values[symbol] = numbers.get(name) or _sample_value(sampled_value, rng)
        if configuration is not None:
            lengths = {symbol: values.pop(symbol, length) for symbol, length in configuration.lengths.items()}
            configuration = replace(configuration, lengths=lengths)
        symbols = self.list_new_symbols(chain)
        return CustomDetails(definition=self.definition, configuration=configuration, values=values, symbols=symbols)

    def ask_for_words(self, chain: Chain, rng: Stream) -> AnswerAndDetails:
        """Return an answer in words, which a person marks."""
        return Words(), CustomDetails(definition=self.definition)

    # --- sets and options ---

    def find_zeros(self, chain: Chain, rng: Stream) -> AnswerAndDetails | None:
        """Return the configurations at which all formulas are zero; None if these are none or all configurations."""
        components = _find_zeros(self.definition, chain)
        if not components:
            return None
        is_singular_set = [ast.unparse(formula) for formula in self.formulas] == ["det(J)"]
        return ConditionSet(components, is_singular_set), CustomDetails(definition=self.definition)

    def derive_zeros(self, chain: Chain) -> tuple[Component, ...] | None:
        """Return the components of the set of zeros; None if the formulas are zero everywhere."""
        mentions_symbols = self.mentions_arm_symbols(chain)
        stages = derive_reference(chain if mentions_symbols else make_symbolic_arm(chain).chain, {})
        values = [self._compute(formula, stages) for formula in self.formulas]
        if any(value.ndim > 1 for value in values):
            raise FormulaError("zeros needs numbers, not vectors: write zeros(p.x), for example")
        numerators = [_find_numerator(to_sympy_matrix(value)[0]) for value in values]
        other_symbols = set().union(*(numerator.free_symbols for numerator in numerators))
        other_symbols -= {*stages.chain.q, *stages.chain.parameters}
        if other_symbols:
            names = ", ".join(sorted(map(str, other_symbols)))
            raise FormulaError(f"zeros takes formulas in joint variables and lengths, but these also contain {names}")
        try:
            return find_zero_set(numerators, chain, is_symbolic=not mentions_symbols)
        except (ValueError, sp.PolynomialError):
            raise FormulaError(
                "qdot can't find its zeros; zeros needs sums, products and quotients of lengths, sines and cosines"
            ) from None

    def sample_choice(self, chain: Chain, rng: Stream) -> AnswerAndDetails | None:
        """Return a choice or selection with the options in random order."""
        random_order = rng.permutation(tuple(range(len(self.option_formulas))))
        order = sorted(
            random_order, key=lambda index: bool(_ABOUT_OTHER_OPTIONS.match(self.definition.options[index].content))
        )
        options = [self.definition.options[index] for index in order]
        texts = tuple(self._write_option(chain, index) for index in order)
        correct = tuple(position for position, option in enumerate(options) if option.is_correct)
        answer = Choice(texts, correct[0]) if len(correct) == 1 else Selection(texts, correct)
        return answer, CustomDetails(definition=self.definition, order=tuple(order))

    def _write_option(self, chain: Chain, index: int) -> str:
        formula = self.option_formulas[index]
        if formula is None:
            return self.definition.options[index].content
        matrix = self.derive(chain, formula, self.mentions_arm_symbols(chain))
        return format_expression(matrix[0]) if matrix.shape == (1, 1) else str(list(map(format_expression, matrix)))

    # --- objections ---

    def find_objection(self, chain: Chain) -> str | None:
        """Return why the question can't be asked about an arm, or None.

        A number at random values is sampled for the symbolic arm, once for all arms of a class.
        """
        given_values = self.definition.given
        if objection := self._find_objection_to_symbols(chain) or self._find_objection_to_given_values(chain):
            return objection
        is_random = bool(given_values) and all(value.kind or value.name in GIVEN_GROUPS for value in given_values)
        if is_random and self.formulas and not self.mentions_arm_symbols(chain):
            return _find_objection(self.definition, make_symbolic_arm(chain).chain)
        return _find_objection(self.definition, chain)

    def _find_objection_to_given_values(self, chain: Chain) -> str | None:
        """Return why the arm can't have the given values, or None.

        A length that is a number in the arm's table keeps this number, which must be in the given range.
        """
        numbers, units = list_table_numbers(chain), self.list_units_of_symbols(chain)
        for value in self.definition.given:
            if value.name in GIVEN_GROUPS:
                continue
            key = f"given.{value.name}"
            if value.name not in units:
                return KeyReason(key, str(UnknownName("symbol", value.name, tuple(units))))
            if value.kind and not has_unit_of_kind(units[value.name], value.kind):
                kind = next((kind for kind in SAMPLED_KINDS if has_unit_of_kind(units[value.name], kind)), "")
                suggestion = f'{value.name} = "{kind}"' if kind else f"a range, as in {value.name} = [1, 5]"
                unit = units[value.name] if units[value.name] not in ("", "1") else "a number without a unit"
                return KeyReason(key, f"{value.name} is {f'in {unit}' if kind else unit}; write {suggestion}")
            if value.name in numbers and not value.kind and not value.low <= numbers[value.name] <= value.high:
                number_text = f"{float(numbers[value.name]):g} m"
                advice = f'write {value.name} = "length" to accept the numbers of the arms'
                return KeyReason(key, f"{value.name} is {number_text} in the table of this arm; {advice}")
        return None

    def _find_objection_to_symbols(self, chain: Chain) -> str | None:
        """Return why a symbol can't have its name, or None. The name may already belong to the arm."""
        symbols = (*chain.q, *chain.parameters, *chain.rates, *chain.task, *quantities.name_accelerations(chain))
        arm_names = {*map(str, symbols), *list_table_numbers(chain), *quantities.list_result_names(chain)}
        arm_names |= {f"{letters}{row}" for letters in ("a", "d", "theta", "alpha") for row in range(1, chain.n + 1)}
        name = next((name for name, _ in self.definition.units if name in arm_names), None)
        if name is None:
            return None
        return KeyReason(f"units.{name}", f"{name} is a name of the arm, so its unit is known; leave it out here")

    def list_units_of_symbols(self, chain: Chain) -> dict[str, str]:
        """Return the unit of each symbol that an answer may contain, and of each numeric length in the arm's table."""
        units = dict.fromkeys([*map(str, chain.parameters), *list_table_numbers(chain)], "m")
        for q, rate, joint in zip(chain.q, chain.rates, chain.joints, strict=True):
            units |= {q.name: "m", rate.name: "m/s"} if joint.is_prismatic else {q.name: "rad", rate.name: "rad/s"}
        units |= {row: "m/s" if row[0] == "v" else "rad/s" for row in chain.task}
        return units | {name: info.unit for name, info in (self.list_new_symbols(chain) or {}).items()}

    def _explain_missing_set(self, chain: Chain, is_everything: bool) -> str:
        """Return why there is no set of zeros: the formulas are zero everywhere, or nowhere."""
        if not is_everything:
            return "its formula is never zero, so there is no set to ask for"
        moving_axes = [axis for axis in AXES if f"v{axis}" in chain.task]
        components = {f"p.{axis}" for axis in AXES if axis not in moving_axes}
        nodes = (node for formula in self.formulas for node in ast.walk(formula))
        mentions_constant = any(ast.unparse(node) in components for node in nodes)
        is_planar = mentions_constant and bool(moving_axes)
        cause = f" (this arm changes only {' and '.join(f'p.{axis}' for axis in moving_axes)})" if is_planar else ""
        return f"its formula is zero at every configuration{cause}, so there is no set to ask for"

    def find_objection_to_arm(self, chain: Chain) -> str | None:
        """Return why the question can't be asked about this arm, or None; `find_objection` caches the result."""
        try:
            texts = [self._write_option(chain, index) for index in range(len(self.option_formulas))]
            options = zip(self.definition.options, texts, strict=True)
            for (option, text), (other_option, other_text) in combinations(options, 2):
                if text == other_text:
                    return f"its options {option.content!r} and {other_option.content!r} are equal for this arm"
            if self.is_set:
                components = _find_zeros(self.definition, chain)
                if not components:
                    return self._explain_missing_set(chain, is_everything=components is None)
                uncertain_components = [component for component in components if not component.has_constant_values]
                pieces = [piece for component in uncertain_components for piece in component.list_pieces()]
                empty_piece = next((piece for piece in pieces if not sample_condition(chain, piece, "zeros")), None)
                if empty_piece is None:
                    return None
                lengths = [length.name for length in chain.parameters if length.name in re.findall(r"\w+", empty_piece)]
                condition = f"; whether there is one depends on {' and '.join(lengths)}" if lengths else ""
                return f"qdot finds no configuration with {empty_piece}{condition}"
            if self.formulas and self.definition.given:
                return None if self.sample_number(chain, Stream("check")) else "its answer is not a finite number"
            if self.formulas:
                matrix = self.derive_formulas(chain, Stream("check"))[0].as_matrix()
                if self.definition.is_up_to_factor and (matrix.rows == 1 or matrix.cols > 1):
                    return "only a vector can count up to a factor; leave up_to_factor out"
                class_chain = chain if self.mentions_arm_symbols(chain) else make_symbolic_arm(chain).chain
                if _is_constant(self.definition, class_chain, _name_lengths(class_chain) - _name_lengths(chain)):
                    return f"its answer is {'always zero' if matrix.is_zero_matrix else 'the same everywhere'}"
                return find_term_count_objection(sum(len(sp.Add.make_args(entry)) for entry in matrix))
        except FormulaError as error:
            return KeyReason(error.key, str(error)) if error.key else str(error)
        except (TooLong, ValueError) as error:
            return str(error)
        return None

    def list_needed_values(self, chain: Chain, details: CustomDetails, symbols: Sequence[sp.Symbol]) -> list[str]:
        """Return the names of the given `symbols` on whose random values a numeric answer depends."""
        fixed_names = {value.name for value in self.definition.given if not value.is_random}
        random_symbols = [symbol for symbol in symbols if symbol.name not in fixed_names]
        if not random_symbols:
            return []
        matrix = self.compute_symbolic_answer(chain)
        values = details.all_values
        answer = [_evaluate(entry, values) for entry in matrix]

        def changes_answer(symbol: sp.Symbol) -> bool:
            changed_values = {**values, symbol: values[symbol] + sp.Rational(1, 7)}
            return [_evaluate(entry, changed_values) for entry in matrix] != answer

        return [symbol.name for symbol in random_symbols if changes_answer(symbol)]

    def find_objection_to_numbers(self, chain: Chain) -> str | None:
        """Return why a numeric answer is unsuitable according to three samples, or None.

        It is unsuitable if random values don't change it, or if it differs from 0 by less than the tolerance.
        """
        if not self.formulas or self.is_set or not self.definition.given:
            return None
        samples = (self.sample_number(chain, Stream(f"check {k}")) for k in range(3))
        answers = [sample[0] for sample in samples if sample is not None and isinstance(sample[0], Number)]
        texts = {", ".join(answer.as_json()) for answer in answers}
        if len(texts) == 1 and any(value.is_random for value in self.definition.given):
            zeros = [value.name for value in self.definition.given if not (value.is_random or value.low)]
            key = f"given.{zeros[0]}" if zeros and not any(answers[0].reference) else "answer"
            return f"{key}: the answer is {texts.pop()} for all given values"
        rounding = self.definition.rounding
        for answer in answers if rounding is not None and rounding.absolute else ():
            numbers = list(map(float, answer.reference))
            allowed_errors = answer.list_allowed_errors(rounding)
            if all(abs(number) <= error for number, error in zip(numbers, allowed_errors, strict=True)):
                value = ", ".join(f"{number:.3g}" for number in numbers)
                return f"tolerance: it must be smaller than the answer; 0 would count as right if the answer is {value}"
        return None

    def list_warnings(self, chain: Chain) -> list[str]:
        """Return warnings about what is probably an error in the answer or the options, as clauses."""
        functions = (
            self._find_unit_warning, self._find_zero_component, self._find_zero_numbers,
            self._find_formula_shown_as_text, self._find_unused_symbol, self._find_angle_in_degrees,
        )  # fmt: skip
        return [warning for function in functions if (warning := function(chain)) is not None]

    def _find_unused_symbol(self, chain: Chain) -> str | None:
        """Return a warning if no formula contains a symbol that the definition adds; else None."""
        used_names = {value.name for value in self.definition.given}.union(*map(language.find_names, self.all_formulas))
        unused_name = next((name for name, _ in self.definition.units if name not in used_names), None)
        return None if unused_name is None else KeyReason(f"units.{unused_name}", f"no formula contains {unused_name}")

    def _find_angle_in_degrees(self, chain: Chain) -> str | None:
        """Return a warning if an angle has so large a value that it is probably in degrees; else None."""
        angles = {q.name for q, joint in zip(chain.q, chain.joints, strict=True) if joint.is_revolute}
        for value in self.definition.given:
            if value.name in angles and max(abs(value.low), abs(value.high)) > 2 * np.pi:
                return KeyReason(
                    f"given.{value.name}", f"{value.name} is in radians; {value.high:g} is more than a turn"
                )
        return None

    def _find_zero_component(self, chain: Chain) -> str | None:
        """Return a warning if a vector has a component that is always zero and not part of the task; else None.

        The built-in questions ask for the components of the task only.
        """
        rows = self.definition.rows
        if not self.formulas or self.is_set or len(rows) >= len(AXES):
            return None
        is_number = bool(self.definition.given)
        matrix = self.compute_symbolic_answer(chain) if is_number else _derive_answer(self.definition, chain)
        if rows and matrix.shape == (len(rows), 1):
            return _find_zero_row(rows, matrix, chain)
        if matrix.shape != (len(AXES), 1):
            return None
        zero_axes = [axis for axis, k in AXES.items() if matrix[k] == 0 and f"v{axis}" not in chain.task]
        if not zero_axes:
            return None
        names = ", ".join(f'"v_{axis}"' for axis in AXES if axis not in zero_axes)
        components = " and ".join(zero_axes)
        return (
            f"its {components} component is always 0; to ask for the others only, write, for example, rows = [{names}]"
        )

    def _find_zero_numbers(self, chain: Chain) -> str | None:
        """Return a warning if some numbers in the answer are 0 for all students; else None."""
        if not self.formulas or self.is_set or not self.definition.given or self._find_zero_component(chain):
            return None
        samples = (self.sample_number(chain, Stream(f"check {k}")) for k in range(3))
        answers = [list(map(float, sample[0].as_matrix())) for sample in samples if sample is not None]
        zeros = [k + 1 for k, numbers in enumerate(zip(*answers, strict=True)) if not any(numbers)]
        if not zeros:
            return None
        entries = f"entries {' and '.join(map(str, zeros))} are" if len(zeros) > 1 else f"entry {zeros[0]} is"
        return f"its {entries} 0 for all given values"

    def _find_formula_shown_as_text(self, chain: Chain) -> str | None:
        """Return a warning if an option that is shown as a text is a formula in the arm's quantities; else None."""
        stages = compute_symbolic_stages(chain)
        known_names = {
            *quantities.make_quantities(stages, frozenset(), {}).names,
            *map(str, (*chain.q, *chain.parameters)),
        }
        for option in self.definition.options:
            try:
                names = set() if option.is_formula else language.find_names(language.parse(option.content))
            except FormulaError:
                continue
            if names and names <= known_names:
                return f'its option {option.content!r} is shown as a text; shown = "formula" shows its value'
        return None

    def find_wrong_unit(self, chain: Chain) -> str | None:
        """Return why the numeric answer can't have the unit in the definition, or None.

        A number in a formula may have a unit. If there is such a number, the unit of the answer is not certain.
        """
        objection = self._find_unit_objection(chain)
        is_certain = self.definition.unit != "" and objection != MIXED_UNITS and not self._contains_number
        return objection if is_certain else None

    def _find_unit_warning(self, chain: Chain) -> str | None:
        """Return why the answer probably has another unit or no unit, or None."""
        objection = self._find_unit_objection(chain)
        if objection is None:
            return None
        advice = '; if a number in the formula has a unit, name the quantity, as in units = {m = "kg"}'
        text = f"{objection}{advice if self._contains_number else ''}"
        return KeyReason("unit", text) if self.definition.unit else text

    def _find_unit_objection(self, chain: Chain) -> str | None:
        """Return why a number can't have the unit in the definition, or why a formula has no unit at all; else None."""
        if not self.formulas or self.is_set:
            return None
        arm, _ = replace_lengths_by_symbols(chain)
        details = CustomDetails(definition=self.definition)

        def compute_entries(values: Mapping[str, np.ndarray]) -> np.ndarray:
            answer = self.compute_answer(compute_numeric_stages(arm, values), details)
            return answer.reshape(-1, answer.shape[-1])

        dimensions = find_dimensions(compute_entries, self.list_units_of_symbols(arm))
        if self.definition.given:
            return find_unit_objection(dimensions, self.definition.entry_units)
        return MIXED_UNITS if dimensions.is_mixed else None

    @property
    def _contains_number(self) -> bool:
        """Whether a formula contains a number that may have a unit.

        Zeros, divisors, exponents and indices have no unit.
        """
        nodes = [node for formula in self.formulas for node in ast.walk(formula)]
        operations = (node for node in nodes if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Div, ast.Pow)))
        plain_parts: list[ast.AST] = [operation.right for operation in operations]
        plain_parts += [part for node in nodes if isinstance(node, ast.Subscript) for part in ast.walk(node.slice)]
        return any(isinstance(node, ast.Constant) and node.value and node not in plain_parts for node in nodes)


@lru_cache(maxsize=1024)
def _derive_answer(definition: Definition, chain: Chain) -> sp.ImmutableMatrix:
    """Return the answer as formulas in textbook form. It is cached, because a check of the question needs it first."""
    evaluator = DefinitionEvaluator(definition)
    if evaluator.mentions_arm_symbols(chain):
        return _derive_without_substitution(definition, chain)
    return sp.ImmutableMatrix(
        derive(chain).substitute_matrix(_derive_without_substitution(definition, make_symbolic_arm(chain).chain))
    )


@lru_cache(maxsize=1024)
def _derive_without_substitution(definition: Definition, chain: Chain) -> sp.ImmutableMatrix:
    """Return the answer for this very arm: a symbolic arm, or an arm whose symbols the formula mentions; cached."""
    details = CustomDetails(definition=definition)
    value = DefinitionEvaluator(definition).compute_answer(derive_reference(chain, {}), details)
    return sp.ImmutableMatrix(to_sympy_matrix(value).applyfunc(_simplify))


@lru_cache(maxsize=1024)
def _compute_formulas(definition: Definition, chain: Chain) -> sp.ImmutableMatrix:
    """Return the answer as formulas that are not simplified; cached."""
    value = DefinitionEvaluator(definition).compute_answer(
        compute_symbolic_stages(chain), CustomDetails(definition=definition)
    )
    return sp.ImmutableMatrix(to_sympy_matrix(value))


@lru_cache(maxsize=1024)
def derive_formulas_of_numbers(definition: Definition, chain: Chain) -> list[list[Node]] | None:
    """Return the formulas behind a numeric answer, in textbook form; None if one of them is long."""
    matrix = DefinitionEvaluator(definition).compute_symbolic_answer(chain)
    if any(sp.count_ops(entry) > MAX_EDITED_OPERATIONS for entry in matrix):
        return None
    names = frozenset(symbol.name for symbol in matrix.free_symbols)
    texts = [[format_expression(_simplify(entry)) for entry in row] for row in matrix.tolist()]
    return [[parse_reference(text, names) for text in row] for row in texts]


@lru_cache(maxsize=1024)
def _find_zeros(definition: Definition, chain: Chain) -> tuple[Component, ...] | None:
    """Return the configurations at which the formulas of a definition are all zero; cached."""
    return DefinitionEvaluator(definition).derive_zeros(chain)


@lru_cache(maxsize=4096)
def _find_objection(definition: Definition, chain: Chain) -> str | None:
    return DefinitionEvaluator(definition).find_objection_to_arm(chain)


def _simplify(entry: sp.Expr) -> sp.Expr:
    """Return an entry in textbook form, or unchanged if the two forms have different values at test points."""
    if entry.has(sp.zoo, sp.nan, sp.oo):
        raise FormulaError("its answer has a denominator that is always zero")
    if sp.count_ops(entry) > MAX_OPERATIONS:
        raise TooLong(f"a formula has more than {MAX_OPERATIONS} operations, too many to be readable")
    simplified_entry = write_in_textbook_form(entry)
    if simplified_entry == entry:
        return entry
    (value, simplified_value), (magnitude, _) = _evaluate_at_points([entry, simplified_entry])
    is_equal = np.abs(simplified_value - value) <= 1e-9 * magnitude  # False for nan
    return simplified_entry if is_equal.all() else entry


def _find_numerator(formula: sp.Expr) -> sp.Expr:
    """Return a formula with the same zeros that has no denominator, and no root or exponential function as a factor."""
    if all(power.exp.is_Integer and power.exp > 0 for power in formula.atoms(sp.Pow)) and not formula.has(sp.exp):
        return formula
    numerator, _ = sp.fraction(sp.together(write_in_textbook_form(formula)))
    return sp.Mul(*(factor.as_base_exp()[0] for factor in sp.Mul.make_args(numerator)))


@lru_cache(maxsize=1024)
def _is_constant(definition: Definition, chain: Chain, fixed_names: frozenset[str]) -> bool:
    """Return whether the answer has the same value at three arbitrary points; cached.

    The symbols in `fixed_names` have the same value at all points, because they are numbers in a student's arm.
    """
    values = _evaluate_at_points(list(_derive_without_substitution(definition, chain)), fixed_names).values.T
    return all(np.allclose(value, values[0], rtol=1e-9, atol=1e-9) for value in values[1:])


def _name_lengths(chain: Chain) -> frozenset[str]:
    """Return the names of the lengths of an arm that are not numbers."""
    return frozenset(length.name for length in chain.parameters)


def _evaluate_at_points(entries: Sequence[sp.Expr], fixed_names: AbstractSet[str] = frozenset()) -> Evaluation:
    """Return the values and magnitudes of entries at three arbitrary points, at which the fixed symbols are equal."""
    names = sorted(str(symbol) for symbol in set().union(*(entry.free_symbols for entry in entries)))
    steps = {name: 0 if name in fixed_names else 7 for name in names}
    points = {name: (step * np.arange(3) + 3 * i + 4) / (11 + i) for i, (name, step) in enumerate(steps.items())}
    known_names = frozenset(names)  # otherwise, m would be a unit
    return evaluate(
        compile_program([parse_reference(format_expression(entry), known_names) for entry in entries]), points, 3
    )


def _evaluate(entry: sp.Expr, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr | None:
    """Return the value of an entry with ten digits; None if it is not a finite real number."""
    numbers = {symbol: value.xreplace(dict(values)) for symbol, value in values.items()}  # a joint may contain lengths
    number = sp.N(entry.xreplace(numbers), 30)
    if number.free_symbols:
        missing = ", ".join(sorted(map(str, number.free_symbols)))
        raise FormulaError(
            f"the answer contains {missing}, which the question does not give; add it to `given`", "given"
        )
    is_finite = number.is_real and number.is_finite
    return sp.Float(f"{float(number):.10g}") if is_finite else None


def _vanishes_by_chance(chain: Chain, values: Mapping[sp.Symbol, sp.Expr], fixed_names: AbstractSet[str]) -> bool:
    """Return whether a random angle of a revolute joint, or a sum of rates of consecutive revolute joints, is 0.

    The symbols in `fixed_names` are not random.
    """
    angles = [chain.q[i] for i in chain.revolute_joints]
    if any(values.get(angle) == 0 for angle in angles if angle.name not in fixed_names):
        return True
    for i, j in combinations(range(chain.n), 2):
        rates = chain.rates[i : j + 1]
        is_sum = all(joint.is_revolute for joint in chain.joints[i : j + 1]) and values.keys() >= set(rates)
        is_random = bool({rate.name for rate in rates} - fixed_names)
        if is_sum and is_random and sum(values[rate] for rate in rates) == 0:
            return True
    return False


def _sample_value(given_value: GivenValue, rng: Stream) -> sp.Expr:
    """Return a random value: angles in steps of 5 degrees, other values with at most two significant digits."""
    if given_value.kind == "angle":
        return sp.pi * sp.Rational(rng.integer(-35, 35), 36)
    if given_value.kind == "length":
        return sp.Rational(rng.integer(2, 16), 20)
    if given_value.kind in ("rate", "velocity"):
        return sp.Rational(rng.choice([k for k in range(-8, 9) if k]), 20 if given_value.kind == "velocity" else 10)
    if given_value.kind == "force":
        return sp.S(rng.choice([k for k in range(-20, 21) if k]))
    low, high = sp.Rational(str(given_value.low)), sp.Rational(str(given_value.high))
    return low + (high - low) * sp.Rational(rng.integer(0, 20), 20)


def _find_zero_row(rows: Sequence[str], matrix: sp.Matrix, chain: Chain) -> KeyReason | None:
    """Return a warning if one of the components that `rows` chooses is always zero and not part of the task."""
    moving_axes = [axis for axis in AXES if f"v{axis}" in chain.task]
    for k, name in enumerate(rows):
        axis = name.rstrip("}")[-1:]
        if matrix[k] == 0 and axis in AXES and moving_axes and axis not in moving_axes:
            return KeyReason("rows", f"{name} is always 0; the components of its task are {' and '.join(moving_axes)}")
    return None
