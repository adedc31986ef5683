"""Common Cartridges in Moodle: its converter restores them into a course, with right answers, comments and figures.

`software` is the folder of an installed copy of Moodle with a running database. Each run adds courses and leaves them
there. moodle_cartridge.php does the work inside Moodle.
"""

import html
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from qdot.exercises.exports.common_cartridge import export_common_cartridge
from qdot.exercises.exports.items import ChoiceForm, MatchingForm, NumberForm, QuizItem, group_items, make_items
from qdot.exercises.exports.platform_markup import find_pictures, name_picture_file
from qdot.exercises.exports.typed_numbers import list_accepted_texts
from tests.platforms.assignments import EVERYTHING, PLAIN, make_request, write_files
from tests.platforms.moodle import call_moodle
from tests.platforms.records import Counts, Record, today

SCRIPT = Path(__file__).with_name("moodle_cartridge.php")
VARIANTS = {PLAIN: 2, EVERYTHING: 1}
BANK_COUNT = 2
"""Number of question banks to import of each assignment."""


def run(software: Path, work: Path) -> Record:
    """Import the quizzes of two assignments, and some of their question banks."""
    counts, software_name = Counts(), ""
    for kind, variants in VARIANTS.items():
        request = make_request(work / kind, kind, variants)
        all_items = [item.single_number_item or item for item in make_items(request)]
        items = [item for item in all_items if not isinstance(item.form, MatchingForm)]
        paths = write_files(list(export_common_cartridge(request))[: 1 + BANK_COUNT], work / kind)
        responses = [call_moodle(software, SCRIPT, cartridge=str(path)) for path in paths]
        software_name = responses[0]["software"]
        quizzes, *banks = responses
        groups = list(group_items(items, lambda _: None).values())
        quiz_counts = [quiz["count"] for quiz in quizzes["quizzes"]]
        version_count = max(Counter(item.category for item in items).values())
        counts.add("imported", quiz_counts == [len(groups)] * version_count, f"{kind}: {quizzes['quizzes']}")
        _check_questions(items, quizzes["questions"], counts)
        for group, bank in zip(groups, banks, strict=False):
            counts.add("imported", not bank["quizzes"] and len(bank["questions"]) == len(group), group[0].title)
            _check_questions(group, bank["questions"], counts)
    return Record("common-cartridge", f"{software_name}, restored into a course", today(), counts.freeze())


def _check_questions(items: Sequence[QuizItem], questions: Sequence[dict[str, Any]], counts: Counts) -> None:
    question_by_name = {question["name"]: question for question in questions}
    for item in items:
        question = question_by_name.get(item.title)
        counts.add("questions kept", question is not None, f"{item.title} is not in {sorted(question_by_name)}")
        if question is None:
            continue
        names = {name_picture_file(picture) for picture in find_pictures(item.body)}
        linked_names = set(re.findall(r'src="[^"]*/images/([^"]+)"', question["text"]))
        counts.add("figures linked", names <= linked_names, f"{item.title}: {question['text'][:600]}")
        right_texts = [answer["text"] for answer in question["answers"] if answer["fraction"] > 0]
        if isinstance(item.form, NumberForm):
            (field,) = item.form.fields
            counts.add("answers kept", right_texts == [*list_accepted_texts(field.value, field.tolerance)], item.title)
        elif isinstance(item.form, ChoiceForm):
            is_right = [answer["fraction"] > 0 for answer in question["answers"]]
            expected = [option.is_correct for option in item.form.options]
            counts.add("answers kept", is_right == expected, f"{item.title}: {question['answers']}")
            comments = [html.unescape(answer["feedback"]).strip() for answer in question["answers"]]
            counts.add("comments kept", comments == [option.feedback for option in item.form.options], item.title)
        else:
            counts.add("left to a person", question["type"] == "essay", f"{item.title}: {question['type']}")
