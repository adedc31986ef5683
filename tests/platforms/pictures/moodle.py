"""Moodle, click by click: a quiz is restored and taken, a bank and marks are imported; STACK's questions are previewed.

`MOODLE` is the folder of an installed copy whose database and web server run (`php -S` will do), with the question type
STACK where its pictures are asked for. Formulas are set by the MathJax that its filter names: a copy in Moodle's own
folder where there is no network. A course is made for each run, and stays.
"""

import json
import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Error, Locator, Page  # type: ignore[import-not-found, unused-ignore]

from exercises.exports.items import Choose, Item, Numeric, items
from exercises.exports.markup import decimal
from tests.platforms.pictures.album import PATIENCE, WINDOW, Album, browser, opened
from tests.platforms.pictures.given import ADA, HENRI, KEY, assignment, exported, order
from tests.platforms.pictures.jupyter import DETERMINANT
from tests.platforms.pictures.jupyter import answered as answered_notebook
from tests.support.command import run as qdot

PHP = ("php", "-d", "max_input_vars=5000", str(Path(__file__).with_name("ready.php")))
PASSWORD = "Seen-1-by-1"
OF_GRADES = 1400
"""Pixels of a window in which the grader report has room for its last column beside the menu of the course."""
TEACHER = ("grace", "Grace Hopper", "grace@example.org", "editingteacher")
ADMIN = ("emmy", "Emmy Noether", "emmy@example.org", "admin")
MATHS_SET = """() => {
    if (!document.querySelector('.filter_mathjaxloader_equation')) return true;
    const formulas = document.querySelectorAll('script[type^="math/tex"]').length;
    return Boolean(window.MathJax?.isReady) && formulas > 0 && MathJax.Hub.getAllJax().length >= formulas
        && !document.querySelector('.MathJax_Processing, .MathJax_Processed');
}"""


@dataclass(frozen=True)
class Course:
    """A course that was made for the run."""

    address: str
    number: int
    context: int
    logins: dict[str, str]

    def page(self, path: str) -> str:
        """Return the address of one of Moodle's pages on the course."""
        return f"{self.address}/{path}{self.number}"


def run(software: Path, work: Path) -> None:
    """Take the pictures of the quiz and the gradebook."""
    made = assignment(work / KEY)
    files, asked = exported(made, "moodle", work / "moodle"), list(items(order(made)))
    course = ready(software)
    with browser() as chromium:
        teacher = logged_in(chromium, course, TEACHER[0])
        album = Album("moodle")
        restore(album, teacher, course, files / f"{KEY}.mbz")
        quiz = slots(album, teacher, course)
        for student, turn in ((ADA.id, True), (HENRI.id, False)):
            attempt(album if turn else None, logged_in(chromium, course, student), quiz, asked)
        teacher.set_viewport_size({**WINDOW, "width": OF_GRADES})
        teacher.goto(course.page("grade/report/grader/index.php?id="))
        album.take("grades", teacher, teacher.locator("#user-grades"))


def gradebook(software: Path, work: Path) -> None:
    """Take the picture of marks of notebooks that come into the gradebook by a file."""
    made = assignment(work / KEY)
    qdot("generate", made.folder)
    for student, wrong in ((ADA.id, ""), (HENRI.id, DETERMINANT)):
        file = f"{student}/{KEY}.ipynb"
        handed_out = (made.folder / "released" / file).read_text(encoding="utf-8")
        (made.folder / "submitted" / student).mkdir(parents=True)
        (made.folder / "submitted" / file).write_text(answered_notebook(made, student, handed_out, wrong))
    marks = work / "moodle.csv"
    qdot("grade", made.folder, "--report", f"moodle={marks}")
    course = ready(software)
    with browser() as chromium:
        teacher = logged_in(chromium, course, TEACHER[0])
        uploaded_marks(Album("moodle"), teacher, course, marks)


def bank(software: Path, work: Path) -> None:
    """Take the pictures of the bank."""
    files = exported(assignment(work / KEY), "moodle", work / "moodle")
    course = ready(software)
    with browser() as chromium:
        teacher, album = logged_in(chromium, course, TEACHER[0]), Album("moodle")
        imported(album, teacher, course, files / f"{KEY}.xml")
        drawn(album, teacher, course)


def ready(software: Path) -> Course:
    """Make a course with a teacher and two students."""
    people = [TEACHER, ADMIN, *((one.id, one.name, one.email, "student") for one in (ADA, HENRI))]
    fields = ("login", "name", "email", "role")
    given = {
        "config": str(software / "config.php"),
        "course": "Robot kinematics",
        "people": [{**dict(zip(fields, person, strict=True)), "password": PASSWORD} for person in people],
    }
    done = subprocess.run(PHP, input=json.dumps(given), capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr + done.stdout[-3000:])
    answer: dict[str, Any] = json.loads(done.stdout[done.stdout.index('{"') :])
    print(answer["software"])
    return Course(answer["address"], answer["course"], answer["context"], answer["logins"])


def logged_in(chromium: Browser, course: Course, login: str) -> Page:
    """Return a page on which somebody has logged in."""
    page = opened(chromium)
    page.goto(f"{course.address}/login/index.php")
    page.wait_for_load_state("networkidle")  # its script empties the box of the password
    page.fill("#username", course.logins[login])
    page.fill("#password", PASSWORD)
    with page.expect_navigation():
        page.click("#loginbtn")
    assert "/login/" not in page.url, f"{login} is not let in"
    page.goto(course.page("course/view.php?id="))
    return page


def more(page: Page, name: str) -> None:
    """Open what is behind *More* on a course's or a quiz's page."""
    page.locator(".secondary-navigation").get_by_text("More", exact=True).click()
    page.locator(".secondary-navigation .dropdown-menu a:visible", has_text=name).click()


def chosen(page: Page, name: str) -> None:
    """Choose an entry of the menu on top of a page; Moodle has it as a list of links on some pages."""
    page.wait_for_load_state("networkidle")
    link = page.locator("#region-main").get_by_role("link", name=name, exact=True)
    with page.expect_navigation():
        if link.count():
            link.first.click()
            return
        menu = page.locator(".tertiary-navigation [role=combobox]:visible, .tertiary-navigation select:visible").first
        if menu.evaluate("menu => menu.tagName") == "SELECT":
            menu.focus()
            menu.select_option(label=name)
            menu.press("Enter")
        else:
            menu.click()
            page.get_by_role("option", name=name, exact=True).click()


def uploaded(page: Page, file: Path) -> None:
    """Choose a file of this machine where Moodle asks for one."""
    page.get_by_role("button", name="Choose a file").click()
    page.locator(".fp-repo-name", has_text="Upload a file").click()
    page.set_input_files("input[name=repo_upload_file]", file)
    page.get_by_role("button", name="Upload this file").click()
    page.locator(".filepicker-filename a", has_text=file.name).wait_for()


# --- the quiz ---


def restore(album: Album, page: Page, course: Course, backup: Path) -> None:
    """Restore a quiz into the course."""
    more(page, "Course reuse")
    chosen(page, "Restore")
    uploaded(page, backup)
    album.take("restore", page, page.locator(".tertiary-navigation"), page.get_by_role("button", name="Restore"))
    page.get_by_role("button", name="Restore", exact=True).click()
    page.get_by_role("button", name="Continue").click()
    into = page.locator("form", has=page.get_by_text("Restore into an existing course"))
    assert into.locator("input[type=radio]").first.is_checked()  # the course at hand
    album.take("into", page, into)
    into.get_by_role("button", name="Continue").click()
    page.get_by_role("button", name="Next").click()
    page.get_by_role("button", name="Next").click()
    page.get_by_role("button", name="Perform restore").click()
    page.get_by_text("The course was successfully restored").wait_for()
    page.get_by_role("button", name="Continue").click()


def slots(album: Album, page: Page, course: Course) -> str:
    """Look at the questions of the quiz; return its address."""
    page.goto(course.page("course/view.php?id="))
    page.locator(".activity.quiz a.aalink").first.click()
    address = page.url
    page.locator(".secondary-navigation").get_by_text("Questions", exact=True).click()
    album.take("slots", page, page.locator("#page-content"), tallest=560)
    with page.expect_navigation():
        page.get_by_role("link", name="See questions").first.click()
    page.locator("#categoryquestions tbody tr", has_text="Jacobian by differentiation (p1-001)").first.wait_for()
    return address


def attempt(album: Album | None, page: Page, quiz: str, asked: Sequence[Item]) -> None:
    """Take the quiz: with a mistake in the first question and a wrong option; with all right where no album is."""
    page.goto(quiz)
    page.get_by_role("button", name="Attempt quiz").click()
    for number, item in enumerate(asked):
        if album and number == 0:
            settled(page)
        answered(page, item, wrong=album is not None and number != 1)
        if album and number == 0:
            album.take("asked", page, page.locator(".que"), tallest=1250)
        with page.expect_navigation():
            page.locator("#mod_quiz-next-nav").click()
    page.get_by_role("button", name="Submit all and finish").click()
    page.locator(".modal-footer").get_by_role("button", name="Submit all and finish").click()
    page.wait_for_url("**/review.php*")
    if album:
        page.goto(page.url + "&showall=1")
        settled(page)
        page.locator(".que .feedbacktrigger").first.focus()  # shows what is said of that box
        page.locator(".popover").wait_for()
        album.take("marked", page, page.locator(".que").first, tallest=430, lower=True)
        album.take("feedback", page, page.locator(".que").last, tallest=480, lower=True)


def answered(page: Page, item: Item, wrong: bool) -> None:
    """Answer the question that a page shows."""
    form = item.form
    if isinstance(form, Numeric):
        boxes = page.locator(".que input[type=text]")
        mistaken = next(index for index, field in enumerate(form.fields) if field.wrong)
        for index, field in enumerate(form.fields):
            is_wrong = wrong and index == mistaken
            boxes.nth(index).fill(decimal(field.wrong[0].value if is_wrong else field.value, 3))
    else:
        assert isinstance(form, Choose)
        options = page.locator(".que .answer input[type=radio]")
        wanted = (index for index, option in enumerate(form.options) if option.right != wrong)
        options.nth(next(wanted)).check()


def settled(page: Page) -> None:
    """Wait until formulas are set; where their script did not come, which a busy machine can do, load the page anew."""
    for patience in (20_000, 40_000, PATIENCE):
        page.wait_for_load_state("networkidle")
        try:
            page.wait_for_function(MATHS_SET, polling=500, timeout=patience)
            return
        except Error:
            page.reload()
    raise RuntimeError(f"formulas are not set at {page.url}")


# --- the bank ---


def imported(album: Album | None, page: Page, course: Course, bank: Path) -> None:
    """Import a question bank, and look at it."""
    page.goto(course.page("course/view.php?id="))
    more(page, "Question bank")
    chosen(page, "Import")
    page.get_by_role("radio", name="Moodle XML format").check()
    uploaded(page, bank)
    if album:
        form = page.locator("form.mform")
        album.take("import", page, form, tallest=1000)
    page.locator("#id_submitbutton").click()
    page.get_by_role("button", name="Continue").click()
    page.wait_for_load_state("networkidle")
    if album:
        album.take("bank", page, page.locator("#page-content"), tallest=900)


def drawn(album: Album, page: Page, course: Course) -> None:
    """Make a quiz, and add a random question to it."""
    page.goto(course.page("course/modedit.php?add=quiz&section=1&course="))
    page.fill("#id_name", "A quiz of my own")
    with page.expect_navigation():
        page.get_by_role("button", name="Save and display").click()
    with page.expect_navigation():
        page.locator(".secondary-navigation").get_by_text("Questions", exact=True).click()
    page.wait_for_load_state("networkidle")
    page.locator(".last-add-menu").get_by_role("button", name="Add").or_(page.locator(".last-add-menu a")).first.click()
    page.get_by_text("a random question", exact=True).locator("visible=true").first.click()
    box = page.locator(".modal.show .modal-content")
    chosen_category = box.get_by_placeholder("Type or select...").first
    chosen_category.click()
    chosen_category.fill("Determinant")
    box.get_by_role("option", name="Determinant").locator("visible=true").first.click()
    box.get_by_role("button", name="Apply filters").click()
    box.get_by_text("Determinant of the Jacobian (p1-001)").first.wait_for()
    album.take("random", page, box, tallest=700)
    with page.expect_navigation():
        box.locator("input[name=addrandom]").first.click()
    slot = page.locator("li.slot", has_text="Random")
    assert slot.count() == 1 and "Determinant" in slot.inner_text(), slot.all_inner_texts()


# --- marks ---


def uploaded_marks(album: Album, page: Page, course: Course, marks: Path) -> None:
    """Import a file of marks into a grade item that is made for them."""
    page.goto(course.page("grade/report/grader/index.php?id="))
    chosen(page, "Gradebook setup")
    page.wait_for_load_state("networkidle")
    page.get_by_role("button", name="Add", exact=True).click()
    page.get_by_text("Add grade item", exact=True).click()
    item = page.locator(".modal.show")
    item.locator("[name=itemname]").fill("Homework 6")
    item.locator("[name=grademax]").fill("4")
    with page.expect_navigation():
        item.locator("[data-action=save]").click()
    chosen(page, "Import")
    if "import/csv" not in page.url:
        chosen(page, "CSV file")
    uploaded(page, marks)
    with page.expect_navigation():
        page.get_by_role("button", name="Upload grades").click()
    page.select_option("#id_mapfrom", label="Email address")
    page.select_option("#id_mapto", label="Email address")
    column = page.locator(".fitem", has_text="Homework 6").filter(has_not_text="percent").locator("select").last
    column.select_option(label="Homework 6")
    page.locator("#sticky-footer").evaluate_all("bars => bars.forEach(bar => { bar.style.position = 'static' })")
    album.take("marks", page, page.locator("form.mform"), tallest=1100)
    with page.expect_navigation():
        page.get_by_role("button", name="Upload grades").click()
    page.get_by_text("Grade import success").wait_for()
    page.goto(course.page("grade/report/grader/index.php?id="))
    rows = {one.id: page.locator("#user-grades tr", has_text=one.name).inner_text() for one in (ADA, HENRI)}
    assert "4.00" in rows[ADA.id] and "3.80" in rows[HENRI.id], rows


# --- STACK ---

ANSWER = ".que input[type=text]"


def stack(software: Path, work: Path) -> None:
    """Take the pictures of STACK's question of a determinant: answered with another sign and right, and tested."""
    made = assignment(work / KEY)
    (bank,) = exported(made, "stack", work / "stack").glob("*.xml")
    answers = re.findall(r"ta1: ([^\[;]+);", bank.read_text(encoding="utf-8"))
    right = next(answer for answer in answers if "sin" in answer)  # the only formula that is no matrix
    course = ready(software)
    with browser() as chromium:
        teacher, album = logged_in(chromium, course, TEACHER[0]), Album("stack")
        imported(None, teacher, course, bank)
        chosen(teacher, "Categories")
        teacher.locator("#region-main a", has_text="Determinant").locator("visible=true").first.click()
        row = teacher.locator("#categoryquestions tbody tr")
        row.wait_for()
        album.take("bank", teacher, teacher.locator("#page-content"), tallest=900)
        preview, dashboard = (menu_link(row.first, name) for name in ("Preview", "STACK question dashboard"))
        teacher.goto(preview)
        settled(teacher)
        teacher.locator(ANSWER).fill(f"-({right})")
        teacher.locator(".stackinputfeedback, .validation").first.locator("math, .MathJax").first.wait_for()
        settled(teacher)
        album.take("typed", teacher, teacher.locator(".que"), tallest=520, lower=True)
        finish(teacher)
        album.take("sign", teacher, teacher.locator(".que"), tallest=560, lower=True)
        teacher.goto(dashboard)
        album.take("tests", teacher, teacher.locator("#page-content"))
        in_bulk(album, logged_in(chromium, course, ADMIN[0]), course)


def in_bulk(album: Album, page: Page, course: Course) -> None:
    """Have all question tests of the course run, which STACK lets administrators do."""
    page.goto(f"{course.address}/admin/settings.php?section=qtypesettingstack")
    with page.expect_navigation():
        page.get_by_role("link", name="bulk test script").first.click()
    newest = page.locator(f"summary a[href*='bulktest.php?contextid={course.context}']")
    with page.expect_navigation(wait_until="load"):
        newest.click()
    page.get_by_text("All tests passed!").first.wait_for()
    album.take("bulk", page, page.locator("#page-content"), tallest=500, lower=True)


def menu_link(row: Locator, name: str) -> str:
    """Return where an entry of a question's menu *Edit* leads; Moodle opens some in a window of their own."""
    return str(row.locator(".dropdown-menu a", has_text=name).first.evaluate("link => link.href"))


def finish(page: Page) -> None:
    """Have a previewed question marked."""
    page.get_by_role("button", name="Submit and finish").click()
    settled(page)
