"""PrairieLearn, click by click: an exported course is loaded, published and released, and a student answers a question.

`PRAIRIELEARN` is a checkout, with a database and Redis beside it, as the module tests.platforms.prairielearn needs it.
"""

import subprocess
from pathlib import Path

from playwright.sync_api import Browser, Page  # type: ignore[import-not-found, unused-ignore]

from exercises.exports.bank import bank
from exercises.exports.prairielearn import question_id
from exercises.problem import Problem
from tests.platforms.pictures.album import Album, browser, opened
from tests.platforms.pictures.given import ADA, KEY, assignment, exported, order
from tests.platforms.prairielearn import Site, running

COURSE_INSTANCE = "pl/course_instance/1"
GIT = ("git", "-c", f"user.name={ADA.name}", "-c", f"user.email={ADA.email}")


def questions(software: Path, work: Path) -> None:
    """Take the pictures of a release, of a question, and of a submission whose determinant has another sign."""
    made = assignment(work / KEY)
    course = exported(made, "prairielearn", work / "course")
    for command in (["init", "--quiet"], ["add", "--all"], ["commit", "--quiet", "--message", "qdot"]):
        subprocess.run([*GIT, "-C", str(course), *command], check=True)  # its pages edit courses that git knows
    variant = next(iter(bank(order(made))))
    title = f"{made.title}: {variant.slot.name}"
    assert question_id(made, variant.slot) in {path.name for path in (course / "questions").iterdir()}
    album = Album("prairielearn")
    with running(software, course, work) as site, browser() as chromium:
        site.load()
        released(album, opened(chromium), site)
        answered(album, student(chromium, site), title, variant.problem)


def released(album: Album, page: Page, site: Site) -> None:
    """Publish the course instance, and release the homework, as one of the staff."""
    page.goto(f"{site.address}/{COURSE_INSTANCE}/instructor/instance_admin/assessments")
    page.get_by_role("link", name="Instance settings", exact=True).click()
    page.get_by_role("link", name="Publishing", exact=True).click()
    page.wait_for_load_state("networkidle")
    page.get_by_label("Published", exact=True).check()
    with page.expect_navigation():
        page.get_by_role("button", name="Save").click()
    page.get_by_role("link", name="Assessments", exact=True).first.click()
    page.locator("tr", has_text="HW6").locator("a").first.click()
    page.get_by_role("link", name="Access", exact=True).click()
    page.wait_for_load_state("networkidle")
    page.get_by_role("button", name="Edit").first.click()
    page.get_by_label("Date control").check()
    page.get_by_role("button", name="Save").last.click()
    page.get_by_text("Access control updated successfully").wait_for()
    album.take("release", page, page.locator("main"), tallest=520)


def student(chromium: Browser, site: Site) -> Page:
    """Return the page of a student who has logged in."""
    page = opened(chromium)
    page.goto(f"{site.address}/pl/login")
    page.locator("#dev_uid").fill(ADA.email)
    page.locator("#dev_name").fill(ADA.name)
    with page.expect_navigation():
        page.locator("button[value=dev_login]").click()
    return page


def answered(album: Album, page: Page, title: str, problem: Problem) -> None:
    """Answer the first question of the homework, the determinant with another sign."""
    page.goto(f"{page.url.split('/pl')[0].rstrip('/')}/{COURSE_INSTANCE}")
    page.locator("table a", has_text="Homework 6").click()
    page.locator("table a", has_text=title).click()
    page.locator("mjx-container").first.wait_for()
    page.wait_for_timeout(3000)
    album.take("question", page, page.locator(".question-block"), tallest=800)
    for part in problem.parts:
        text = part.answer.as_typed()
        page.locator(f".question-form [name='{part.name}']").fill(f"-({text})" if part.name == "determinant" else text)
    with page.expect_navigation():
        page.locator("button.question-grade").click()
    page.locator("mjx-container").first.wait_for()
    page.wait_for_timeout(3000)
    album.take("submission", page, page.locator("[data-testid=submission-block]").first, tallest=600)
