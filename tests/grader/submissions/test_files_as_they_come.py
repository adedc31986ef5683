"""Files as they come: versions, formats, archives, what is hostile or enormous; and everybody else is graded."""

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
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.grader.grading.check import check_notebook
from qdot.grader.grading.result import Result
from qdot.grader.reports.feedback import make_feedback_page
from qdot.grader.reports.tables import find_work_status, make_grades_csv
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
    make_correct_cells,
    make_correct_notebook,
    submit,
    text_cell,
    write_notebook,
)
from tests.support.suites import sample_for_suite, select_for_suite

pytestmark = pytest.mark.xdist_group("files-as-they-come")
HW = "hw.ipynb"
Make = Callable[[Assignment, str], Any]
"""Hands in for a student, into a folder of theirs."""
Case = tuple[Make, list[str], str]
"""Who hands in, what the three parts get, and words that one sentence has."""


def file(name: str, content: Callable[[str], str | bytes]) -> Make:
    """Hand in one file, made of the text of the right notebook."""

    def make(assignment: Assignment, student: str) -> None:
        submit(assignment, f"{student}/{name}", content(make_correct_notebook(assignment, student)))

    return make


def again(**others: Any) -> Callable[[str], str]:
    """Return the notebook with other keys at the top; None takes one away."""
    return lambda text: json.dumps({k: v for k, v in {**json.loads(text), **others}.items() if v is not None})


def version_3(text: str) -> str:
    cells = json.loads(text)["cells"]
    for cell in cells:
        if cell["cell_type"] == "code":
            cell["input"] = cell.pop("source").splitlines(keepends=True)
            cell["language"] = "python"
    sheet = {"cells": cells, "metadata": {}}
    return json.dumps({"metadata": {"name": "hw"}, "nbformat": 3, "nbformat_minor": 0, "worksheets": [sheet]})


def cells(change: Callable[[dict[str, Any], int], Any]) -> Callable[[str], str]:
    def changed(text: str) -> str:
        data = json.loads(text)
        for number, cell in enumerate(data["cells"]):
            change(cell, number)
        return json.dumps(data)

    return changed


def colab(keeps: bool) -> Callable[[str], str]:
    """Return the notebook as Colab saves it: version 4.0, ids and who ran what in the metadata, which `keeps` ours.

    Before an answer stands what a menu of Colab writes there: a form's title, and an installation.
    """

    def saved(text: str) -> str:
        data = json.loads(text)
        for number, cell in enumerate(data["cells"]):
            if number == 2:
                cell["source"] = f'#@title Answer {{ display-mode: "form" }}\n!pip install -q sympy\n{cell["source"]}'
            cell["source"] = cell["source"].splitlines(keepends=True)
            cell["metadata"] = {**(cell["metadata"] if keeps else {}), "id": f"nWq-7cPBc{number:03d}"}
            if cell["cell_type"] == "code":
                ran_by = {"status": "ok", "user": {"displayName": "Ada L.", "userId": "04104170300566764648"}}
                cell["metadata"] |= {"colab": {"height": 35}, "cellView": "form", "executionInfo": ran_by}
                shown = {"text/plain": ["0"], "application/vnd.google.colaboratory.intrinsic+json": {"type": "string"}}
                output = {"output_type": "execute_result", "data": shown, "metadata": {}, "execution_count": number}
                cell |= {"execution_count": number, "outputs": [output]}
        own = {"qdot": data["metadata"].get("qdot")} if keeps else {}
        about = {"colab": {"toc_visible": True}, "kernelspec": {"name": "python3"}, "accelerator": "GPU", **own}
        return json.dumps({"nbformat": 4, "nbformat_minor": 0, "metadata": about, "cells": data["cells"]})

    return saved


def large_outputs(text: str) -> str:
    picture = {"output_type": "display_data", "metadata": {}, "data": {"image/png": "iVBORw0KGgo" * 4_500_000}}
    stream = {"output_type": "stream", "name": "stdout", "text": ["0.123456789\n"] * 3_500_000}
    data = json.loads(text)
    data["cells"][1]["outputs"], data["cells"][2]["outputs"] = [picture], [stream]
    made = json.dumps(data)
    assert len(made) > 100_000_000
    return made


def script(text: str) -> str:
    return "\n\n".join(cell["source"] for cell in json.loads(text)["cells"] if cell["cell_type"] == "code")


def markdown(text: str) -> str:
    """What else jupytext and others make of a notebook is in tests/data/jupytext."""
    cells = json.loads(text)["cells"]
    return "\n".join(
        f"```python\n{cell['source']}\n```\n"
        if cell["cell_type"] == "code"
        else f"{cell['source']}\n```bash\nls\n```\n"
        for cell in cells
    )


def zipped(*names: str, prefix: str = "") -> Callable[[str], bytes]:
    """Return a zip with the right notebook under each name, and what macOS adds."""

    def made(text: str) -> bytes:
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w") as archive:
            for name in names:
                archive.writestr(name, text)
            archive.writestr(f"__MACOSX/._{names[0]}", b"\0\5\x16\7")
            archive.writestr(f".ipynb_checkpoints/{names[0]}", "{}")
        return out.getvalue()

    return made


def of_members(*members: tuple[str, str | bytes], **how: Any) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, **how) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return out.getvalue()


def targz(text: str) -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w:gz") as archive:
        link = tarfile.TarInfo("a.ipynb")
        link.type, link.linkname = tarfile.SYMTYPE, "/etc/passwd"
        archive.addfile(link)
        info = tarfile.TarInfo("work/hw.ipynb")
        info.size = len(text.encode())
        archive.addfile(info, io.BytesIO(text.encode()))
    return out.getvalue()


def gz_bomb(_: str) -> bytes:
    out = io.BytesIO()
    with gzip.GzipFile(fileobj=out, mode="wb", compresslevel=9) as file:
        for _n in range(250):
            file.write(bytes(1 << 20))
    return out.getvalue()


def zip_bomb(_: str) -> bytes:
    """A megabyte that says of itself that it unpacks to a gigabyte."""
    return of_members(("hw.ipynb", bytes(300_000_000)))


def patched(made: bytes, directory: int, local: int, field: bytes) -> bytes:
    """Change a field of both headers of a zip's only member."""
    changed = bytearray(made)
    for mark, at in ((b"PK\1\2", directory), (b"PK\3\4", local)):
        place = changed.index(mark) + at
        changed[place : place + len(field)] = field
    return bytes(changed)


def lying_zip(_: str) -> bytes:
    """A zip whose directory says that the notebook in it has ten bytes."""
    return patched(of_members((HW, "{" + " " * 5_000_000 + "}")), 24, 22, (10).to_bytes(4, "little"))


def encrypted(text: str) -> bytes:
    return patched(of_members((HW, text)), 8, 6, b"\1")


def zip_with_link(text: str) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        info = zipfile.ZipInfo("hw.ipynb")
        info.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(info, "../../secret.txt")
        archive.writestr("../../../other.ipynb", text)
    return out.getvalue()


def many_members(_: str) -> bytes:
    return of_members(*((f"{n}.txt", "") for n in range(40_000)))


def many_cells(text: str) -> str:
    data = json.loads(text)
    data["cells"] += [{"cell_type": "code", "metadata": {}, "source": "x = 1"}] * 100_000
    return json.dumps(data)


def link_to(target: str) -> Make:
    def make(assignment: Assignment, student: str) -> None:
        folder = assignment.folder / "submitted" / student
        folder.mkdir(parents=True)
        (folder / HW).symlink_to(assignment.folder / target)

    return make


def linked_folder(assignment: Assignment, student: str) -> None:
    honest = assignment.folder / "submitted" / "honest"
    (assignment.folder / "submitted" / student).symlink_to(honest, target_is_directory=True)


def pipe(assignment: Assignment, student: str) -> None:
    folder = assignment.folder / "submitted" / student
    folder.mkdir(parents=True)
    os.mkfifo(folder / HW)


def bare_pipe(assignment: Assignment, student: str) -> None:
    os.mkfifo(assignment.folder / "submitted" / f"{student}.ipynb")


def file_and_pipe(assignment: Assignment, student: str) -> None:
    pipe(assignment, student)
    submit(assignment, f"{student}/mine.ipynb", make_correct_notebook(assignment, student))


def sparse(assignment: Assignment, student: str) -> None:
    with submit(assignment, f"{student}/{HW}", "{").open("r+b") as file:
        file.truncate(1_000_000_000)


def two(assignment: Assignment, student: str) -> None:
    submit(assignment, f"{student}/hw.ipynb", make_correct_notebook(assignment, student)[:500])
    submit(assignment, f"{student}/hw (1).ipynb", make_correct_notebook(assignment, student))


def with_an_export(assignment: Assignment, student: str) -> None:
    submit(assignment, f"{student}/hw.pdf", b"%PDF-1.7")
    submit(assignment, f"{student}/hw.html", "<!DOCTYPE html>")
    submit(assignment, f"{student}/Week 3/Übung für mich 🦾.ipynb", make_correct_notebook(assignment, student))
    submit(assignment, f"{student}/Week 3/.ipynb_checkpoints/hw.ipynb", "{}")


def odd_name(assignment: Assignment, student: str) -> None:
    submit(assignment, f"{student}/a\nb\x1b[31m.ipynb", "{")


def nested(depth: int) -> Callable[[str], str]:
    return lambda text: '{"cells": [], "metadata": ' + '{"a":' * depth + "1" + "}" * depth + "}"


def one_file_below(assignment: Assignment, student: str) -> None:
    """macOS writes é as e and an accent: the folder's name is not the identifier's bytes, and means the same."""
    submit(assignment, "Zoe\u0301/hw.ipynb", make_correct_notebook(assignment, student))


ALL, NONE, NO_MARK = ALL_CORRECT, ["missing"] * 3, ["ungraded"] * 3
SENTENCE = "hw.ipynb is a PDF, not a notebook; submit the notebook itself"


def of(content: Callable[[str], str | bytes], name: str = HW, due: list[str] = ALL, words: str = "") -> Case:
    """Hand in one file that gives these outcomes, and of which a sentence has these words."""
    return file(name, content), due, words


def refused(content: Callable[[str], str | bytes], words: str, name: str = HW) -> Case:
    return of(content, name, NONE, f"{name} {words}")


def exceeding(content: Callable[[str], str | bytes], words: str, name: str = HW) -> Case:
    return of(content, name, NO_MARK, f"{name} {words}")


def bare(cell: dict[str, Any], _: int) -> None:
    for key in ("outputs", "metadata", "execution_count"):
        cell.pop(key, None)


CASES: dict[str, Case] = {
    "version 3": refused(version_3, "is not a Jupyter notebook: it is JSON, but has no valid cells"),
    "version 4.0": of(again(nbformat_minor=0)),
    "saved by Colab": of(colab(keeps=True)),
    "saved by Colab, nothing of ours kept": of(colab(keeps=False), "Copy_of_hw.ipynb"),
    "version 4.5 with ids twice": of(cells(lambda cell, _: cell.update(id="same"))),
    "no version": of(again(nbformat=None, nbformat_minor=None)),
    "version of the future": of(again(nbformat=9, nbformat_minor=10**30)),
    "keys that don't belong": of(cells(lambda cell, n: cell.update(extra=[n], prompt_number="x"))),
    "no outputs, no metadata": of(cells(bare)),
    "sources as lists": of(cells(lambda cell, _: cell.update(source=cell["source"].splitlines(True)))),
    "metadata null": of(again(metadata=[1])),
    "UTF-8 with a mark": of(lambda text: b"\xef\xbb\xbf" + text.encode()),
    "UTF-16": of(lambda text: text.encode("utf-16")),
    "UTF-16 without a mark": of(lambda text: text.encode("utf-16-le")),
    "Latin-1": of(lambda text: text.replace("# T", "# Übung").encode("latin-1")),
    "ends of lines of Windows": of(lambda text: json.dumps(json.loads(text), indent=1).replace("\n", "\r\n")),
    "outputs of 100 MB": of(large_outputs),
    "hw.ipynb.txt": of(str, "hw.ipynb.txt"),
    "hw.json": of(str, "hw.json"),
    "a script": of(script, "hw.py", ALL, "hw.py Python script"),
    "a script with an error": of(lambda text: script(text) + "\n\nif True:\nx = (\n", "hw.py", ALL, "Python script"),
    "Markdown": of(markdown, "hw.md", ALL, "hw.md Markdown"),
    "Quarto": of(
        lambda text: markdown(text).replace("```python", "```{python}\n#| echo: false"),
        "hw.qmd",
        ALL,
        "hw.qmd Markdown",
    ),
    "a web page": refused(lambda _: "<!DOCTYPE html><html>", "web page .ipynb", "hw.html"),
    "a PDF": refused(lambda _: b"%PDF-1.7 \0", "PDF .ipynb", "hw.pdf"),
    "a PDF called a notebook": of(lambda _: b"%PDF-1.7 \0", HW, NONE, SENTENCE),
    "Word": refused(lambda _: of_members(("[Content_Types].xml", "<x/>")), "office .ipynb", "hw.docx"),
    "a picture": refused(lambda _: b"\x89PNG\r\n", "picture"),
    "RAR": refused(lambda _: b"Rar!\x1a\7", "RAR"),
    "zip": of(zipped("my work/hw.ipynb"), "hw.zip", ALL, "hw.zip my work/hw.ipynb"),
    "zip of two": of(zipped("b.ipynb", "a.ipynb"), "hw.zip", ALL, "qdot graded a.ipynb in it, not b.ipynb"),
    "zip of two, one by its name": of(zipped("a.ipynb", "x/hw.ipynb"), "hw.zip", ALL, "x/hw.ipynb not a.ipynb"),
    "zip called a notebook": of(zipped(HW), HW, ALL, "archive"),
    "tar.gz": of(targz, "hw.tar.gz", ALL, "hw.tar.gz work/hw.ipynb"),
    "a zip that leads out of itself": of(
        lambda text: of_members((f"../s01/{HW}", "{}"), (HW, text)), "hw.zip", ALL, "qdot graded hw.ipynb in it"
    ),
    "zip in a zip": refused(lambda text: of_members(("hw.zip", zipped(HW)(text))), "another archive", "hw.zip"),
    "empty zip": refused(lambda _: of_members(), "no notebook", "hw.zip"),
    "zip bomb": exceeding(zip_bomb, "hw.ipynb 200 MB", "hw.zip"),
    "tar bomb": exceeding(gz_bomb, "200 MB", "hw.tgz"),
    "lying zip": refused(lying_zip, "hw.ipynb damaged", "hw.zip"),
    "damaged zip": refused(lambda text: zipped(HW)(text)[:-40], "damaged", "hw.zip"),
    "damaged gzip": refused(lambda text: targz(text)[:300], "damaged", "hw.tgz"),
    "encrypted zip": refused(encrypted, "hw.ipynb password", "hw.zip"),
    "links and ../ in a zip": of(zip_with_link, "hw.zip", ALL, "hw.zip ../../../other.ipynb"),
    "forty thousand files": exceeding(many_members, "10000 files", "hw.zip"),
    "a link to the secret": (link_to("secret.txt"), NONE, "hw.ipynb: symbolic link"),
    "a link to a fellow": (link_to("submitted/honest/hw.ipynb"), NONE, "symbolic link"),
    "a folder that is a link": (linked_folder, NONE, "symbolic link"),
    "a pipe": (pipe, NONE, "hw.ipynb: pipe"),
    "a pipe in no folder": (bare_pipe, NONE, "pipe"),
    "a file beside a pipe": (file_and_pipe, ALL, "hw.ipynb: pipe"),
    "a gigabyte": (sparse, NO_MARK, "hw.ipynb 200 MB"),
    "a hundred thousand cells": exceeding(many_cells, "25000 cells"),
    "a line of a million": of(
        cells(lambda cell, n: n or cell.update(source="x" * 10**6, cell_type="code")), HW, ALL, "cell 1 line 1, xxxx"
    ),
    "too much code": exceeding(cells(lambda cell, n: n == 1 and cell.update(source="#" * 21_000_000)), "20 MB code"),
    "nested deep": refused(nested(100_000), "deep"),
    "tiny values": exceeding(lambda _: '{"cells": [' + "[]," * 6_100_000 + "[]]}", "too much"),
    "a key that is not known": of(again(big=[0])),
    "empty": refused(lambda _: b" \n", "empty"),
    "cut off": refused(lambda text: text[:700], "incomplete (line 1)"),
    "no cells": refused(lambda _: '{"cells": {}}', "no cells"),
    "cells that are none": of(lambda _: '{"cells": [1, null, {"source": 5}, {"cell_type": []}]}', HW, NONE),
    "random bytes": refused(lambda _: bytes(range(256)) * 9, "not text"),
    "the first cut off, the second whole": (two, ALL, "(line 1); hw (1).ipynb"),
    "exports beside it, in a folder": (with_an_export, ALL, ""),
    "a name with a new line": (odd_name, NONE, "a\N{REPLACEMENT CHARACTER}b\N{REPLACEMENT CHARACTER}[31m.ipynb"),
    "another accent": (one_file_below, ALL, ""),
}
STUDENTS = {name: "Zo\u00e9" if name == "another accent" else f"s{number:02d}" for number, name in enumerate(CASES)}


def graded(cases: Collection[str], folder: Path) -> dict[str, Result]:
    """Everybody's result in one class of a student a case, and an honest one."""
    everybody = [*(STUDENTS[case] for case in cases), "honest"]
    assignment = make_class(folder / "hw", [Student(student) for student in everybody])
    submit(assignment, "honest/hw.ipynb", make_correct_notebook(assignment, "honest"))
    for case in cases:
        make, *_ = CASES[case]
        make(assignment, STUDENTS[case])
    results, looked = grade(assignment, seconds=60)
    assert not looked.not_on_roster and not looked.uncertain_owners
    return {**{case: results[STUDENTS[case]] for case in cases}, "honest": results["honest"]}


CLASSES = [list(CASES)[first::8] for first in range(8)]
"""Cases whose files a class hands in: in one class of all of them, whoever is first waits for everybody."""


@pytest.mark.parametrize("cases", select_for_suite(CLASSES[:1], CLASSES), ids=lambda cases: cases[0])
def test_every_file_gets_its_verdict(cases: list[str], tmp_path: Path) -> None:
    results = graded(cases, tmp_path)
    honest = results["honest"]
    assert list_outcomes(honest) == ALL_CORRECT and not honest.staff_notes  # everybody else is graded as ever
    for case in cases:
        _, due, words = CASES[case]
        told = [results[case].obstacle or "", *results[case].notes]
        assert list_outcomes(results[case]) == due, (case, told)
        assert results[case].score == (4 if due == ALL else 0), case
        has_words = any(all(word in each for word in words.split()) for each in told)
        assert has_words if words else not results[case].staff_notes, (case, told)
        assert not any(ch in each for each in told for ch in "\n\x1b"), (case, told)
        state = "over limit" if due == NO_MARK else "unusable" if words else "graded"
        assert due == ALL or find_work_status(results[case]) == state, case


JUPYTEXT = sorted((DATA / "jupytext").iterdir())


@pytest.mark.parametrize("path", sample_for_suite(JUPYTEXT, 3), ids=lambda path: path.stem)
def test_what_jupytext_and_nbconvert_write_is_read(path: Path) -> None:
    """One notebook as jupytext 1.19.6 and nbconvert 7.17 write it, J for p1_b; the last does not keep metadata."""
    content = read_cells(path.stem, path.read_bytes())
    with Sandbox() as sandbox:
        found = find_answers(content.cells, ["p1.a", "p1.b", "p1.c"], sandbox.run)
    kept = {} if path.stem == "nbconvert.py" else {"p1_b": "[[x, 0], [1, x]]"}
    assert found.run.answers == {"p1_a": "x", "p1_c": "x + 1", **kept}
    assert found.reasons == ({} if kept else {"p1_b": "no cell of the notebook sets p1_b"})


def test_hostile_files_end_in_a_sentence_within_seconds() -> None:
    begun = time.process_time()
    deep = (b"[" * 10**6, b'{"cells":' * 10**5, b"{" + b'"a":1,' * 10**6, b'{"\\ud800": "\\ud800"}', b"\xff\xfe\0")
    for data in deep:
        with pytest.raises(Unreadable):
            read_cells(HW, data)
    assert read_cells(HW, b'{"cells": [], "n": ' + b"9" * 10**6 + b"}").cells == ()
    sums = "1" + "+1" * 90_000
    for source in ("(" * 10**5, "-" * 10**5 + "1", "x" + ".a" * 90_000, sums, "f'" + "{" * 10**5):
        read_cells("hw.py", source.encode())
    read_cells("hw.md", b"```python\n" * 10**5)
    for name, data in (("hw.py", b"# %%\n" * 10**6), (HW, b'{"cells": [' + b"{}, " * 30_000 + b"{}]}")):
        with pytest.raises(OverLimit, match="cells"):
            read_cells(name, data)
    assert time.process_time() - begun < 20


def test_a_large_file_is_read_within_limits_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """By another process, which reads the same: also beside outputs of megabytes."""
    shown = [{"data": {"image/png": "iVBOR" * 300_000}}]
    cell = {"cell_type": "code", "source": ["x = 'ä'"], "outputs": shown, "metadata": {"qdot": {"part": "p1.jacobian"}}}
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


def test_what_exceeds_a_limit_has_no_mark_and_nothing_failed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where answers are looked for in text that is no Python."""
    monkeypatch.setattr(answer_locator, "MAX_PARSED_CHARACTERS", 300_000)
    assignment = make_class(tmp_path / "hw", [Student("s0"), Student("s1"), Student("s2")])
    submit(assignment, "s0.py", b"# %%\n" * 10**5)
    searched = "p1_position = (\np1_jacobian = (\np1_determinant = (\n" + "+".join(["[a]"] * 7000)
    submit(assignment, "s1.ipynb", write_notebook(assignment, "s1", [text_cell(f"{searched}{k}") for k in range(9)]))
    submit(assignment, "s2.ipynb", make_correct_notebook(assignment, "s2"))
    results, _ = grade(assignment)
    assert [find_work_status(results[name]) for name in ("s0", "s1", "s2")] == ["over limit", "over limit", "graded"]
    assert "cells" in (results["s0"].obstacle or "")
    assert "too much code to search for answers" in (results["s1"].obstacle or "")
    row = make_grades_csv([results["s0"]], assignment.roster).splitlines()[1]
    assert ",,4,,over limit," in row and "tell your instructor" not in row
    page = make_feedback_page(assignment, assignment.roster[0], results["s0"])
    assert "No mark yet" in page and " of 4 points" not in page


HELPER = "def angle(x):\n    return x + 0\n"


def test_a_module_that_is_handed_in_beside_a_notebook_is_imported_from_there_only(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", [Student(f"s{k}") for k in range(4)])

    def importing(student: str) -> str:
        return make_correct_notebook(
            assignment,
            student,
            lambda cells: cells.insert(2, code_cell("from helper import angle\nangle(theta1)")),
        )

    submit(assignment, f"s0/{HW}", importing("s0"))
    submit(assignment, "s0/helper.py", HELPER)
    submit(assignment, "s1.zip", of_members((f"work/{HW}", importing("s1")), ("work/helper.py", HELPER)))
    submit(assignment, f"s2/{HW}", importing("s2"))
    submit(assignment, "s3.ipynb", importing("s3"))
    submit(assignment, "helper.py", HELPER)
    results, _ = grade(assignment)
    lacks = ["No module named 'helper'" in " ".join(results[f"s{k}"].notes) for k in range(4)]
    assert lacks == [False, False, True, True]
    assert list_outcomes(results["s0"]) == list_outcomes(results["s1"]) == ALL_CORRECT
    submit(assignment, "s0/helper.py", "raise ValueError('another one')")
    assert "another one" in " ".join(grade(assignment)[0]["s0"].notes), "it is part of what was handed in"
    own = assignment.folder / "submitted" / "s0"
    assert "another one" in " ".join(check_notebook(own / HW).notes)
    (own / "helper.py").rename(tmp_path / "elsewhere.py")
    (own / "helper.py").symlink_to(tmp_path / "elsewhere.py")
    os.mkfifo(own / "waits.py")  # whoever reads it waits
    assert "No module named 'helper'" in " ".join(check_notebook(own / HW).notes)


def test_the_largest_of_what_is_bounded(tmp_path: Path) -> None:
    """Ten thousand empty cells, and as many of text that are called as an answer is."""
    assignment = make_class(tmp_path / "hw", [Student("s1")])
    cells = make_correct_cells(assignment, "s1") + [code_cell(""), text_cell("p1_jacobian = 3")] * 10_000
    submit(assignment, "s1.ipynb", write_notebook(assignment, "s1", cells))
    results, _ = grade(assignment, seconds=60)
    assert list_outcomes(results["s1"]) == ALL_CORRECT


@pytest.mark.parametrize("count", [3, 4])
def test_a_class_may_have_as_many_files_as_are_allowed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    monkeypatch.setattr(archives, "MAX_DOWNLOAD_FILES", 3)
    (tmp_path / "class.zip").write_bytes(of_members(*((f"s{k}/{HW}", "{}") for k in range(count))))
    if count > 3:
        with pytest.raises(Unreadable, match="more than 3 files"), archives.unpack_temporarily(tmp_path / "class.zip"):
            pass
    else:
        with archives.unpack_temporarily(tmp_path / "class.zip") as (folder, left_out):
            assert len(list(folder.rglob("*.ipynb"))) == 3 and not left_out


OPTIONS = [
    ("---\ntags: [a]\n---\np1_jacobian = 1", "p1_jacobian = 1"),
    (":tags: [a]\np1_jacobian = 1", "p1_jacobian = 1"),
    ("p1_jacobian = 1\n---\n# after a line\n---", "p1_jacobian = 1\n---\n# after a line\n---"),
    ("---\np1_jacobian = 1", "---\np1_jacobian = 1"),
]


@pytest.mark.parametrize(("body", "code"), OPTIONS)
def test_options_of_myst_are_left_out_where_they_open_a_cell(body: str, code: str) -> None:
    content = read_cells("hw.md", f"text\n\n```{{code-cell}} ipython3\n{body}\n```\n".encode())
    assert [cell.source for cell in content.cells if cell.is_code] == [code]


BROKEN = [
    (
        '{\n<<<<<<< HEAD\n "cells": []\n=======\n "cells": [1]\n>>>>>>> 1a2b\n}',
        "(line 2), because it contains conflict markers of Git",
    ),
    ('{"cells": [],\n}', "is not a Jupyter notebook, or it is incomplete"),
    ('{"cells": [{"source": "a, ]"', "is not a Jupyter notebook, or it is incomplete (line 1)"),
    (",", "is not a Jupyter notebook"),
]


@pytest.mark.parametrize(("content", "said"), BROKEN)
def test_what_is_wrong_with_a_notebook_is_told_with_its_line(content: str, said: str) -> None:
    with pytest.raises(Unreadable, match=re.escape(said)):
        read_cells("hw.ipynb", content.encode())
