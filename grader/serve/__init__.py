"""Serve an assignment online (`qdot serve`): students answer in the browser, and the class is graded at once.

A Django application. Everything that decides a mark is what `qdot grade` uses: `marking`, `grading` and the sandbox.
Only this package and `cli/serve_command` import Django; docs/decisions/serve.md says why, and what was compared.

    settings                        make Django's settings from the options of `qdot serve`
    models, migrations/             the tables of the database
    sign_in                         personal links, sessions and roles
    class_list                      the students of a class, as the roster of the assignment
    submitting                      store an answer or a notebook, once for each press of a button
    marking_online                  mark typed answers in worker processes, and notebooks from the queue
    scores                          compute a student's result, and keep what platforms have to be told
    html_pages                      render the pages from templates/serve
    student_pages, staff_pages      the addresses that the pages in the browser call
    lti/                            launches from a learning platform, its class lists and its gradebook
    exchange                        write the database as a folder that `qdot grade` reads, and read it back
"""
