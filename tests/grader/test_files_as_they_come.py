"""Files as they come: versions, formats, archives, what is hostile or enormous; and everybody else is graded."""

import gzip
import io
import json
import os
import stat
import tarfile
import time
import zipfile
from collections.abc import Callable, Collection, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from exercises.assignment import Assignment, Student
from grader.cells import Unreadable, read_cells
from grader.finding import find_answers
from grader.reports.tables import status
from grader.sandbox import Sandbox
from grader.settle import Result
from tests.support import DATA
from tests.support.handing_in import RIGHT, a_class, code, grade, hand_in, notebook, outcomes, right, right_cells, text
from tests.support.suites import several

pytestmark = pytest.mark.xdist_group("files-as-they-come")
HW = "hw.ipynb"
INSTEAD = "open it in Jupyter and hand in the notebook itself, the file that ends in .ipynb"
Make = Callable[[Assignment, str], Any]
"""Hands in for a student, into a folder of theirs."""


def file(name: str, content: Callable[[str], str | bytes]) -> Make:
    """Hand in one file, made of the text of the right notebook."""

    def make(assignment: Assignment, student: str) -> None:
        hand_in(assignment, f"{student}/{name}", content(right(assignment, student)))

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
        data, made = json.loads(text), list[dict[str, Any]]()
        for number, cell in enumerate(data["cells"]):
            source, own = cell["source"], cell["metadata"] if keeps else {}
            meta: dict[str, Any] = {**own, "id": f"nWq-7cPBc{number:03d}"}
            if cell["cell_type"] != "code":
                made.append({"cell_type": "markdown", "source": source.splitlines(keepends=True), "metadata": meta})
                continue
            if number == 2:
                source = f'#@title Answer {{ display-mode: "form" }}\n!pip install -q sympy\n{source}'
            ran_by = {"displayName": "Ada L.", "userId": "04104170300566764648"}
            meta |= {
                "colab": {"base_uri": "https://localhost:8080/", "height": 35}, "cellView": "form",
                "executionInfo": {
                    "status": "ok", "timestamp": 1722608125960, "user_tz": -60, "user": ran_by, "elapsed": 5820
                },
                "outputId": "d1c9354e-43db-45ab-c38b-b24bcee97356",
            }  # fmt: skip
            shown = {
                "text/plain": ["0"], "text/latex": "$\\displaystyle 0$",
                "application/vnd.google.colaboratory.intrinsic+json": {"type": "string"},
            }  # fmt: skip
            output = {"output_type": "execute_result", "data": shown, "metadata": {}, "execution_count": number}
            made.append({
                "cell_type": "code", "source": source.splitlines(keepends=True), "metadata": meta,
                "execution_count": number, "outputs": [output],
            })  # fmt: skip
        about: dict[str, Any] = {
            "colab": {"provenance": [{"file_id": "1AbC", "timestamp": 1722608125960}], "toc_visible": True},
            "kernelspec": {"name": "python3", "display_name": "Python 3"}, "language_info": {"name": "python"},
            "accelerator": "GPU", **({"qdot": data["metadata"].get("qdot")} if keeps else {}),
        }  # fmt: skip
        return json.dumps({"nbformat": 4, "nbformat_minor": 0, "metadata": about, "cells": made})

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


def percent(text: str) -> str:
    lines = ["# ---", "# jupyter:", "#   kernelspec:", "#     name: python3", "# ---", ""]
    for cell in json.loads(text)["cells"]:
        own = cell["metadata"].get("qdot")
        if cell["cell_type"] == "code":
            lines += [f"# %% qdot={json.dumps(own)}" if own else "# %%", cell["source"].replace("p1_jacobian", "J"), ""]
        else:
            lines += ["# %% [markdown]", "# " + cell["source"], ""]
    return "\n".join(lines)


def light(text: str) -> str:
    lines = []
    for cell in json.loads(text)["cells"]:
        own = cell["metadata"].get("qdot")
        lines += [f"# + qdot={json.dumps(own)}", cell["source"].replace("p1_jacobian", "J"), "# -", ""] if own else [
            cell["source"] if cell["cell_type"] == "code" else "# " + cell["source"], ""
        ]  # fmt: skip
    return "\n".join(lines)


def markdown(begin: str) -> Callable[[str], str]:
    def made(text: str) -> str:
        lines = ["---", "jupyter: {}", "---", ""]
        for cell in json.loads(text)["cells"]:
            if cell["cell_type"] == "code":
                lines += [begin, cell["source"], "```", ""]
            else:
                lines += [cell["source"], "", "```bash", "ls", "```", ""]
        return "\n".join(lines)

    return made


def myst(text: str) -> str:
    lines = []
    for cell in json.loads(text)["cells"]:
        if cell["cell_type"] == "code":
            own = cell["metadata"].get("qdot")
            head = ["---", "qdot:", f"  part: {own['part']}", "---"] if own else [":tags: [setup]"]
            lines += ["```{code-cell}", *head, cell["source"].replace("p1_jacobian", "J"), "```", ""]
    return "\n".join(lines)


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


def lying_zip(_: str) -> bytes:
    """A zip whose directory says that the notebook in it has ten bytes."""
    made = bytearray(of_members((HW, "{" + " " * 5_000_000 + "}")))
    for mark, at in ((b"PK\1\2", 24), (b"PK\3\4", 22)):
        place = made.index(mark) + at
        made[place : place + 4] = (10).to_bytes(4, "little")
    return bytes(made)


def encrypted(text: str) -> bytes:
    made = bytearray(of_members((HW, text)))
    for mark, at in ((b"PK\1\2", 8), (b"PK\3\4", 6)):
        made[made.index(mark) + at] |= 1
    return bytes(made)


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
    hand_in(assignment, f"{student}/mine.ipynb", right(assignment, student))


def sparse(assignment: Assignment, student: str) -> None:
    with hand_in(assignment, f"{student}/{HW}", "{").open("r+b") as file:
        file.truncate(1_000_000_000)


def two(assignment: Assignment, student: str) -> None:
    hand_in(assignment, f"{student}/hw.ipynb", right(assignment, student)[:500])
    hand_in(assignment, f"{student}/hw (1).ipynb", right(assignment, student))


def with_an_export(assignment: Assignment, student: str) -> None:
    hand_in(assignment, f"{student}/hw.pdf", b"%PDF-1.7")
    hand_in(assignment, f"{student}/hw.html", "<!DOCTYPE html>")
    hand_in(assignment, f"{student}/Week 3/Übung für mich 🦾.ipynb", right(assignment, student))
    hand_in(assignment, f"{student}/Week 3/.ipynb_checkpoints/hw.ipynb", "{}")


def odd_name(assignment: Assignment, student: str) -> None:
    hand_in(assignment, f"{student}/a\nb\x1b[31m.ipynb", "{")


def nested(depth: int) -> Callable[[str], str]:
    return lambda text: '{"cells": [], "metadata": ' + '{"a":' * depth + "1" + "}" * depth + "}"


def one_file_below(assignment: Assignment, student: str) -> None:
    """macOS writes é as e and an accent: the folder's name is not the identifier's bytes, and means the same."""
    hand_in(assignment, "Zoe\u0301/hw.ipynb", right(assignment, student))


ALL, NONE = RIGHT, ["missing"] * 3
CASES: dict[str, tuple[Make, list[str], str]] = {
    "version 3": (file(HW, version_3), ALL, ""),
    "version 4.0": (file(HW, again(nbformat_minor=0)), ALL, ""),
    "saved by Colab": (file(HW, colab(keeps=True)), ALL, ""),
    "saved by Colab, nothing of ours kept": (file("Copy_of_hw.ipynb", colab(keeps=False)), ALL, ""),
    "version 4.5 with ids twice": (file(HW, cells(lambda cell, _: cell.update(id="same"))), ALL, ""),
    "no version": (file(HW, again(nbformat=None, nbformat_minor=None)), ALL, ""),
    "version of the future": (file(HW, again(nbformat=9, nbformat_minor=10**30)), ALL, ""),
    "keys that don't belong": (file(HW, cells(lambda cell, n: cell.update(extra=[n], prompt_number="x"))), ALL, ""),
    "no outputs, no metadata": (
        file(HW, cells(lambda cell, _: [cell.pop(key, None) for key in ("outputs", "metadata", "execution_count")])),
        ALL,
        "",
    ),
    "sources as lists": (file(HW, cells(lambda cell, _: cell.update(source=cell["source"].splitlines(True)))), ALL, ""),
    "metadata null": (file(HW, again(metadata=[1])), ALL, ""),
    "UTF-8 with a mark": (file(HW, lambda text: b"\xef\xbb\xbf" + text.encode()), ALL, ""),
    "UTF-16": (file(HW, lambda text: text.encode("utf-16")), ALL, ""),
    "UTF-16 without a mark": (file(HW, lambda text: text.encode("utf-16-le")), ALL, ""),
    "Latin-1": (file(HW, lambda text: text.replace("# T", "# Übung").encode("latin-1")), ALL, ""),
    "ends of lines of Windows": (
        file(HW, lambda text: json.dumps(json.loads(text), indent=1).replace("\n", "\r\n")),
        ALL,
        "",
    ),
    "outputs of 100 MB": (file(HW, large_outputs), ALL, ""),
    "hw.ipynb.txt": (file("hw.ipynb.txt", str), ALL, ""),
    "hw.json": (file("hw.json", str), ALL, ""),
    "a script": (
        file("hw.py", script),
        ALL,
        "hw.py is no .ipynb file: it is a Python script, which was read as a notebook",
    ),
    "a script with an error": (
        file("hw.py", lambda text: script(text) + "\n\nif True:\nx = (\n"),
        ALL,
        "it is a Python script",
    ),
    "jupytext, percent": (file("hw.py", percent), ALL, "cell 5 is the answer cell of p1_jacobian and sets J"),
    "jupytext, light": (
        file("hw.py", light),
        ALL,
        "is the answer cell of p1_jacobian and sets J, which was read for it",
    ),
    "jupytext, Markdown": (
        file("hw.md", markdown("```python")),
        ALL,
        "hw.md is no .ipynb file: it is Markdown, which was",
    ),
    "jupytext, R Markdown": (file("hw.Rmd", markdown("```{python}")), ALL, "hw.Rmd is no .ipynb file: it is Markdown"),
    "Quarto": (
        file("hw.qmd", markdown("```{python}\n#| echo: false")),
        ALL,
        "hw.qmd is no .ipynb file: it is Markdown",
    ),
    "MyST": (file("hw.md", myst), ALL, "is the answer cell of p1_jacobian and sets J, which was read for it"),
    "a web page": (
        file("hw.html", lambda _: "<!DOCTYPE html><html>"),
        NONE,
        f"hw.html is a web page, such as an export of a notebook; {INSTEAD}",
    ),
    "a PDF": (file("hw.pdf", lambda _: b"%PDF-1.7 \0"), NONE, f"hw.pdf is a PDF, not a notebook; {INSTEAD}"),
    "a PDF called a notebook": (
        file(HW, lambda _: b"%PDF-1.7 \0"),
        NONE,
        f"hw.ipynb is a PDF, not a notebook; {INSTEAD}",
    ),
    "Word": (
        file("hw.docx", lambda _: of_members(("[Content_Types].xml", "<x/>"))),
        NONE,
        f"hw.docx is a document of an office program, not a notebook; {INSTEAD}",
    ),
    "a picture": (file("hw.ipynb", lambda _: b"\x89PNG\r\n"), NONE, "hw.ipynb is a picture, not a notebook"),
    "RAR": (file("hw.ipynb", lambda _: b"Rar!\x1a\7"), NONE, "hw.ipynb is a RAR archive, not a notebook"),
    "zip": (file("hw.zip", zipped("my work/hw.ipynb")), ALL, "hw.zip is an archive; my work/hw.ipynb in it was read"),
    "zip of two": (
        file("hw.zip", zipped("b.ipynb", "a.ipynb")),
        ALL,
        "hw.zip is an archive; a.ipynb in it was read, not b.ipynb",
    ),
    "zip of two, one by its name": (
        file("hw.zip", zipped("a.ipynb", "x/hw.ipynb")),
        ALL,
        "x/hw.ipynb in it was read, not a.ipynb",
    ),
    "zip called a notebook": (file(HW, zipped("hw.ipynb")), ALL, "hw.ipynb is an archive; hw.ipynb in it was read"),
    "tar.gz": (file("hw.tar.gz", targz), ALL, "hw.tar.gz is an archive; work/hw.ipynb in it was read"),
    "zip in a zip": (
        file("hw.zip", lambda t: of_members(("hw.zip", zipped(HW)(t)))),
        NONE,
        "hw.zip has only another archive, which is not opened in it",
    ),
    "empty zip": (
        file("hw.zip", lambda _: of_members()),
        NONE,
        "hw.zip has no notebook in it; hand in the notebook itself",
    ),
    "zip bomb": (file("hw.zip", zip_bomb), NONE, "hw.ipynb in hw.zip is larger than 200 MB; clear its outputs"),
    "tar bomb": (file("hw.tgz", gz_bomb), NONE, "hw.tgz unpacks to more than 200 MB"),
    "lying zip": (file("hw.zip", lying_zip), NONE, "hw.ipynb in hw.zip can't be unpacked: the archive is damaged"),
    "damaged zip": (
        file("hw.zip", lambda t: zipped(HW)(t)[:-40]),
        NONE,
        "hw.zip is an archive that can't be opened: it is damaged",
    ),
    "damaged gzip": (
        file("hw.tgz", lambda t: targz(t)[:300]),
        NONE,
        "hw.tgz is an archive that can't be opened: it is damaged",
    ),
    "encrypted zip": (file("hw.zip", encrypted), NONE, "hw.ipynb in hw.zip needs a password"),
    "links and ../ in a zip": (
        file("hw.zip", zip_with_link),
        ALL,
        "hw.zip is an archive; ../../../other.ipynb in it was read",
    ),
    "forty thousand files": (file("hw.zip", many_members), NONE, "hw.zip has more than 10000 files in it"),
    "a link to the secret": (
        link_to("secret.txt"),
        NONE,
        "hw.ipynb: a symbolic link is not followed; hand in the file itself",
    ),
    "a link to a fellow": (link_to("submitted/honest/hw.ipynb"), NONE, "a symbolic link is not followed"),
    "a folder that is a link": (linked_folder, NONE, "a symbolic link is not followed"),
    "a pipe": (pipe, NONE, "hw.ipynb: a pipe, a socket or a device is not read; hand in the file itself"),
    "a pipe in no folder": (bare_pipe, NONE, "a pipe, a socket or a device is not read; hand in the file itself"),
    "a file beside a pipe": (file_and_pipe, ALL, "hw.ipynb: a pipe, a socket or a device is not read"),
    "a gigabyte": (sparse, NONE, "hw.ipynb is larger than 200 MB; clear its outputs and hand it in again"),
    "a hundred thousand cells": (file(HW, many_cells), ALL, ""),
    "a line of a million": (
        file(HW, cells(lambda cell, n: n or cell.update(source="x" * 10**6, cell_type="code"))),
        ALL,
        "cell 1 stopped at line 1, xxxx",
    ),
    "too much code": (
        file(HW, cells(lambda cell, n: cell.update(source="#" * 21_000_000) if n == 1 else None)),
        NONE,
        "hw.ipynb has more than 20 MB of code in its cells, too much to be run",
    ),
    "nested deep": (file(HW, nested(100_000)), NONE, "hw.ipynb is not a Jupyter notebook: it nests too deeply"),
    "tiny values": (
        file(HW, lambda _: '{"cells": [' + "[]," * 6_100_000 + "[]]}"),
        NONE,
        "hw.ipynb holds too much to be read",
    ),
    "a number of a million digits": (file(HW, again(big=[0])), ALL, ""),
    "empty": (file(HW, lambda _: b" \n"), NONE, "hw.ipynb is empty"),
    "cut off": (file(HW, lambda text: text[:700]), NONE, "hw.ipynb is not a Jupyter notebook, or was cut off (line 1)"),
    "no cells": (file(HW, lambda _: '{"cells": {}}'), NONE, "it is JSON, but has no cells that can be read"),
    "cells that are none": (file(HW, lambda _: '{"cells": [1, null, {"source": 5}, {"cell_type": []}]}'), NONE, ""),
    "random bytes": (
        file(HW, lambda _: bytes(range(256)) * 9),
        NONE,
        "hw.ipynb is not a Jupyter notebook: it is not text",
    ),
    "the first cut off, the second whole": (two, ALL, "(line 1); hw (1).ipynb was graded instead"),
    "exports beside it, in a folder": (with_an_export, ALL, ""),
    "a name with a new line": (
        odd_name,
        NONE,
        "a\N{REPLACEMENT CHARACTER}b\N{REPLACEMENT CHARACTER}[31m.ipynb is not a Jupyter",
    ),
    "another accent": (one_file_below, ALL, ""),
}
STUDENTS = {name: "Zo\u00e9" if name == "another accent" else f"s{number:02d}" for number, name in enumerate(CASES)}


def graded(cases: Collection[str], folder: Path) -> dict[str, Result]:
    """Everybody's result in one class of a student a case, and an honest one."""
    everybody = [*(STUDENTS[case] for case in cases), "honest"]
    assignment = a_class(folder / "hw", [Student(student) for student in everybody])
    hand_in(assignment, "honest/hw.ipynb", right(assignment, "honest"))
    for case in cases:
        make, *_ = CASES[case]
        make(assignment, STUDENTS[case])
    results, looked = grade(assignment, seconds=60)
    assert not looked.strangers and not looked.unsure
    return {**{case: results[STUDENTS[case]] for case in cases}, "honest": results["honest"]}


CLASSES = [list(CASES)[first::8] for first in range(8)]
"""Cases whose files a class hands in: in one class of all of them, whoever is first waits for everybody."""
CLASSES_TAKEN = several(CLASSES[:1], CLASSES)


@pytest.fixture(scope="module")
def results_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], dict[str, Result]]:
    """Return the results of the class in which a case is, graded when it is asked for."""

    @cache
    def of_class(number: int) -> dict[str, Result]:
        return graded(CLASSES[number], tmp_path_factory.mktemp("files"))

    return lambda case: of_class(next(number for number, cases in enumerate(CLASSES) if case in cases))


@pytest.mark.parametrize("case", [case for cases in CLASSES_TAKEN for case in cases])
def test_every_file_gets_its_verdict(case: str, results_of: Callable[[str], dict[str, Result]]) -> None:
    _, due, said = CASES[case]
    result = results_of(case)[case]
    told = [result["obstacle"] or "", *result["notes"]]
    assert outcomes(result) == due, told
    assert result["score"] == (4 if due == ALL else 0)
    assert any(said in one for one in told) if said else not result["staff_notes"], told
    assert not any(ch in one for one in told for ch in "\n\x1b")
    assert due == ALL or status(result) == ("unusable" if said else "graded")


@pytest.mark.parametrize("cases", CLASSES_TAKEN)
def test_a_fellow_student_is_graded_as_ever(
    cases: Sequence[str], results_of: Callable[[str], dict[str, Result]]
) -> None:
    honest = results_of(cases[0])["honest"]
    assert outcomes(honest) == RIGHT and not honest["staff_notes"]


JUPYTEXT = sorted((DATA / "jupytext").iterdir())


@pytest.mark.parametrize("path", JUPYTEXT, ids=lambda path: path.stem)
def test_what_jupytext_and_nbconvert_write_is_read(path: Path) -> None:
    """One notebook as jupytext 1.19.6 and nbconvert 7.17 write it, J for p1_b; the last does not keep metadata."""
    content = read_cells(path.stem, path.read_bytes())
    with Sandbox() as sandbox:
        found = find_answers(content.cells, ["p1.a", "p1.b", "p1.c"], sandbox.run)
    kept = {} if path.stem == "nbconvert.py" else {"p1_b": "[[x, 0], [1, x]]"}
    assert found.run.answers == {"p1_a": "x", "p1_c": "x + 1", **kept}
    assert found.reasons == ({} if kept else {"p1_b": "p1_b is not set anywhere in the notebook"})


def test_a_huge_number_is_read() -> None:
    assert read_cells(HW, b'{"cells": [], "n": ' + b"9" * 10**6 + b"}").cells == ()


def test_hostile_files_end_in_a_sentence_within_seconds() -> None:
    begun = time.process_time()
    for data in (
        b"[" * 10**6,
        b'{"cells":' * 10**5,
        b"{" + b'"a":1,' * 10**6,
        b'{"\\ud800": "\\ud800"}',
        b"\xff\xfe\0",
    ):
        with pytest.raises(Unreadable):
            read_cells(HW, data)
    for source in (
        "(" * 10**5,
        "-" * 10**5 + "1",
        "x" + ".a" * 90_000,
        "1" + "+1" * 90_000,
        "f'" + "{" * 10**5,
        "# %%\n" * 10**5,
    ):
        read_cells("hw.py", source.encode())
    read_cells("hw.md", b"```python\n" * 10**5)
    assert time.process_time() - begun < 20


def test_a_class_goes_on_where_files_can_not_be_read(tmp_path: Path) -> None:
    assignment = a_class(tmp_path / "hw", [Student("s1"), Student("s2")])
    os.mkfifo(hand_in(assignment, "s1/x", "").with_name("hw.ipynb"))
    hand_in(assignment, "s2/hw.ipynb", right(assignment, "s2"))
    results, _ = grade(assignment)
    assert outcomes(results["s2"]) == RIGHT
    assert results["s1"]["obstacle"]


def test_the_largest_of_what_is_bounded(tmp_path: Path) -> None:
    """Ten thousand empty cells, and as many of text that are called as an answer is."""
    assignment = a_class(tmp_path / "hw", [Student("s1")])
    cells = right_cells(assignment, "s1") + [code(""), text("p1_jacobian = 3")] * 10_000
    hand_in(assignment, "s1.ipynb", notebook(assignment, "s1", cells))
    results, _ = grade(assignment, seconds=60)
    assert outcomes(results["s1"]) == RIGHT
