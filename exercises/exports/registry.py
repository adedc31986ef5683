"""The export formats by name, for `qdot export DIR --to NAME` and the table in docs/export-formats.md."""

from functools import partial

from qdot.exercises.common.extras import explain_missing
from qdot.exercises.exports.canvas import export_canvas
from qdot.exercises.exports.common_cartridge import export_common_cartridge
from qdot.exercises.exports.export_format import ExportFormat
from qdot.exercises.exports.gradescope import export_gradescope
from qdot.exercises.exports.moodle import export_moodle
from qdot.exercises.exports.nbgrader import export_nbgrader
from qdot.exercises.exports.otter import export_otter
from qdot.exercises.exports.paper import check_sheet, export_paper
from qdot.exercises.exports.prairielearn import export_prairielearn
from qdot.exercises.exports.qti import export_qti
from qdot.exercises.exports.repositories import export_repositories
from qdot.exercises.exports.scorm import check_size, explain_missing_scripts, export_scorm
from qdot.exercises.exports.stack import export_stack

EXPORT_FORMATS = {
    export_format.name: export_format
    for export_format in (
        ExportFormat("github", "Repositories: one for grading and one for each student", "GitHub Actions", "student",
            partial(export_repositories, platform="github")),
        ExportFormat("gradescope", "An autograder zip, and student notebooks", "Gradescope", "student",
            export_gradescope),
        ExportFormat("nbgrader", "A course folder, and student notebooks", "nbgrader 0.9", "student", export_nbgrader),
        ExportFormat("otter", "A source notebook for `otter assign`, and student notebooks", "otter-grader 7",
            "student", export_otter),
        ExportFormat("gitlab", "Projects: one for grading and one for each student", "GitLab CI", "student",
            partial(export_repositories, platform="gitlab")),
        ExportFormat("moodle", "A ready-made quiz, and a question bank as Moodle XML", "Moodle 4 or 5", "variant",
            export_moodle),
        ExportFormat("canvas", "A quiz as QTI 1.2, for classic quizzes and for New Quizzes", "Canvas", "variant",
            export_canvas),
        ExportFormat("common-cartridge", "Quizzes and question banks as Common Cartridge 1.1",
            "Blackboard, Brightspace, Canvas, Moodle", "variant", export_common_cartridge),
        ExportFormat("qti", "A test as a QTI 2.1 package", "any platform that reads QTI 2.1 (TAO, OpenOlat)", "variant",
            export_qti),
        ExportFormat("scorm", "Packages that report scores; they contain the answers",
            "any platform that reads SCORM 1.2 or 2004", "variant", export_scorm, check=check_size,
            explain_missing=explain_missing_scripts),
        ExportFormat("html", "Handouts, exams and keys as web pages", "any browser", "student",
            partial(export_paper, file_type="html"), check=check_sheet),
        ExportFormat("pdf", "Handouts, exams and keys as PDF/UA-1, for each student or for the class", "any PDF reader",
            "student", partial(export_paper, file_type="pdf"), check=check_sheet,
            explain_missing=partial(explain_missing, "pdf", "PDF")),
        ExportFormat("latex", "Handouts, exams and keys as LaTeX source", "LaTeX with TikZ", "student",
            partial(export_paper, file_type="tex"), check=check_sheet),
        ExportFormat("stack", "STACK questions: a ready-made quiz, and a question bank as Moodle XML",
            "Moodle with STACK", "variant", export_stack),
        ExportFormat("prairielearn", "A course folder whose questions call qdot", "PrairieLearn", "variant",
            export_prairielearn, regenerates_problems=True),
    )
}  # fmt: skip
"""All export formats by name."""
