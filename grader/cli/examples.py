"""Examples under each command's help, each a line that can be typed; a test holds them against the program."""

EXAMPLES: dict[str, tuple[tuple[str, str], ...]] = {
    "init": (
        ("qdot init homework", "a first week with a problem of each kind"),
        ("qdot init homework --set singularities --roster canvas.csv", "a ready-made set, for a class from Canvas"),
        ("qdot init --list", "which sets there are"),
    ),
    "families": (
        ("qdot families", "all arms, and what each can be asked"),
        ("qdot families planar-2r", "one of them: why not the rest"),
        ("qdot families ur5 --convention modified-dh", "a real robot, told by a modified table"),
    ),
    "questions": (("qdot questions", "all questions, in the chapter's order"),),
    "show": (
        ("qdot show planar-2r/7", "a problem as a student has it"),
        ("qdot show planar-2r/7 --solution", "with answers and worked steps"),
        ("qdot show elbow-3r/3@full --questions jacobian,determinant --format html > problem.html", "two questions"),
    ),
    "robots": (("qdot robots", "all real robots, with who publishes their numbers"),),
    "solve": (
        ("qdot solve arm.toml", "your own arm: position, Jacobian, determinant, singularities"),
        ("qdot solve panda --time 300", "a real one, with more time"),
        ("qdot solve arm.toml --map arm.svg", "and a picture of where it is singular"),
        ("qdot solve panda --convert dh > arm.toml", "as a file of your own"),
    ),
    "verify": (
        ("qdot verify planar-2r/7", "one problem"),
        ("qdot verify homework", "a class: are its problems and notebooks still what was handed out?"),
        ("qdot verify --family all --count 1000", "a sweep over all families"),
    ),
    "generate": (
        ("qdot generate homework", "a notebook for everybody on the roster"),
        ("qdot generate homework --jobs 2", "on two processes, where memory is short"),
    ),
    "check": (("qdot check velocity.ipynb", "before you hand in: what will be read of each answer"),),
    "compare": (
        ('qdot compare "a1*a2*s2" "a1*a2*sin(theta2)"', "an answer and what is right"),
        ("qdot compare --batch answers.jsonl", "many, a JSON object a line"),
    ),
    "grade": (
        ("qdot grade homework", "what lies in homework/submitted"),
        ("qdot grade homework moodle.zip", "a download of Moodle, Canvas or Gradescope"),
        ("qdot grade homework --diff", "and whose mark moved since the last run"),
        ("qdot grade homework --report canvas=canvas.csv --report xlsx=grades.xlsx", "marks to go elsewhere"),
        ("qdot grade homework late.ipynb --student s001 --report json=-", "one student's, and nothing is written"),
    ),
    "doctor": (("qdot doctor", "what holds students' code on this machine"),),
    "export": (
        ("qdot export homework --to html --sheet exam", "an exam on paper for everybody"),
        ("qdot export homework --to pdf --sheet exam --versions 4", "four versions for an exam hall"),
        ("qdot export homework --to moodle --variants 30", "a quiz and a bank of 30 variants for Moodle"),
    ),
    "report": (
        ("qdot report homework", "a page on the class, from the last results"),
        ("qdot report homework --report csv=-", "the marks once more, for another program"),
    ),
    "upgrade-check": (
        ("qdot upgrade-check homework", "run with the new version: would anything be another?"),
        ("qdot upgrade-check homework --marks", "and would any mark move?"),
    ),
    "forget": (
        ("qdot forget s001 homework --dry-run", "what there is of a student"),
        ("qdot forget ada@example.org course --yes", "removed from every assignment of a course, without asking"),
    ),
    "demo": (("qdot demo", "a class of 30, from problems to feedback, in qdot-demo"),),
    "site build": (
        ("qdot site build", "all families, into qdot-site"),
        ("qdot site build --assignment homework --out course-site", "variants of your own assignment"),
    ),
    "site serve": (("qdot site serve", "look at it at http://127.0.0.1:8000"),),
}  # fmt: skip
"""By the command's whole name: what is typed, and what comes of it."""


def epilog(command: str) -> str:
    """Return what stands under a command's help, its lines as they are."""
    lines = [line for typed, what in EXAMPLES[command] for line in (f"  {typed}", f"      {what}")]
    return "\n".join(["\b", "Examples:", *lines])
