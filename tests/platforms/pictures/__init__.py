"""The pictures of README and docs that show qdot itself, taken by a browser: `python -m tests.platforms.pictures`.

It needs Chromium, and Playwright and Pillow in qdot's environment. Pictures of learning platforms were taken by hand.

    album       a browser whose pictures are cropped, reduced to few colours and stored in docs/pictures/
    feedback_and_site    a feedback page, and the site
    homework    the assignment in the pictures
    jupyter     a student's notebook in JupyterLab
    __main__    the command
"""
