"""The pictures of docs/: what an instructor and a student click in the real programs, done by a browser.

`MOODLE=/path python -m tests.platforms.pictures moodle` exports an assignment, goes through the clicks that the docs
tell, and puts small pictures of what is seen into docs/pictures/. Where a click leads elsewhere than the docs say, it
stops there. It needs Chromium, and Playwright and Pillow in the environment of qdot.

    album       a browser whose pictures are cut, made small and kept
    own         what a student is told, and the site: for the README
    paper       an exam and its marking sheet
    given       the assignment that is exported, and its answers
    moodle      a quiz restored, taken and marked; a question bank; STACK
    jupyter     a student's notebook, jupyterquiz, and nbgrader's formgrader
    scorm       a package, an answer, and what is said of it
    otter       Otter's check in a student's notebook, and a run of its autograder
    prairielearn    a course published and released; a question, and what a submission of it is told
    __main__    the command
"""
