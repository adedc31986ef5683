"""The export formats by name: `qdot export DIR --to NAME`, and the table of docs/outlets.md."""

from qdot.exercises.exports.canvas import canvas_zip
from qdot.exercises.exports.export_format import ExportFormat, robots
from qdot.exercises.exports.gradescope import gradescope
from qdot.exercises.exports.moodle import moodle_files
from qdot.exercises.exports.nbgrader import nbgrader
from qdot.exercises.exports.otter import otter
from qdot.exercises.exports.paper import check_sheet, html, latex, missing_for_pdf, pdf
from qdot.exercises.exports.prairielearn import course_files
from qdot.exercises.exports.qti import qti_zip
from qdot.exercises.exports.repositories import github, gitlab
from qdot.exercises.exports.scorm import check_size, missing_scripts, packages
from qdot.exercises.exports.stack import stack_questions

EXPORT_FORMATS = {
    export_format.name: export_format
    for export_format in (
        ExportFormat("github", "Repositories: one that grades, one for each student", "GitHub Actions",
            "GitHub's workflow schema; bash and git, in fresh clones", "student", github, check=robots),
        ExportFormat("gradescope", "An autograder's zip, and notebooks", "Gradescope",
            "a harness with Gradescope's folders, which runs its two scripts", "student", gradescope, check=robots),
        ExportFormat("nbgrader", "A course folder, and notebooks", "nbgrader 0.9",
            "nbgrader itself, from generate_assignment to feedback", "student", nbgrader, check=robots),
        ExportFormat("otter", "A source for `otter assign`, and notebooks", "otter-grader 7",
            "otter assign and otter run", "student", otter, check=robots),
        ExportFormat("gitlab", "Projects: one that grades, one for each student", "GitLab CI",
            "GitLab's CI schema; bash and git, in fresh clones", "student", gitlab, check=robots),
        ExportFormat("moodle", "A quiz that is ready, and a question bank as Moodle XML", "Moodle 4",
            "our checks of its importers' rules", "variant", moodle_files),
        ExportFormat("canvas", "A quiz as QTI 1.2", "Canvas", "text2qti (as the model), our checks", "variant",
            canvas_zip),
        ExportFormat("qti", "A test as a QTI 2.1 package", "what reads QTI 2.1 (TAO, OpenOlat)",
            "citolab-qti-convert; its XML Schema, by hand", "variant", qti_zip),
        ExportFormat("scorm", "Packages that report scores, with the answers in them", "what reads SCORM 1.2 or 2004",
            "scorm-again, in Chromium; the rules of its XML Schemas", "variant", packages, check=check_size,
            missing=missing_scripts),
        ExportFormat("html", "Handouts, exams and keys as web pages", "any browser", "our checks of its structure",
            "student", html, check=check_sheet),
        ExportFormat("pdf", "Handouts, exams and keys as PDF/UA-1, also one for the whole class", "any reader of PDF",
            "Poppler", "student", pdf, check=check_sheet, missing=missing_for_pdf),
        ExportFormat("latex", "Handouts, exams and keys as LaTeX source", "LaTeX with TikZ", "our reader of LaTeX",
            "student", latex, check=check_sheet),
        ExportFormat("stack", "STACK questions in Moodle XML", "Moodle with STACK", "Maxima", "variant",
            stack_questions),
        ExportFormat("prairielearn", "A course folder whose questions call qdot", "PrairieLearn",
            "Mustache; its JSON Schemas, by hand", "variant", course_files, drawn_there=True, check=robots),
    )
}  # fmt: skip
"""All export formats by name."""
