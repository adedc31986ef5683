"""Submitted files of every kind: versions, formats, archives, hostile and enormous ones. Others are graded as usual."""

import gzip
import io
import json
import os
import re
import stat
import tarfile
import time
import zipfile
from collections.abc import Callable, Collection
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.grader.grading.check import check_notebook
from qdot.grader.grading.result import Result
from qdot.grader.reports.feedback import make_feedback_page
from qdot.grader.reports.grades_table import find_work_status, make_grades_csv
from qdot.grader.sandbox.sandbox import Sandbox
from qdot.grader.submissions import answer_locator, archives
from qdot.grader.submissions import cells as reading
from qdot.grader.submissions.answer_locator import find_answers
from qdot.grader.submissions.cells import MAX_BYTES_IN_THIS_PROCESS, OverLimit, Unreadable, read_cells
from tests.support import DATA
from tests.support.submitting import (
    ALL_CORRECT,
    code_cell,
    grade,
    list_outcomes,
    make_class,
    make_correct_notebook,
    submit,
    text_cell,
    write_notebook,
)
from tests.support.suites import sample_for_suite, select_for_suite

pytestmark = pytest.mark.xdist_group("submitted-files")
HW = "hw.ipynb"
Submit = Callable[[Assignment, str], Any]
"""A function that submits something for a student."""
Case = tuple[Submit, list[str], str]
"""The submitting function, the outcomes of the three parts, and words that a message must contain."""


def submit_file(name: str, content: Callable[[str], str | bytes]) -> Submit:
    def submit_for(assignment: Assignment, student: str) -> None:
        submit(assignment, f"{student}/{name}", content(make_correct_notebook(assignment, student)))

    return submit_for


def with_keys(**keys: Any) -> Callable[[str], str]:
    return lambda text: json.dumps({k: v for k, v in {**json.loads(text), **keys}.items() if v is not None})


def version_3(text: str) -> str:
    cells = json.loads(text)["cells"]
    for cell in cells:
        if cell["cell_type"] == "code":
            cell["input"] = cell.pop("source").splitlines(keepends=True)
            cell["language"] = "python"
    worksheet = {"cells": cells, "metadata": {}}
    return json.dumps({"metadata": {"name": "hw"}, "nbformat": 3, "nbformat_minor": 0, "worksheets": [worksheet]})


def with_cells(change: Callable[[dict[str, Any], int], Any]) -> Callable[[str], str]:
    def edit(text: str) -> str:
        content = json.loads(text)
        for number, cell in enumerate(content["cells"]):
            change(cell, number)
        return json.dumps(content)

    return edit


def colab(keeps_metadata: bool) -> Callable[[str], str]:
    """Return the notebook as Colab saves it: version 4.0, with Colab's own metadata, with or without ours.

    Before an answer are lines that Colab's menus insert: the title of a form, and an installation.
    """

    def save(text: str) -> str:
        content = json.loads(text)
        for number, cell in enumerate(content["cells"]):
            if number == 2:
                cell["source"] = f'#@title Answer {{ display-mode: "form" }}\n!pip install -q sympy\n{cell["source"]}'
            cell["source"] = cell["source"].splitlines(keepends=True)
            cell["metadata"] = {**(cell["metadata"] if keeps_metadata else {}), "id": f"nWq-7cPBc{number:03d}"}
            if cell["cell_type"] == "code":
                ran_by = {"status": "ok", "user": {"displayName": "Ada L.", "userId": "04104170300566764648"}}
                cell["metadata"] |= {"colab": {"height": 35}, "cellView": "form", "executionInfo": ran_by}
                data = {"text/plain": ["0"], "application/vnd.google.colaboratory.intrinsic+json": {"type": "string"}}
                output = {"output_type": "execute_result", "data": data, "metadata": {}, "execution_count": number}
                cell |= {"execution_count": number, "outputs": [output]}
        metadata = {"colab": {"toc_visible": True}, "kernelspec": {"name": "python3"}, "accelerator": "GPU"}
        if keeps_metadata:
            metadata |= {"qdot": content["metadata"].get("qdot")}
        return json.dumps({"nbformat": 4, "nbformat_minor": 0, "metadata": metadata, "cells": content["cells"]})

    return save


def large_outputs(text: str) -> str:
    picture = {"output_type": "display_data", "metadata": {}, "data": {"image/png": "iVBORw0KGgo" * 4_500_000}}
    stream = {"output_type": "stream", "name": "stdout", "text": ["0.123456789\n"] * 3_500_000}
    content = json.loads(text)
    content["cells"][1]["outputs"], content["cells"][2]["outputs"] = [picture], [stream]
    notebook = json.dumps(content)
    assert len(notebook) > 100_000_000
    return notebook


def script(text: str) -> str:
    return "\n\n".join(cell["source"] for cell in json.loads(text)["cells"] if cell["cell_type"] == "code")


def markdown(text: str) -> str:
    """Write the notebook as Markdown; tests/data/jupytext has other converters' output."""
    cells = json.loads(text)["cells"]
    return "\n".join(
        f"```python\n{cell['source']}\n```\n"
        if cell["cell_type"] == "code"
        else f"{cell['source']}\n```bash\nls\n```\n"
        for cell in cells
    )


def zipped(*names: str, prefix: str = "") -> Callable[[str], bytes]:
    """Return a zip with the right notebook under each name, and the files that macOS adds."""

    def pack(text: str) -> bytes:
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w") as archive:
            for name in names:
                archive.writestr(name, text)
            archive.writestr(f"__MACOSX/._{names[0]}", b"\0\5\x16\7")
            archive.writestr(f".ipynb_checkpoints/{names[0]}", "{}")
        return buffer.getvalue()

    return pack


def make_zip(*members: tuple[str, str | bytes], **options: Any) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, **options) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return buffer.getvalue()


def targz(text: str) -> bytes:
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w:gz") as archive:
        link = tarfile.TarInfo("a.ipynb")
        link.type, link.linkname = tarfile.SYMTYPE, "/etc/passwd"
        archive.addfile(link)
        info = tarfile.TarInfo("work/hw.ipynb")
        info.size = len(text.encode())
        archive.addfile(info, io.BytesIO(text.encode()))
    return buffer.getvalue()


def gz_bomb(_: str) -> bytes:
    buffer = io.BytesIO()
    with gzip.GzipFile(fileobj=buffer, mode="wb", compresslevel=9) as file:
        for _megabyte in range(250):
            file.write(bytes(1 << 20))
    return buffer.getvalue()


def zip_bomb(_: str) -> bytes:
    return make_zip(("hw.ipynb", bytes(300_000_000)))


def patch_headers(archive: bytes, directory: int, local: int, field: bytes) -> bytes:
    changed = bytearray(archive)
    for signature, offset in ((b"PK\1\2", directory), (b"PK\3\4", local)):
        start = changed.index(signature) + offset
        changed[start : start + len(field)] = field
    return bytes(changed)


def lying_zip(_: str) -> bytes:
    return patch_headers(make_zip((HW, "{" + " " * 5_000_000 + "}")), 24, 22, (10).to_bytes(4, "little"))


def encrypted(text: str) -> bytes:
    return patch_headers(make_zip((HW, text)), 8, 6, b"\1")


def zip_with_link(text: str) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        info = zipfile.ZipInfo("hw.ipynb")
        info.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(info, "../../secret.txt")
        archive.writestr("../../../other.ipynb", text)
    return buffer.getvalue()


def many_members(_: str) -> bytes:
    return make_zip(*((f"{n}.txt", "") for n in range(40_000)))


def append(cells: list[dict[str, Any]]) -> Callable[[str], str]:
    return lambda text: with_keys(cells=[*json.loads(text)["cells"], *cells])(text)


def link_to(target: str) -> Submit:
    def submit_for(assignment: Assignment, student: str) -> None:
        folder = assignment.folder / "submitted" / student
        folder.mkdir(parents=True)
        (folder / HW).symlink_to(assignment.folder / target)

    return submit_for


def submit_linked_folder(assignment: Assignment, student: str) -> None:
    honest = assignment.folder / "submitted" / "honest"
    (assignment.folder / "submitted" / student).symlink_to(honest, target_is_directory=True)


def submit_pipe(assignment: Assignment, student: str) -> None:
    folder = assignment.folder / "submitted" / student
    folder.mkdir(parents=True)
    os.mkfifo(folder / HW)


def submit_bare_pipe(assignment: Assignment, student: str) -> None:
    os.mkfifo(assignment.folder / "submitted" / f"{student}.ipynb")


def submit_file_and_pipe(assignment: Assignment, student: str) -> None:
    submit_pipe(assignment, student)
    submit(assignment, f"{student}/mine.ipynb", make_correct_notebook(assignment, student))


def submit_gigabyte(assignment: Assignment, student: str) -> None:
    with submit(assignment, f"{student}/{HW}", "{").open("r+b") as file:
        file.truncate(1_000_000_000)


def submit_two_files(assignment: Assignment, student: str) -> None:
    submit(assignment, f"{student}/hw.ipynb", make_correct_notebook(assignment, student)[:500])
    submit(assignment, f"{student}/hw (1).ipynb", make_correct_notebook(assignment, student))


def submit_with_exports(assignment: Assignment, student: str) -> None:
    submit(assignment, f"{student}/hw.pdf", b"%PDF-1.7")
    submit(assignment, f"{student}/hw.html", "<!DOCTYPE html>")
    submit(assignment, f"{student}/Week 3/Übung für mich 🦾.ipynb", make_correct_notebook(assignment, student))
    submit(assignment, f"{student}/Week 3/.ipynb_checkpoints/hw.ipynb", "{}")


def submit_odd_name(assignment: Assignment, student: str) -> None:
    submit(assignment, f"{student}/a\nb\x1b[31m.ipynb", "{")


def deep_json(depth: int) -> Callable[[str], str]:
    return lambda text: '{"cells": [], "metadata": ' + '{"a":' * depth + "1" + "}" * depth + "}"


def submit_decomposed_name(assignment: Assignment, student: str) -> None:
    """Submit under a folder name with é written as e and a combining accent, as on macOS."""
    submit(assignment, "Zoe\u0301/hw.ipynb", make_correct_notebook(assignment, student))


ALL, NONE, NO_MARK = ALL_CORRECT, ["missing"] * 3, ["ungraded"] * 3
SENTENCE = "hw.ipynb is a PDF, not a notebook; submit the notebook itself"


def expect(content: Callable[[str], str | bytes], name: str = HW, expected: list[str] = ALL, words: str = "") -> Case:
    """Return a case of one file with these outcomes and a message that has these words."""
    return submit_file(name, content), expected, words


def expect_refusal(content: Callable[[str], str | bytes], words: str, name: str = HW) -> Case:
    return expect(content, name, NONE, f"{name} {words}")


def expect_over_limit(content: Callable[[str], str | bytes], words: str, name: str = HW) -> Case:
    return expect(content, name, NO_MARK, f"{name} {words}")


def strip_cell(cell: dict[str, Any], _: int) -> None:
    for key in ("outputs", "metadata", "execution_count"):
        cell.pop(key, None)


CASES: dict[str, Case] = {
    "version 3": expect_refusal(version_3, "is not a Jupyter notebook: it is JSON, but has no valid cells"),
    "version 4.0": expect(with_keys(nbformat_minor=0)),
    "saved by Colab": expect(colab(keeps_metadata=True)),
    "saved by Colab, nothing of ours kept": expect(colab(keeps_metadata=False), "Copy_of_hw.ipynb"),
    "version 4.5 with ids twice": expect(with_cells(lambda cell, _: cell.update(id="same"))),
    "no version": expect(with_keys(nbformat=None, nbformat_minor=None)),
    "version of the future": expect(with_keys(nbformat=9, nbformat_minor=10**30)),
    "keys that don't belong": expect(with_cells(lambda cell, n: cell.update(extra=[n], prompt_number="x"))),
    "no outputs, no metadata": expect(with_cells(strip_cell)),
    "sources as lists": expect(with_cells(lambda cell, _: cell.update(source=cell["source"].splitlines(True)))),
    "metadata null": expect(with_keys(metadata=[1])),
    "UTF-8 with a mark": expect(lambda text: b"\xef\xbb\xbf" + text.encode()),
    "UTF-16": expect(lambda text: text.encode("utf-16")),
    "UTF-16 without a mark": expect(lambda text: text.encode("utf-16-le")),
    "Latin-1": expect(lambda text: text.replace("# T", "# Übung").encode("latin-1")),
    "ends of lines of Windows": expect(lambda text: json.dumps(json.loads(text), indent=1).replace("\n", "\r\n")),
    "outputs of 100 MB": expect(large_outputs),
    "hw.ipynb.txt": expect(str, "hw.ipynb.txt"),
    "hw.json": expect(str, "hw.json"),
    "a script": expect(script, "hw.py", ALL, "hw.py Python script"),
    "a script with an error": expect(
        lambda text: f"{script(text)}\n\nif True:\nx = (\n", "hw.py", ALL, "Python script"
    ),
    "Markdown": expect(markdown, "hw.md", ALL, "hw.md Markdown"),
    "Quarto": expect(
        lambda text: markdown(text).replace("```python", "```{python}\n#| echo: false"),
        "hw.qmd",
        ALL,
        "hw.qmd Markdown",
    ),
    "a web page": expect_refusal(lambda _: "<!DOCTYPE html><html>", "web page .ipynb", "hw.html"),
    "a PDF": expect_refusal(lambda _: b"%PDF-1.7 \0", "PDF .ipynb", "hw.pdf"),
    "a PDF called a notebook": expect(lambda _: b"%PDF-1.7 \0", HW, NONE, SENTENCE),
    "Word": expect_refusal(lambda _: make_zip(("[Content_Types].xml", "<x/>")), "office .ipynb", "hw.docx"),
    "a picture": expect_refusal(lambda _: b"\x89PNG\r\n", "picture"),
    "RAR": expect_refusal(lambda _: b"Rar!\x1a\7", "RAR"),
    "zip": expect(zipped("my work/hw.ipynb"), "hw.zip", ALL, "hw.zip my work/hw.ipynb"),
    "zip of two": expect(zipped("b.ipynb", "a.ipynb"), "hw.zip", ALL, "qdot graded a.ipynb in it, not b.ipynb"),
    "zip of two, one by its name": expect(zipped("a.ipynb", "x/hw.ipynb"), "hw.zip", ALL, "x/hw.ipynb not a.ipynb"),
    "zip called a notebook": expect(zipped(HW), HW, ALL, "archive"),
    "tar.gz": expect(targz, "hw.tar.gz", ALL, "hw.tar.gz work/hw.ipynb"),
    "a zip that leads out of itself": expect(
        lambda text: make_zip((f"../s01/{HW}", "{}"), (HW, text)), "hw.zip", ALL, "qdot graded hw.ipynb in it"
    ),
    "zip in a zip": expect_refusal(lambda text: make_zip(("hw.zip", zipped(HW)(text))), "another archive", "hw.zip"),
    "empty zip": expect_refusal(lambda _: make_zip(), "no notebook", "hw.zip"),
    "zip bomb": expect_over_limit(zip_bomb, "hw.ipynb 200 MB", "hw.zip"),
    "tar bomb": expect_over_limit(gz_bomb, "200 MB", "hw.tgz"),
    "lying zip": expect_refusal(lying_zip, "hw.ipynb damaged", "hw.zip"),
    "damaged zip": expect_refusal(lambda text: zipped(HW)(text)[:-40], "damaged", "hw.zip"),
    "damaged gzip": expect_refusal(lambda text: targz(text)[:300], "damaged", "hw.tgz"),
    "encrypted zip": expect_refusal(encrypted, "hw.ipynb password", "hw.zip"),
    "links and ../ in a zip": expect(zip_with_link, "hw.zip", ALL, "hw.zip ../../../other.ipynb"),
    "forty thousand files": expect_over_limit(many_members, "10000 files", "hw.zip"),
    "a link to the secret": (link_to("secret.txt"), NONE, "hw.ipynb: symbolic link"),
    "a link to a fellow": (link_to("submitted/honest/hw.ipynb"), NONE, "symbolic link"),
    "a folder that is a link": (submit_linked_folder, NONE, "symbolic link"),
    "a pipe": (submit_pipe, NONE, "hw.ipynb: pipe"),
    "a pipe in no folder": (submit_bare_pipe, NONE, "pipe"),
    "a file beside a pipe": (submit_file_and_pipe, ALL, "hw.ipynb: pipe"),
    "a gigabyte": (submit_gigabyte, NO_MARK, "hw.ipynb 200 MB"),
    "a hundred thousand cells": expect_over_limit(append([code_cell("x = 1")] * 100_000), "25000 cells"),
    "a line of a million": expect(
        with_cells(lambda cell, n: n or cell.update(source="x" * 10**6, cell_type="code")), words="cell 1 line 1 xxxx"
    ),
    "too much code": expect_over_limit(
        with_cells(lambda cell, n: n == 1 and cell.update(source="#" * 21_000_000)), "20 MB code"
    ),
    "nested deep": expect_refusal(deep_json(100_000), "deep"),
    "tiny values": expect_over_limit(lambda _: '{"cells": [' + "[]," * 6_100_000 + "[]]}", "too much"),
    "a key that is not known": expect(with_keys(big=[0])),
    "empty": expect_refusal(lambda _: b" \n", "empty"),
    "cut off": expect_refusal(lambda text: text[:700], "incomplete (an error in line 1 of the file)"),
    "no cells": expect_refusal(lambda _: '{"cells": {}}', "no cells"),
    "cells that are none": expect(lambda _: '{"cells": [1, null, {"source": 5}, {"cell_type": []}]}', HW, NONE),
    "random bytes": expect_refusal(lambda _: bytes(range(256)) * 9, "not text"),
    "the first cut off, the second whole": (submit_two_files, ALL, "line 1 of the file); hw (1).ipynb"),
    "exports beside it, in a folder": (submit_with_exports, ALL, ""),
    "a name with a new line": (submit_odd_name, NONE, "a\N{REPLACEMENT CHARACTER}b\N{REPLACEMENT CHARACTER}[31m.ipynb"),
    "another accent": (submit_decomposed_name, ALL, ""),
    "twenty thousand cells, half of them text that looks like an answer": expect(
        append([code_cell(""), text_cell("p1_jacobian = 3")] * 10_000)
    ),
}
STUDENTS = {name: "Zo\u00e9" if name == "another accent" else f"s{number:02d}" for number, name in enumerate(CASES)}


def grade_cases(cases: Collection[str], folder: Path) -> dict[str, Result]:
    """Grade one class with a student for each case and an honest one; return their results."""
    students = [*(STUDENTS[case] for case in cases), "honest"]
    assignment = make_class(folder / "hw", [Student(student) for student in students])
    submit(assignment, "honest/hw.ipynb", make_correct_notebook(assignment, "honest"))
    for case in cases:
        submit_case, *_ = CASES[case]
        submit_case(assignment, STUDENTS[case])
    results, submissions = grade(assignment, seconds=60)
    assert not submissions.not_on_roster and not submissions.uncertain_owners
    return {**{case: results[STUDENTS[case]] for case in cases}, "honest": results["honest"]}


CLASSES = [list(CASES)[first::8] for first in range(8)]
"""The cases of each class: a single class of all cases would keep one process busy for long."""


@pytest.mark.parametrize("cases", select_for_suite([list(CASES)[::12]], CLASSES), ids=lambda cases: cases[0])
def test_every_file_gets_its_verdict(cases: list[str], tmp_path: Path) -> None:
    results = grade_cases(cases, tmp_path)
    honest = results["honest"]
    assert list_outcomes(honest) == ALL_CORRECT and not honest.staff_notes  # the other students are graded as usual
    for case in cases:
        _, expected, words = CASES[case]
        messages = [results[case].obstacle or "", *results[case].notes]
        assert list_outcomes(results[case]) == expected, (case, messages)
        assert results[case].score == (4 if expected == ALL else 0), case
        has_words = any(all(word in message for word in words.split()) for message in messages)
        assert has_words if words else not results[case].staff_notes, (case, messages)
        assert not any(character in message for message in messages for character in "\n\x1b"), (case, messages)
        status = "over limit" if expected == NO_MARK else "unusable" if words else "graded"
        assert expected == ALL or find_work_status(results[case]) == status, case


JUPYTEXT = sorted((DATA / "jupytext").iterdir())


@pytest.mark.parametrize("path", sample_for_suite(JUPYTEXT, 3), ids=lambda path: path.stem)
def test_files_of_jupytext_and_nbconvert_are_read(path: Path) -> None:
    """One notebook as written by jupytext 1.19.6 and nbconvert 7.17, with J for p1_b; nbconvert drops metadata."""
    content = read_cells(path.stem, path.read_bytes())
    with Sandbox() as sandbox:
        result = find_answers(content.cells, ["p1.a", "p1.b", "p1.c"], sandbox.run)
    from_metadata = {} if path.stem == "nbconvert.py" else {"p1_b": "[[x, 0], [1, x]]"}
    assert result.run.answers == {"p1_a": "x", "p1_c": "x + 1", **from_metadata}
    assert result.missing_reasons == ({} if from_metadata else {"p1_b": "no cell of the notebook sets p1_b"})


def test_hostile_files_are_refused_within_seconds() -> None:
    start = time.process_time()
    deep = (b"[" * 10**6, b'{"cells":' * 10**5, b"{" + b'"a":1,' * 10**6, b'{"\\ud800": "\\ud800"}', b"\xff\xfe\0")
    for content in deep:
        with pytest.raises(Unreadable):
            read_cells(HW, content)
    assert read_cells(HW, b'{"cells": [], "n": ' + b"9" * 10**6 + b"}").cells == ()
    long_sum = "1" + "+1" * 90_000
    for source in ("(" * 10**5, "-" * 10**5 + "1", "x" + ".a" * 90_000, long_sum, "f'" + "{" * 10**5):
        read_cells("hw.py", source.encode())
    read_cells("hw.md", b"```python\n" * 10**5)
    for name, content in (("hw.py", b"# %%\n" * 10**6), (HW, b'{"cells": [' + b"{}, " * 30_000 + b"{}]}")):
        with pytest.raises(OverLimit, match="cells"):
            read_cells(name, content)
    assert time.process_time() - start < 20


def test_a_large_file_is_read_by_a_limited_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """The other process reads the same cells, even beside outputs of several megabytes."""
    outputs = [{"data": {"image/png": "iVBOR" * 300_000}}]
    metadata = {"qdot": {"part": "p1.jacobian"}}
    cell = {"cell_type": "code", "source": ["x = 'ä'"], "outputs": outputs, "metadata": metadata}
    large = json.dumps({"cells": [cell, {"source": "\ud800"}], "metadata": {"qdot": {"student": "s1"}}}).encode()
    small = large.replace(b"iVBOR" * 300_000, b"")
    assert len(small) < MAX_BYTES_IN_THIS_PROCESS < len(large)
    assert read_cells(HW, large) == read_cells(HW, small)
    with pytest.raises(Unreadable, match="incomplete") as caught:
        read_cells(HW, large[:-1])
    assert not isinstance(caught.value, OverLimit)
    monkeypatch.setattr(reading, "MAX_MEMORY_BYTES", 60_000_000)
    with pytest.raises(OverLimit, match="too much memory or time"):
        read_cells("hw.py", b"# %%\n" * 2_000_000)


def test_work_over_a_limit_is_ungraded_without_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The limit on text that is searched for answers counts, too."""
    monkeypatch.setattr(answer_locator, "MAX_PARSED_CHARACTERS", 300_000)
    assignment = make_class(tmp_path / "hw", [Student("s0"), Student("s1"), Student("s2")])
    submit(assignment, "s0.py", b"# %%\n" * 10**5)
    unparsable = "p1_position = (\np1_jacobian = (\np1_determinant = (\n" + "+".join(["[a]"] * 7000)
    submit(assignment, "s1.ipynb", write_notebook(assignment, "s1", [text_cell(f"{unparsable}{k}") for k in range(9)]))
    submit(assignment, "s2.ipynb", make_correct_notebook(assignment, "s2"))
    results, _ = grade(assignment)
    assert [find_work_status(results[name]) for name in ("s0", "s1", "s2")] == ["over limit", "over limit", "graded"]
    assert "cells" in (results["s0"].obstacle or "")
    assert "too much code to search" in (results["s1"].obstacle or "")
    row = make_grades_csv([results["s0"]], assignment.roster).splitlines()[1]
    assert ",,4,,over limit," in row and "tell your instructor" not in row
    page = make_feedback_page(assignment, assignment.roster[0], results["s0"])
    assert "it has no mark yet" in page and " of 4 points" not in page


HELPER = "def angle(x):\n    return x + 0\n"


def test_a_module_beside_a_notebook_is_imported_only_by_that_notebook(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", [Student(f"s{k}") for k in range(4)])

    def notebook_with_import(student: str) -> str:
        return make_correct_notebook(
            assignment, student, lambda cells: cells.insert(2, code_cell("from helper import angle\nangle(theta1)"))
        )

    submit(assignment, f"s0/{HW}", notebook_with_import("s0"))
    submit(assignment, "s0/helper.py", HELPER)
    submit(assignment, "s1.zip", make_zip((f"work/{HW}", notebook_with_import("s1")), ("work/helper.py", HELPER)))
    submit(assignment, f"s2/{HW}", notebook_with_import("s2"))
    submit(assignment, "s3.ipynb", notebook_with_import("s3"))
    submit(assignment, "helper.py", HELPER)
    results, _ = grade(assignment)
    lacks_helper = ["No module named 'helper'" in " ".join(results[f"s{k}"].notes) for k in range(4)]
    assert lacks_helper == [False, False, True, True]
    assert list_outcomes(results["s0"]) == list_outcomes(results["s1"]) == ALL_CORRECT
    submit(assignment, "s0/helper.py", "raise ValueError('another one')")
    assert "another one" in " ".join(grade(assignment)[0]["s0"].notes), "a changed module is a changed submission"
    folder = assignment.folder / "submitted" / "s0"
    assert "another one" in " ".join(check_notebook(folder / HW).notes)
    (folder / "helper.py").rename(tmp_path / "elsewhere.py")
    (folder / "helper.py").symlink_to(tmp_path / "elsewhere.py")
    os.mkfifo(folder / "waits.py")  # reading it would block
    assert "No module named 'helper'" in " ".join(check_notebook(folder / HW).notes)


def test_a_download_may_have_the_allowed_number_of_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archives, "MAX_DOWNLOAD_FILES", 3)
    for count in (3, 4):
        (tmp_path / "class.zip").write_bytes(make_zip(*((f"s{k}/{HW}", "{}") for k in range(count))))
        refusal = pytest.raises(Unreadable, match="more than 3 files") if count > 3 else nullcontext()
        with refusal, archives.unpack_temporarily(tmp_path / "class.zip") as (folder, left_out):
            assert len(list(folder.rglob("*.ipynb"))) == 3 and not left_out


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("---\ntags: [a]\n---\np1_jacobian = 1", "p1_jacobian = 1"), (":tags: [a]\np1_jacobian = 1", "p1_jacobian = 1"),
        *((text, text) for text in ("p1_jacobian = 1\n---\n# after a line\n---", "---\np1_jacobian = 1")),
    ],
)  # fmt: skip
def test_myst_options_at_the_top_of_a_cell_are_left_out(body: str, code: str) -> None:
    content = read_cells("hw.md", f"text\n\n```{{code-cell}} ipython3\n{body}\n```\n".encode())
    assert [cell.source for cell in content.cells if cell.is_code] == [code]


def test_a_broken_notebook_is_reported_with_its_line() -> None:
    conflict = '{\n<<<<<<< HEAD\n "cells": []\n=======\n "cells": [1]\n>>>>>>> 1a2b\n}'
    for content, message in (
        (conflict, "line 2 of the file), because it contains conflict markers of Git"), (",", "not a Jupyter notebook"),
        ('{"cells": [],\n}', "is not a Jupyter notebook, or it is incomplete"),
        ('{"cells": [{"source": "a, ]"', "or it is incomplete (an error in line 1 of the file)"),
    ):  # fmt: skip
        with pytest.raises(Unreadable, match=re.escape(message)):
            read_cells("hw.ipynb", content.encode())
