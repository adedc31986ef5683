"""Serve an assignment online (`qdot serve`): students answer in the browser, and the class is graded at once.

This is a Django application. The code that decides on marks is that of `qdot grade`: `marking`, `grading` and the
sandbox. Only this package and `cli/serve_command` import Django; docs/decisions/serve.md explains why.

    settings, apps                  make Django's settings from the options of `qdot serve`
    models, migrations/             the tables of the database
    errors, rates, headers          sentences for wrong requests, limits, and headers of pages for browsers
    assignments, class_list         the assignments, and the students of a class as the roster of an assignment
    sign_in                         sessions and roles
    frame_sessions, frame_requests  sessions in a platform's frame without cookies
    personal_links                  write the links for a mail merge
    scores                          compute a student's result
    judge_process                   the code of the processes that judge typed answers
    marking_online                  mark typed answers and notebooks, and store the marks
    submitting                      store an answer or a notebook, once for each press of a button
    regrading                       mark a class again
    html_pages                      render the pages from templates/serve
    student_pages, staff_pages      the addresses that the pages in the browser call
    practice_pages                  problems to practise on, whose marks are not stored
    urls                            the list of all addresses
    lti/                            launches from a learning platform, its class lists and its gradebook
    exchange, backup_files          write the database as a folder or a backup, and read it back
    forgetting_online               remove a student
    server, queue_process           run the web server and the other processes
"""
